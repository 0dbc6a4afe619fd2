//! The surface from three sides, and what is thin of it.

use super::model::{Model, Solid};
use super::thin::{self, Thin};
use glam::DVec3;
use volmap_bake::input::bounds;
use volmap_figures::picture::{Axis, Pixel, PixelLattice, Plane, Raster};

/// The surface seen along an axis, from its positive end.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Along which axis.
    pub axis: Axis,
    /// Per pixel, the index of [`Thin::ALL`], plus their number for each step of the shade; [`NOTHING`] beside the
    /// surface.
    pub kinds: Raster,
}

/// Steps of the shade: the more, the more the surface is turned away from the viewer.
pub const SHADES: usize = 5;
/// Instead of a kind.
pub const NOTHING: usize = SHADES * Thin::ALL.len();

/// The solid from three sides.
pub fn views(model: &Model, solid: &Solid, pixels: usize) -> Vec<View> {
    Axis::ALL.map(|axis| view(model, solid, axis, pixels)).into()
}

fn view(model: &Model, solid: &Solid, axis: Axis, pixels: usize) -> View {
    let [low, high] = bounds(&solid.mesh);
    let margin = DVec3::splat(0.05 * (high - low).max_element());
    let plane = Plane { axis, at: high[axis.index()] };
    let lattice = PixelLattice::over(plane, low - margin, high + margin, pixels);
    let seen = nearest(solid, &lattice, axis);
    let points: Vec<(DVec3, u32)> = seen.iter().flatten().copied().collect();
    let widths = thin::widths(solid, &points, thin::reach(model));
    let cell = thin::cell(model);
    let mut kinds = points.iter().zip(widths).map(|((_, triangle), width)| {
        let kind = width.kind(cell, model.radius) as usize;
        let facing = thin::normal(solid, *triangle)[axis.index()].abs();
        let shade = ((1.0 - facing) * SHADES as f64).min(SHADES as f64 - 1.0) as usize;
        Pixel::Value((kind + shade * Thin::ALL.len()) as f64)
    });
    let pixel = |seen: &Option<(DVec3, u32)>| match seen {
        Some(_) => kinds.next().unwrap_or(Pixel::Unknown),
        None => Pixel::Value(NOTHING as f64),
    };
    let pixels = seen.iter().map(pixel).collect();
    View { axis, kinds: Raster { lattice, pixels } }
}

/// Per pixel, the point of the surface that is seen and its triangle: a depth buffer.
fn nearest(solid: &Solid, lattice: &PixelLattice, axis: Axis) -> Vec<Option<(DVec3, u32)>> {
    let mut seen: Vec<Option<(DVec3, u32)>> = vec![None; lattice.len()];
    for (index, triangle) in solid.mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|v| DVec3::from(solid.mesh.vertices[v as usize]));
        let flat = corners.map(|corner| lattice.project(corner));
        for [i, j] in pixels_of(lattice, &flat) {
            let place = [0, 1].map(|side| lattice.low[side] + ([i, j][side] as f64 + 0.5) * lattice.pixel);
            let Some([u, v, w]) = weights(&flat, place) else { continue };
            let point = corners[0] * u + corners[1] * v + corners[2] * w;
            let best = &mut seen[i + lattice.size[0] * j];
            if best.is_none_or(|(other, _)| point[axis.index()] > other[axis.index()]) {
                *best = Some((point, index as u32));
            }
        }
    }
    seen
}

/// Pixels whose centres may lie in a triangle.
fn pixels_of<'a>(
    lattice: &'a PixelLattice,
    flat: &[[f64; 2]; 3],
) -> impl Iterator<Item = [usize; 2]> + use<'a> {
    let range = |side: usize| {
        let place = |x: f64| (x - lattice.low[side]) / lattice.pixel - 0.5;
        let low = flat.iter().map(|p| place(p[side])).fold(f64::INFINITY, f64::min);
        let high = flat.iter().map(|p| place(p[side])).fold(f64::NEG_INFINITY, f64::max);
        let last = lattice.size[side] as f64;
        low.ceil().clamp(0.0, last) as usize..(high.floor() + 1.0).clamp(0.0, last) as usize
    };
    let (columns, rows) = (range(0), range(1));
    rows.flat_map(move |j| columns.clone().map(move |i| [i, j]))
}

/// Barycentric coordinates in the plane, if they are of a point in the triangle.
fn weights([a, b, c]: &[[f64; 2]; 3], p: [f64; 2]) -> Option<[f64; 3]> {
    let cross = |a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let all = cross(a, b, c);
    let parts = [cross(&p, b, c), cross(a, &p, c), cross(a, b, &p)].map(|part| part / all);
    parts.iter().all(|part| *part >= 0.0).then_some(parts)
}
