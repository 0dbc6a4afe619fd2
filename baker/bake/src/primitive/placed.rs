//! A primitive in the world: its exact signed distance and its box.

use super::Primitive;
use crate::error::Error;
use glam::{DMat3, DVec2, DVec3};
use volmap_formats::mesh::Placement;

/// A primitive that was scaled, turned and moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedPrimitive {
    /// With its final size; of a plane the normal in the world, of length 1.
    pub(super) shape: Primitive,
    /// From its own axes to the world's: orthogonal.
    pub(super) turn: DMat3,
    /// Its origin.
    pub(super) centre: DVec3,
}

/// Parts by which scales may differ that are meant to be the same.
const SAME: f64 = 1e-12;

impl PlacedPrimitive {
    /// Places a primitive.
    ///
    /// # Errors
    /// A placement that can't be used, or after which it isn't one of its kind; a plane that doesn't say how far it
    /// reaches.
    pub fn new(shape: Primitive, placement: &Placement) -> Result<PlacedPrimitive, Error> {
        shape.check().map_err(|reason| Error::setting("shape", reason))?;
        let affine = placement.affine()?;
        let [x, y, z] = [affine.x_axis, affine.y_axis, affine.z_axis].map(DVec3::from);
        let scale = DVec3::new(x.length(), y.length(), z.length());
        let turn = DMat3::from_cols(x / scale.x, y / scale.y, z / scale.z);
        let centre = affine.translation;
        let shape = scaled(shape, scale, turn)?;
        shape.check().map_err(|reason| Error::setting("scale", format!("makes {reason}")))?;
        let turn = if shape.is_unbounded() { DMat3::IDENTITY } else { turn };
        Ok(PlacedPrimitive { shape, turn, centre })
    }

    /// What it is, with its final size.
    pub fn shape(&self) -> &Primitive {
        &self.shape
    }

    /// Its origin in the world, metres.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// From its own axes to the world's: an orthogonal matrix.
    pub fn turn(&self) -> DMat3 {
        self.turn
    }

    /// Signed distance, metres, negative in the solid; exact but for rounding.
    pub fn distance(&self, point: DVec3) -> f64 {
        // Where the axes aren't turned, products with 0 and 1 change nothing.
        let at = self.turn.transpose() * (point - self.centre);
        match self.shape {
            Primitive::Box { size } => {
                let outside = at.abs() - 0.5 * DVec3::from(size);
                outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0)
            }
            Primitive::Sphere { radius } => at.length() - radius,
            Primitive::Cylinder { radius, height } => {
                let outside = DVec2::new(DVec2::new(at.x, at.z).length() - radius, at.y.abs() - 0.5 * height);
                outside.max(DVec2::ZERO).length() + outside.max_element().min(0.0)
            }
            Primitive::Capsule { radius, length } => {
                let along = at.y.clamp(-0.5 * length, 0.5 * length);
                (at - DVec3::Y * along).length() - radius
            }
            Primitive::Plane { normal, .. } => at.dot(DVec3::from(normal)),
        }
    }

    /// The shape whose surface lies so far out of this one's, metres; below 0 within it. None if that is no shape of
    /// the kind, as of a box with rounded edges, or if nothing is left.
    pub fn offset(&self, out: f64) -> Option<PlacedPrimitive> {
        let (mut shape, mut centre) = (self.shape, self.centre);
        match &mut shape {
            Primitive::Box { size } if out <= 0.0 => size.iter_mut().for_each(|edge| *edge += 2.0 * out),
            Primitive::Cylinder { radius, height } if out <= 0.0 => {
                *radius += out;
                *height += 2.0 * out;
            }
            Primitive::Box { .. } | Primitive::Cylinder { .. } => return None,
            Primitive::Sphere { radius } | Primitive::Capsule { radius, .. } => *radius += out,
            Primitive::Plane { normal, .. } => centre += out * DVec3::from(*normal),
        }
        shape.check().is_ok().then_some(PlacedPrimitive { shape, turn: self.turn, centre })
    }

    /// Lowest and highest corner of its box; of a plane, of the box in which it lies.
    pub fn bounds(&self) -> [DVec3; 2] {
        let round = |radius: f64, half: f64| {
            let axis = self.turn.y_axis.abs();
            half * axis + radius * (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt)
        };
        let half = match self.shape {
            Primitive::Box { size } => {
                let [x, y, z] = [self.turn.x_axis, self.turn.y_axis, self.turn.z_axis].map(DVec3::abs);
                0.5 * (size[0] * x + size[1] * y + size[2] * z)
            }
            Primitive::Sphere { radius } => DVec3::splat(radius),
            Primitive::Cylinder { radius, height } => round(radius, 0.5 * height),
            Primitive::Capsule { radius, length } => {
                0.5 * length * self.turn.y_axis.abs() + DVec3::splat(radius)
            }
            Primitive::Plane { within, .. } => {
                return within.unwrap_or_default().map(DVec3::from);
            }
        };
        [self.centre - half, self.centre + half]
    }

    /// Area of the surface, m^2; of a plane about that within its box.
    pub fn area(&self) -> f64 {
        let Primitive::Plane { normal, .. } = self.shape else { return self.shape.area() };
        let [low, high] = self.bounds();
        let size = high - low;
        let faces = DVec3::new(size.y * size.z, size.z * size.x, size.x * size.y);
        // Each face is as large as the plane's part below it, seen along an axis.
        (faces / DVec3::from(normal).abs()).min_element()
    }
}

fn scaled(shape: Primitive, scale: DVec3, turn: DMat3) -> Result<Primitive, Error> {
    let same = |a: f64, b: f64| (a - b).abs() <= SAME * a;
    let alike = |is: bool, axes: &str| match is {
        true => Ok(()),
        false => Err(Error::setting(
            "scale",
            format!(
                "a {} stays one only if it is scaled alike along {axes}; give its size instead",
                shape.name()
            ),
        )),
    };
    let evenly = same(scale.x, scale.y) && same(scale.x, scale.z);
    Ok(match shape {
        Primitive::Box { size } => Primitive::Box { size: (DVec3::from(size) * scale).to_array() },
        Primitive::Sphere { radius } => {
            alike(evenly, "all axes")?;
            Primitive::Sphere { radius: radius * scale.x }
        }
        Primitive::Cylinder { radius, height } => {
            alike(same(scale.x, scale.z), "the axes across it")?;
            Primitive::Cylinder { radius: radius * scale.x, height: height * scale.y }
        }
        Primitive::Capsule { radius, length } => {
            alike(evenly, "all axes")?;
            Primitive::Capsule { radius: radius * scale.x, length: length * scale.y }
        }
        Primitive::Plane { normal, within } => {
            if within.is_none() {
                let reason = "a plane has no end; give the box that the map is for by `domain`";
                return Err(Error::setting("shape", reason));
            }
            // Normals go by the inverse of the scale.
            let normal = turn * (DVec3::from(normal).normalize() / scale);
            Primitive::Plane { normal: normal.normalize().to_array(), within }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_formats::mesh::{Rotation, UpAxis};

    fn placed(text: &str, placement: &Placement) -> PlacedPrimitive {
        PlacedPrimitive::new(text.parse().unwrap(), placement).unwrap()
    }

    #[test]
    fn distances_are_those_that_are_known() {
        let asis = Placement::default();
        for (text, point, distance) in [
            ("box:2,4,6", [0.0, 0.0, 0.0], -1.0),
            ("box:2,4,6", [1.5, 0.0, 2.0], 0.5),
            ("box:2,4,6", [4.0, 6.0, 3.0], 5.0),
            ("box:2,4,6", [3.0, 4.0, 4.0], 3.0),
            ("sphere:2", [0.0, 3.0, 4.0], 3.0),
            ("sphere:2", [0.0, 0.0, 0.0], -2.0),
            ("cylinder:1,2", [4.0, 5.0, 0.0], 5.0),
            ("cylinder:1,2", [0.0, 0.25, 0.0], -0.75),
            ("cylinder:1,2", [0.6, 0.0, 0.8], 0.0),
            ("capsule:1,2", [3.0, 5.0, 0.0], 4.0),
            ("capsule:1,2", [0.0, 0.5, 0.5], -0.5),
            ("plane:0,0,2,-9,-9,-9,9,9,9", [1.0, 2.0, 3.0], 3.0),
        ] {
            let found = placed(text, &asis).distance(point.into());
            assert!((found - distance).abs() < 1e-15, "{text} at {point:?}: {found}");
        }
    }

    /// An offset shape is nearer by the offset, where both are all round; there is none with rounded edges.
    #[test]
    fn offsets_move_the_surface() {
        let points =
            (0..500).map(|n| DVec3::new(f64::from(n % 13), f64::from(n % 17), f64::from(n % 19)) / 9.0);
        for (text, out) in [
            ("sphere:0.7", 0.2),
            ("sphere:0.7", -0.3),
            ("capsule:0.5,2", 0.2),
            ("capsule:0.5,2", -0.2),
            ("plane:1,2,3,-9,-9,-9,9,9,9", 0.4),
            ("box:1,2,3", -0.2),
            ("cylinder:0.5,2", -0.2),
        ] {
            let shape = placed(text, &Placement::default());
            let moved = shape.offset(out).unwrap();
            for point in points.clone() {
                let expected = shape.distance(point) - out;
                let found = moved.distance(point);
                // Outside, boxes and cylinders have sharp edges again.
                let is_known = expected <= 0.0 || !(text.starts_with("box") || text.starts_with("cyl"));
                assert!(!is_known || (found - expected).abs() < 1e-14, "{text} {out} at {point}: {found}");
                assert!(
                    (found <= 0.0) == (expected <= 0.0) || found.abs() < 1e-14,
                    "{text} {out} at {point}"
                );
            }
        }
        for (text, out) in
            [("box:1,2,3", 0.1), ("cylinder:0.5,2", 0.1), ("box:1,2,3", -0.5), ("sphere:1", -1.0)]
        {
            assert_eq!(placed(text, &Placement::default()).offset(out), None, "{text} {out}");
        }
    }

    /// What is placed is as far from a point that is placed with it, times the scale; boxes hold it and touch it.
    #[test]
    fn placing_keeps_distances() {
        let rotation = Rotation { axis: [1.0, -2.0, 0.5], degrees: 77.0 };
        let placement = Placement {
            unit: 0.5,
            up_axis: UpAxis::Z,
            scale: [-3.0, 3.0, 3.0],
            rotation,
            translation: [4.0, 5.0, -6.0],
        };
        let affine = placement.affine().unwrap();
        for text in
            ["box:1,2,3", "sphere:0.7", "cylinder:0.5,2", "capsule:0.5,2", "plane:1,2,3,-9,-9,-9,9,9,9"]
        {
            let (own, placed) = (placed(text, &Placement::default()), placed(text, &placement));
            let [low, high] = placed.bounds();
            let mut nearest = [f64::INFINITY; 6];
            for n in 0..4000 {
                let at = DVec3::new(f64::from(n * 7 % 41), f64::from(n * 11 % 43), f64::from(n * 13 % 47));
                let at = (at - 20.0) / 8.0;
                let world = affine.transform_point3(at);
                let [a, b] = [own.distance(at), placed.distance(world)];
                assert!((1.5 * a - b).abs() < 1e-12, "{text}: {a} {b}");
                // A step to the surface against the gradient.
                let slope = |axis: DVec3| (placed.distance(world + 1e-6 * axis) - b) / 1e-6;
                let surface = world - b * DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
                let inside = [surface - low, high - surface].map(|gap| gap.to_array());
                for (nearest, gap) in nearest.iter_mut().zip(inside.as_flattened()) {
                    *nearest = nearest.min(*gap);
                }
            }
            if !text.starts_with("plane") {
                assert!(nearest.iter().all(|gap| (-1e-4..0.2).contains(gap)), "{text}: {nearest:?}");
            }
        }
    }

    #[test]
    fn scales_that_make_another_shape_are_refused() {
        let flat = Placement { scale: [1.0, 2.0, 1.0], ..Placement::default() };
        for text in ["sphere:1", "capsule:1,1"] {
            let error = PlacedPrimitive::new(text.parse().unwrap(), &flat).unwrap_err().to_string();
            assert!(error.contains("scale: a ") && error.contains("scaled alike along all axes"), "{error}");
        }
        assert_eq!(placed("cylinder:1,1", &flat).shape, Primitive::Cylinder { radius: 1.0, height: 2.0 });
        assert_eq!(placed("box:1,1,1", &flat).shape, Primitive::Box { size: [1.0, 2.0, 1.0] });
        let tiny = Placement { scale: [1e-12; 3], ..Placement::default() };
        let error = PlacedPrimitive::new("sphere:1".parse().unwrap(), &tiny).unwrap_err().to_string();
        assert!(error.contains("scale: makes a sphere with a radius of"), "{error}");
        let plane = PlacedPrimitive::new("plane:0,1,0".parse().unwrap(), &flat).unwrap_err().to_string();
        assert!(plane.contains("`domain`"), "{plane}");
    }
}
