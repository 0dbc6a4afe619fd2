//! Bodies of simple shape: box, sphere, cylinder, capsule, half-space. Their distance, volume, mass and inertia are
//! closed forms; a mesh stands for them only in pictures, in exports and where bodies touch.
//!
//! A primitive stands at the origin, its axis along y. [`PlacedPrimitive`] is one that was scaled, turned and moved.

mod mesh;
mod moments;
mod placed;
mod text;

pub use moments::Moments;
pub use placed::PlacedPrimitive;

use schemars::{JsonSchema, Schema};
use serde::Deserialize;
use std::f64::consts::PI;

/// A body of simple shape; lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(remote = "Self", rename_all = "lowercase", deny_unknown_fields)]
#[schemars(inline, transform = allow_text)]
pub enum Primitive {
    /// A box around the origin.
    Box {
        /// Edges along x, y and z.
        size: [f64; 3],
    },
    /// A ball around the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// A cylinder around the y axis, the origin in its middle.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its length along y.
        height: f64,
    },
    /// All that is nearer than the radius to a part of the y axis, the origin in its middle.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Length of that part: the whole is longer by two radii.
        length: f64,
    },
    /// All below a plane through the origin, a half-space, as far as a box reaches.
    Plane {
        /// Out of the solid; needn't have length 1.
        normal: [f64; 3],
        /// Lowest and highest corner of that box, which isn't placed with the plane. Default: the map's domain.
        #[serde(default)]
        within: Option<[[f64; 3]; 2]>,
    },
}

/// Sizes that can be used, metres.
const SIZES: [f64; 2] = [1e-9, 1e9];

impl Primitive {
    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            Primitive::Box { .. } => "box",
            Primitive::Sphere { .. } => "sphere",
            Primitive::Cylinder { .. } => "cylinder",
            Primitive::Capsule { .. } => "capsule",
            Primitive::Plane { .. } => "plane",
        }
    }

    /// Whether it has no end: a half-space.
    pub fn is_unbounded(&self) -> bool {
        matches!(self, Primitive::Plane { .. })
    }

    /// The same; a plane that says nothing else reaches as far as this box.
    pub fn within(self, region: Option<[[f64; 3]; 2]>) -> Primitive {
        match self {
            Primitive::Plane { normal, within } => Primitive::Plane { normal, within: within.or(region) },
            other => other,
        }
    }

    /// Volume of the solid, m^3; of a plane infinite.
    pub fn volume(&self) -> f64 {
        match *self {
            Primitive::Box { size: [x, y, z] } => x * y * z,
            Primitive::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Primitive::Cylinder { radius, height } => PI * radius * radius * height,
            Primitive::Capsule { radius, length } => PI * radius * radius * (length + 4.0 / 3.0 * radius),
            Primitive::Plane { .. } => f64::INFINITY,
        }
    }

    /// Area of the surface, m^2; of a plane infinite.
    pub fn area(&self) -> f64 {
        match *self {
            Primitive::Box { size: [x, y, z] } => 2.0 * (x * y + y * z + z * x),
            Primitive::Sphere { radius } => 4.0 * PI * radius * radius,
            Primitive::Cylinder { radius, height } => 2.0 * PI * radius * (radius + height),
            Primitive::Capsule { radius, length } => 2.0 * PI * radius * (2.0 * radius + length),
            Primitive::Plane { .. } => f64::INFINITY,
        }
    }

    /// Whether there is such a body.
    ///
    /// # Errors
    /// What is wrong with its size.
    pub fn check(&self) -> Result<(), String> {
        let [least, most] = SIZES;
        let size = |name: &str, length: f64| match (least..=most).contains(&length) {
            true => Ok(()),
            false => {
                Err(format!("a {} with a {name} of {length} m; give {least:e} to {most:e} m", self.name()))
            }
        };
        match *self {
            Primitive::Box { size: edges } => edges.iter().try_for_each(|edge| size("size", *edge)),
            Primitive::Sphere { radius } => size("radius", radius),
            Primitive::Cylinder { radius, height } => size("radius", radius).and(size("height", height)),
            Primitive::Capsule { radius, length } => size("radius", radius).and(size("length", length)),
            Primitive::Plane { normal, within } => check_plane(normal, within),
        }
    }
}

fn check_plane(normal: [f64; 3], within: Option<[[f64; 3]; 2]>) -> Result<(), String> {
    let length = normal.iter().map(|x| x * x).sum::<f64>();
    if !(length.is_finite() && length > 0.0) {
        return Err(format!("a plane with a normal of {normal:?}; give one with a length, as [0, 1, 0]"));
    }
    let is_box = |[low, high]: [[f64; 3]; 2]| {
        (0..3).all(|axis| low[axis] < high[axis] && low[axis].abs().max(high[axis].abs()) <= SIZES[1])
    };
    match within {
        Some(corners) if !is_box(corners) => Err(format!(
            "a plane within {corners:?}, which is no box; give the lowest and the highest corner"
        )),
        _ => Ok(()),
    }
}

/// Documents may have the command line's text as well.
fn allow_text(schema: &mut Schema) {
    if let Some(list) = schema.get_mut("oneOf").and_then(|list| list.as_array_mut()) {
        list.push(serde_json::json!({
            "type": "string",
            "description": "The same as on the command line, as \"sphere:0.5\"."
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::bake;
    use crate::input::{InputSettings, from_shape};
    use crate::parameters::Parameters;
    use crate::rows::positions;
    use crate::sdf::band::BandCells;
    use crate::watch::Watch;
    use volmap_runtime::Grid;
    use volmap_runtime::layout::Nodes;

    fn parameters(json: &str) -> Parameters {
        serde_json::from_str(json).unwrap()
    }

    /// At every node the closed form, inverted and moved as it was asked for, to the last bit.
    #[test]
    fn maps_hold_the_closed_form_at_their_nodes() {
        for given in [
            r#"{"shape": "box:1,0.6,0.8", "rotate": "1,1,0,30", "translate": "1,2,3"}"#,
            r#"{"shape": "sphere:0.5", "invert": true}"#,
            r#"{"shape": "cylinder:0.3,0.9", "up": "z", "thickness": 0.05}"#,
            r#"{"shape": {"capsule": {"radius": 0.2, "length": 0.7}}, "scale": 2, "unit": 0.5}"#,
            r#"{"shape": {"plane": {"normal": [0, 1, 0.5]}}, "domain": [-1, -1, -1, 1, 1, 1]}"#,
        ] {
            let json =
                given.replacen('{', r#"{"support_radius": 0.2, "cell_size": 0.1, "precision": "f64","#, 1);
            let recipe = parameters(&json).recipe();
            let input = from_shape(recipe.input.shape.unwrap(), &recipe.input).unwrap();
            let placed = input.placed_shape.unwrap();
            let baked = bake(input, &recipe.bake, &Watch::default()).unwrap();
            assert_eq!(
                baked.summary.warnings.len(),
                usize::from(recipe.bake.map.thickness != 0.0),
                "{given}"
            );
            let asset = &baked.asset;
            let cells = BandCells { band: asset.band_cells.clone(), solid: asset.solid_cells.clone() };
            let grid = Grid::from(asset.grid);
            let nodes = Nodes::new(grid.resolution, &cells.band).unwrap();
            let sign = if recipe.bake.map.invert { -1.0 } else { 1.0 };
            let distances = asset.signed_distance.to_f64();
            assert!(distances.len() > 1000);
            for (x, found) in positions(&nodes, &grid).zip(distances) {
                assert_eq!(found, sign * placed.distance(x) - recipe.bake.map.thickness, "{given} at {x}");
            }
        }
    }

    #[test]
    fn bakes_tell_the_closed_forms_and_their_shape() {
        let recipe = parameters(r#"{"shape": "sphere:0.5", "support_radius": 0.2}"#).recipe();
        let input = from_shape(recipe.input.shape.unwrap(), &recipe.input).unwrap();
        let baked = bake(input, &recipe.bake, &Watch::default()).unwrap();
        let found = &baked.summary.diagnosis;
        assert_eq!((found.volume, found.area), (PI / 6.0, PI));
        let restored = crate::provenance::shape(&baked.asset).unwrap().unwrap();
        assert_eq!(restored.shape, recipe.input.shape);
        assert_eq!(crate::provenance::input_settings(&baked.asset).unwrap().shape, None);
        assert_eq!(crate::provenance::other_mesh(&baked.asset, &restored.source), None);
    }

    #[test]
    fn planes_need_a_box_to_lie_in() {
        let recipe = parameters(r#"{"shape": "plane:0,1,0"}"#).recipe();
        let error =
            from_shape(recipe.input.shape.unwrap(), &InputSettings::default()).unwrap_err().to_string();
        assert!(error.contains("a plane has no end") && error.contains("`domain`"), "{error}");
    }

    #[test]
    fn keys_follow_the_shape_and_those_of_meshes_stay() {
        let key = |json: &str| {
            crate::content_key::identify("none".as_ref(), parameters(json).recipe().effective()).unwrap().key
        };
        let keys =
            [r#"{"shape": "sphere:1"}"#, r#"{"shape": "sphere:2"}"#, r#"{"shape": "sphere:1", "scale": 2}"#];
        let keys = keys.map(key);
        assert!(keys[0] != keys[1] && keys[0] != keys[2]);
        assert_eq!(key(r#"{"shape": {"sphere": {"radius": 1}}}"#), keys[0]);
        assert!(!Parameters::default().recipe().effective().contains_key("shape"));
    }
}
