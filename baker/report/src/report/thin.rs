//! Thin walls and narrow gaps: where a map can leak.
//!
//! The largest ball that touches the surface at a point and holds no other part of it is as wide as the wall (inside)
//! or the gap (outside) there.

use super::model::{Model, Solid};
use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use volmap_bake::sdf::sign_comparison::spread_over_area;
use volmap_bake::sdf::width::touching_ball;
use volmap_bake::watch::{Cancelled, Watch};

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

/// Points spread evenly over the area, with the numbers of their triangles.
pub fn spread(corners: &[[DVec3; 3]], numbers: &[u32]) -> Vec<(DVec3, u32)> {
    spread_over_area(corners).into_iter().map(|(point, triangle)| (point, numbers[triangle])).collect()
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
        let normal = solid.phi.mesh.normal(triangle) * invert;
        let side = |direction| touching_ball(&solid.phi.mesh, point, direction, reach);
        Ok(Width { point: point.to_array(), wall: side(-normal), gap: side(normal) })
    };
    points.par_iter().map(width).collect()
}
