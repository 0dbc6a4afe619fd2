//! Where a mesh goes: unit, up axis, scale, rotation, translation, in this order.

use super::{MAX_COORDINATE, MeshError, TriangleMesh};

/// x' = A x + t, as three rows of [A | t].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine(pub [[f64; 4]; 3]);

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
    pub fn affine(&self) -> Result<Affine, MeshError> {
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
            UpAxis::X => [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            UpAxis::Y => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            UpAxis::Z => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        };
        let factor = self.scale.map(|s| s * self.unit);
        let scaled = Affine(std::array::from_fn(|i| {
            [up[i][0] * factor[i], up[i][1] * factor[i], up[i][2] * factor[i], 0.0]
        }));
        let mut placed = self.rotation.affine()?.after(&scaled);
        for (row, shift) in placed.0.iter_mut().zip(self.translation) {
            row[3] = shift;
        }
        Ok(placed)
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
        let fits = |p: &[f64; 3]| affine.apply(*p).iter().all(|c| c.abs() <= MAX_COORDINATE);
        if let Some(vertex) = mesh.vertices.iter().position(|p| !fits(p)) {
            return Err(MeshError::Setting(format!(
                "the placement moves vertex {vertex} beyond 1e100; check unit, scale and translation"
            )));
        }
        for p in &mut mesh.vertices {
            *p = affine.apply(*p);
        }
        if affine.mirrors() {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        Ok(())
    }
}

impl Rotation {
    /// Rodrigues' formula.
    fn affine(&self) -> Result<Affine, MeshError> {
        let [x, y, z] = self.axis;
        let length = x.hypot(y).hypot(z);
        if !(length.is_finite() && length > 0.0 && self.degrees.is_finite()) {
            return Err(MeshError::Setting(format!(
                "the rotation needs an axis with a length and a finite angle, not {:?} and {}",
                self.axis, self.degrees
            )));
        }
        let [x, y, z] = [x / length, y / length, z / length];
        let (sin, cos) = sin_cos_degrees(self.degrees);
        let rest = 1.0 - cos;
        Ok(Affine([
            [cos + x * x * rest, x * y * rest - z * sin, x * z * rest + y * sin, 0.0],
            [y * x * rest + z * sin, cos + y * y * rest, y * z * rest - x * sin, 0.0],
            [z * x * rest - y * sin, z * y * rest + x * sin, cos + z * z * rest, 0.0],
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

impl Affine {
    /// Leaves all as it is.
    pub const IDENTITY: Affine = Affine([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// The transformed point.
    pub fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
    }

    /// `self` applied to what `first` gives.
    pub fn after(&self, first: &Affine) -> Affine {
        let mut rows = [[0.0; 4]; 3];
        for (row, own) in rows.iter_mut().zip(&self.0) {
            for (k, value) in row.iter_mut().enumerate() {
                *value = (0..3).map(|j| own[j] * first.0[j][k]).sum();
            }
            row[3] += own[3];
        }
        Affine(rows)
    }

    /// Whether it turns left into right.
    pub fn mirrors(&self) -> bool {
        let [a, b, c] = self.0;
        let det = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        det < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(placement: Placement, p: [f64; 3]) -> [f64; 3] {
        placement.affine().unwrap().apply(p)
    }

    #[test]
    fn the_up_axis_becomes_y() {
        for (up_axis, up) in
            [(UpAxis::X, [1.0, 0.0, 0.0]), (UpAxis::Y, [0.0, 1.0, 0.0]), (UpAxis::Z, [0.0, 0.0, 1.0])]
        {
            let placement = Placement { up_axis, ..Default::default() };
            assert_eq!(placed(placement, up), [0.0, 1.0, 0.0]);
            assert!(!placement.affine().unwrap().mirrors());
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
}
