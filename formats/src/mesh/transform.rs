//! Where a mesh goes: unit, up axis, scale, rotation, translation, in this order.

use glam::{DAffine3, DMat3, DVec3};

use super::TriangleMesh;
use super::error::MeshError;
use super::raw::MAX_COORDINATE;

/// Which axis of the file points up. The mesh is rotated (never mirrored) so that it becomes +y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// (x, y, z) -> (-y, x, z): a quarter turn about z.
    X,
    /// As it is.
    #[default]
    Y,
    /// (x, y, z) -> (x, z, -y): a quarter turn about x, as glTF exporters do it.
    Z,
}

/// A rotation about an axis through the origin, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Need not have length 1.
    pub axis: [f64; 3],
    /// Counter-clockwise as seen from the axis' tip.
    pub degrees: f64,
}

/// How a mesh is placed in the world. The default leaves it as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Metres per unit of the file.
    pub unit: f64,
    /// The file's up axis, which becomes +y.
    pub up_axis: UpAxis,
    /// Along x, y and z, after the up axis was applied. Negative values mirror: the winding is
    /// then flipped, so that normals still point outward.
    pub scale: [f64; 3],
    /// After scaling.
    pub rotation: Rotation,
    /// After rotating, in metres.
    pub translation: [f64; 3],
}

impl Default for Placement {
    fn default() -> Placement {
        Placement {
            unit: 1.0,
            up_axis: UpAxis::Y,
            scale: [1.0; 3],
            rotation: Rotation { axis: [0.0, 1.0, 0.0], degrees: 0.0 },
            translation: [0.0; 3],
        }
    }
}

impl Placement {
    /// The placement as one transform.
    ///
    /// # Errors
    /// [`MeshError::Setting`] if the unit isn't positive, a scale is 0, the axis has no length, or
    /// a number isn't finite.
    pub fn affine(&self) -> Result<DAffine3, MeshError> {
        let setting = |text: String| Err(MeshError::Setting(text));
        if !(self.unit.is_finite() && self.unit > 0.0) {
            return setting(format!("the unit must be positive, not {}", self.unit));
        }
        if !self.scale.iter().all(|s| s.is_finite() && *s != 0.0) {
            return setting(format!("the scale must be finite and not 0, not {:?}", self.scale));
        }
        if !self.translation.iter().all(|t| t.is_finite()) {
            return setting(format!("the translation must be finite, not {:?}", self.translation));
        }
        let up = match self.up_axis {
            UpAxis::X => DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z),
            UpAxis::Y => DMat3::IDENTITY,
            UpAxis::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        };
        let scale = DMat3::from_diagonal(DVec3::from(self.scale) * self.unit);
        let matrix = self.rotation.matrix()? * (scale * up);
        Ok(DAffine3::from_mat3_translation(matrix, self.translation.into()))
    }

    /// Places a mesh.
    ///
    /// # Errors
    /// As for [`Placement::affine`], or if a coordinate would exceed [`MAX_COORDINATE`]; the mesh
    /// is then unchanged.
    pub fn apply(&self, mesh: &mut TriangleMesh) -> Result<(), MeshError> {
        if *self == Placement::default() {
            return Ok(());
        }
        let affine = self.affine()?;
        let place = |&p: &[f64; 3]| affine.transform_point3(p.into()).to_array();
        let fits = |p: &[f64; 3]| place(p).iter().all(|c| c.abs() <= MAX_COORDINATE);
        if let Some(vertex) = mesh.vertices.iter().position(|p| !fits(p)) {
            return Err(MeshError::Setting(format!(
                "the placement moves vertex {vertex} beyond 1e100; check unit, scale and translation"
            )));
        }
        for p in &mut mesh.vertices {
            *p = place(p);
        }
        if affine.matrix3.determinant() < 0.0 {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        Ok(())
    }
}

impl Rotation {
    /// Rodrigues' formula. Unlike glam's own it is exact for quarter turns, and of the same bits whatever library gives
    /// glam its sine.
    fn matrix(&self) -> Result<DMat3, MeshError> {
        let axis = DVec3::from(self.axis);
        let length = axis.x.hypot(axis.y).hypot(axis.z);
        if !(length.is_finite() && length > 0.0 && self.degrees.is_finite()) {
            return Err(MeshError::Setting(format!(
                "the rotation needs an axis with a length and a finite angle, not {:?} and {}",
                self.axis, self.degrees
            )));
        }
        let DVec3 { x, y, z } = axis / length;
        let (sin, cos) = sin_cos_degrees(self.degrees);
        let rest = 1.0 - cos;
        Ok(DMat3::from_cols_array(&[
            cos + x * x * rest,
            y * x * rest + z * sin,
            z * x * rest - y * sin,
            x * y * rest - z * sin,
            cos + y * y * rest,
            z * y * rest + x * sin,
            x * z * rest + y * sin,
            y * z * rest - x * sin,
            cos + z * z * rest,
        ]))
    }
}

/// Exact for quarter turns.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => turn.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn placed(placement: Placement, p: [f64; 3]) -> [f64; 3] {
        placement.affine().unwrap().transform_point3(p.into()).to_array()
    }

    #[test]
    fn the_up_axis_becomes_y() {
        for (up_axis, up) in
            [(UpAxis::X, [1.0, 0.0, 0.0]), (UpAxis::Y, [0.0, 1.0, 0.0]), (UpAxis::Z, [0.0, 0.0, 1.0])]
        {
            let placement = Placement { up_axis, ..Default::default() };
            assert_eq!(placed(placement, up), [0.0, 1.0, 0.0]);
            assert!(placement.affine().unwrap().matrix3.determinant() > 0.0);
        }
    }

    #[test]
    fn steps_come_in_the_stated_order() {
        let placement = Placement {
            unit: 0.001,
            up_axis: UpAxis::Z,
            scale: [2.0, 3.0, 4.0],
            rotation: Rotation { axis: [0.0, 0.0, 5.0], degrees: 90.0 },
            translation: [10.0, 20.0, 30.0],
        };
        // Unit: (1, 2, 3) -> up: (1, 3, -2) -> scale: (2, 9, -8) -> turn: (-9, 2, -8).
        assert_eq!(placed(placement, [1000.0, 2000.0, 3000.0]), [1.0, 22.0, 22.0]);
    }

    #[test]
    fn a_mirror_flips_the_winding() {
        let mut mesh = TriangleMesh {
            vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
        };
        let placement = Placement { scale: [-1.0, 1.0, 1.0], ..Default::default() };
        placement.apply(&mut mesh).unwrap();
        assert_eq!(mesh.triangles, [[0, 2, 1]]);
        assert_eq!(mesh.vertices[1], [-1.0, 0.0, 0.0]);
    }

    #[test]
    fn bad_settings_are_errors() {
        let bad = [
            Placement { unit: 0.0, ..Default::default() },
            Placement { scale: [1.0, 0.0, 1.0], ..Default::default() },
            Placement { translation: [f64::NAN, 0.0, 0.0], ..Default::default() },
            Placement { rotation: Rotation { axis: [0.0; 3], degrees: 1.0 }, ..Default::default() },
        ];
        for placement in bad {
            assert!(placement.affine().is_err(), "{placement:?}");
        }
    }

    /// The same in plain arrays, with every operation in the order that assets have always been made with.
    fn placed_in_plain_arrays(placement: &Placement, p: [f64; 3]) -> [f64; 3] {
        let up = match placement.up_axis {
            UpAxis::X => [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            UpAxis::Y => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            UpAxis::Z => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        };
        let [x, y, z] = placement.rotation.axis;
        let length = x.hypot(y).hypot(z);
        let [x, y, z] = [x / length, y / length, z / length];
        let (s, c) = sin_cos_degrees(placement.rotation.degrees);
        let e = 1.0 - c;
        let turn = [
            [c + x * x * e, x * y * e - z * s, x * z * e + y * s],
            [y * x * e + z * s, c + y * y * e, y * z * e - x * s],
            [z * x * e - y * s, z * y * e + x * s, c + z * z * e],
        ];
        let scaled = |i: usize, k: usize| up[i][k] * (placement.scale[i] * placement.unit);
        let entry =
            |row: [f64; 3], k: usize| row[0] * scaled(0, k) + row[1] * scaled(1, k) + row[2] * scaled(2, k);
        let matrix = turn.map(|row| [0, 1, 2].map(|k| entry(row, k)));
        std::array::from_fn(|i| {
            let row = matrix[i];
            row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + placement.translation[i]
        })
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), Just(1.0), Just(-1.0), -1e3..1e3, 1e-30..1e-3, 1e6..1e40]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn every_bit_is_that_of_the_plain_formula(
            (unit, up) in (prop_oneof![Just(1.0), Just(0.001), Just(0.0254), 1e-3..1e3], 0..3usize),
            scale in [number(), number(), number()],
            (axis, degrees) in ([number(), number(), number()],
                prop_oneof![Just(0.0), Just(90.0), Just(180.0), Just(-90.0), -720.0..720.0]),
            translation in [number(), number(), number()],
            p in [number(), number(), number()],
        ) {
            let up_axis = [UpAxis::X, UpAxis::Y, UpAxis::Z][up];
            let scale = scale.map(|s| if s == 0.0 { -1.0 } else { s });
            let rotation = Rotation { axis, degrees };
            let placement = Placement { unit, up_axis, scale, rotation, translation };
            prop_assume!(placement.affine().is_ok());
            let expected = placed_in_plain_arrays(&placement, p).map(f64::to_bits);
            prop_assert_eq!(placed(placement, p).map(f64::to_bits), expected, "{:?}", placement);
        }
    }
}
