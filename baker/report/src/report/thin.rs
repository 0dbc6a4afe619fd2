//! Thin walls and narrow gaps: where a map can leak.
//!
//! The largest ball that touches the surface at a point and holds no other part of it is as wide as the wall (inside)
//! or the gap (outside) there. It is found by shrinking (Ma, Bae and Choi 2012, "3D medial axis point approximation
//! using nearest neighbors and the normal field"), which needs closest points and nothing else.

use super::model::{Model, Solid};
use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use volmap_bake::sdf::sign_comparison::spread_over_area;
use volmap_bake::watch::{Cancelled, Watch};

/// Balls stop shrinking when the radius changes by less than this part.
const ENOUGH: f64 = 1e-3;
const STEPS: usize = 30;
/// Cosine of the largest angle between the normal and the way to the other side, and between the two normals: beyond
/// it, it is no other side but the surface itself going on around an edge.
const FACING: f64 = 0.5;

/// What is narrow at a point of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Thin {
    /// Nothing.
    Nothing,
    /// A gap narrower than the support radius.
    GapBelowRadius,
    /// A gap narrower than a cell.
    GapBelowCell,
    /// A wall thinner than the support radius.
    WallBelowRadius,
    /// A wall thinner than a cell.
    WallBelowCell,
}

impl Thin {
    /// The worst last.
    pub const ALL: [Thin; 5] =
        [Thin::Nothing, Thin::GapBelowRadius, Thin::GapBelowCell, Thin::WallBelowRadius, Thin::WallBelowCell];

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Thin::Nothing => "nothing thin",
            Thin::GapBelowRadius => "gap narrower than the support radius",
            Thin::GapBelowCell => "gap narrower than a cell",
            Thin::WallBelowRadius => "wall thinner than the support radius",
            Thin::WallBelowCell => "wall thinner than a cell",
        }
    }
}

/// A point of the surface, and how wide wall and gap are there, metres, if there is another side within reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Width {
    /// Where, metres.
    pub point: [f64; 3],
    /// Inside.
    pub wall: Option<f64>,
    /// Outside.
    pub gap: Option<f64>,
}

impl Width {
    /// What is narrow for a map of these cells.
    pub fn kind(&self, cell: f64, radius: f64) -> Thin {
        let below = |width: Option<f64>, limit: f64| width.is_some_and(|width| width < limit);
        match () {
            () if below(self.wall, cell) => Thin::WallBelowCell,
            () if below(self.wall, radius) => Thin::WallBelowRadius,
            () if below(self.gap, cell) => Thin::GapBelowCell,
            () if below(self.gap, radius) => Thin::GapBelowRadius,
            () => Thin::Nothing,
        }
    }
}

/// Widths that matter to a map, metres: up to twice the support radius, and the cells.
pub fn reach(model: &Model) -> f64 {
    2.0 * model.radius.max(cell(model))
}

/// Longest edge of the cells, metres.
pub fn cell(model: &Model) -> f64 {
    model.field.grid.cell_size.max_element()
}

/// Points spread evenly over the area, with their triangles.
pub fn spread(corners: &[[DVec3; 3]]) -> Vec<(DVec3, u32)> {
    spread_over_area(corners).into_iter().map(|(point, triangle)| (point, triangle as u32)).collect()
}

/// Widths at points of the surface, of which the triangles are known, up to `reach` metres.
///
/// # Errors
/// [`Cancelled`].
pub fn widths(
    solid: &Solid,
    points: &[(DVec3, u32)],
    reach: f64,
    watch: &Watch,
) -> Result<Vec<Width>, Cancelled> {
    let work = watch.begin("measuring walls and gaps", points.len() as u64)?;
    let invert = if solid.phi.invert { -1.0 } else { 1.0 };
    let width = |&(point, triangle): &(DVec3, u32)| {
        work.check()?;
        work.add(1);
        // Out of the solid.
        let normal = normal(solid, triangle) * invert;
        let side = |direction| touching_ball(solid, point, direction, reach);
        Ok(Width { point: point.to_array(), wall: side(-normal), gap: side(normal) })
    };
    points.par_iter().map(width).collect()
}

/// Normal of a triangle as its corners run; zero if it has no area.
pub fn normal(solid: &Solid, triangle: u32) -> DVec3 {
    let corner = |v: u32| DVec3::from(solid.mesh.vertices[v as usize]);
    let [a, b, c] = solid.mesh.triangles[triangle as usize].map(corner);
    (b - a).cross(c - a).normalize_or_zero()
}

/// Diameter of the largest ball that touches the surface at `p` from the side of `n`, a normal there, and holds nothing
/// of it, if it is below `reach`.
fn touching_ball(solid: &Solid, p: DVec3, n: DVec3, reach: f64) -> Option<f64> {
    let mut radius = 0.5 * reach;
    for step in 0..STEPS {
        let closest = solid.phi.mesh.closest_within(p + radius * n, radius);
        let free = closest.distance_squared.sqrt() >= radius * (1.0 - ENOUGH);
        if free && step == 0 {
            return None;
        }
        if free {
            break;
        }
        let q = closest.point - p;
        // The ball through p and q whose centre lies on the normal at p.
        let smaller = q.length_squared() / (2.0 * q.dot(n));
        // The other side faces this one, or it is this surface going on.
        let faces = normal(solid, closest.triangle).dot(n).abs() > FACING && q.dot(n) > FACING * q.length();
        if !faces || smaller.is_nan() || smaller >= radius {
            return None;
        }
        radius = smaller;
    }
    Some(2.0 * radius)
}
