//! The surface from three sides, and what is thin of it.

use super::model::{Model, Solid};
use super::thin::{self, Thin};
use glam::{DVec3, Quat, Vec3};
use volmap_bake::input::bounds;
use volmap_bake::watch::{Cancelled, Watch};
use volmap_figures::picture::{Axis, Pixel, PixelLattice, Plane, Raster};
use volmap_figures::raster::{self, Faces, Sides, View as Projection};

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
///
/// # Errors
/// [`Cancelled`].
pub fn views(model: &Model, solid: &Solid, pixels: usize, watch: &Watch) -> Result<Vec<View>, Cancelled> {
    Axis::ALL.into_iter().map(|axis| view(model, solid, axis, pixels, watch)).collect()
}

fn view(model: &Model, solid: &Solid, axis: Axis, pixels: usize, watch: &Watch) -> Result<View, Cancelled> {
    let [low, high] = bounds(&solid.mesh);
    let margin = DVec3::splat(0.05 * (high - low).max_element());
    let plane = Plane { axis, at: high[axis.index()] };
    let lattice = PixelLattice::over(plane, low - margin, high + margin, pixels);
    let seen = nearest(solid, &lattice, axis);
    let points: Vec<(DVec3, u32)> = seen.iter().flatten().copied().collect();
    let widths = thin::widths(solid, &points, thin::reach(model), watch)?;
    let cell = thin::cell(model);
    let mut kinds = points.iter().zip(widths).map(|((_, triangle), width)| {
        let kind = width.kind(cell, model.radius) as usize;
        let facing = solid.phi.mesh.normal(*triangle)[axis.index()].abs();
        let shade = ((1.0 - facing) * SHADES as f64).min(SHADES as f64 - 1.0) as usize;
        Pixel::Value((kind + shade * Thin::ALL.len()) as f64)
    });
    let pixel = |seen: &Option<(DVec3, u32)>| match seen {
        Some(_) => kinds.next().unwrap_or(Pixel::Unknown),
        None => Pixel::Value(NOTHING as f64),
    };
    let pixels = seen.iter().map(pixel).collect();
    Ok(View { axis, kinds: Raster { lattice, pixels } })
}

/// Per pixel of the lattice, the point of the surface that is seen and its triangle.
fn nearest(solid: &Solid, lattice: &PixelLattice, axis: Axis) -> Vec<Option<(DVec3, u32)>> {
    let middle = {
        let [low, high] = [lattice.low, lattice.high()];
        let mut middle = DVec3::ZERO;
        middle[axis.index()] = lattice.plane.at;
        for (side, along) in lattice.axes.iter().enumerate() {
            middle[along.index()] = 0.5 * (low[side] + high[side]);
        }
        middle
    };
    let unit = |axis: Axis| Vec3::AXES[axis.index()];
    let [right, up] = lattice.axes.map(unit);
    let view = Projection {
        origin: Vec3::ZERO,
        right,
        up,
        forward: -unit(axis),
        size: lattice.size,
        scale: 1.0,
        parallel: true,
        near: 0.0,
    };
    // In pixels from the middle, so that single precision does, wherever the mesh is and however large.
    let place = |vertex: &[f64; 3]| ((DVec3::from(*vertex) - middle) / lattice.pixel).as_vec3();
    let places: Vec<Vec3> = solid.mesh.vertices.iter().map(place).collect();
    let normals = vec![[Vec3::ZERO; 3]; solid.mesh.triangles.len()];
    let triangles = &solid.mesh.triangles;
    let faces = Faces { places: &places, triangles, normals: &normals, rotation: Quat::IDENTITY };
    let fragments =
        raster::draw(&view, &raster::project(&view, &faces, Sides::Both, |triangle| triangle as u32));
    let [columns, rows] = lattice.size;
    let pixel = |at: usize| {
        // The picture's rows run down, the lattice's up.
        let (i, j) = (at % columns, at / columns);
        let fragment = fragments[(rows - 1 - j) * columns + i];
        let seen = fragment.depth < f32::INFINITY;
        seen.then(|| (on_triangle(solid, fragment.material, lattice.point(i, j), axis), fragment.material))
    };
    (0..lattice.len()).map(pixel).collect()
}

/// The point of a triangle's plane where the line along an axis meets it, within the triangle's extent.
fn on_triangle(solid: &Solid, triangle: u32, line: DVec3, axis: Axis) -> DVec3 {
    let corners =
        solid.mesh.triangles[triangle as usize].map(|v| DVec3::from(solid.mesh.vertices[v as usize]));
    let normal = solid.phi.mesh.normal(triangle);
    let along = axis.index();
    let [low, high] = [f64::min, f64::max]
        .map(|pick| corners.iter().map(|corner| corner[along]).reduce(pick).unwrap_or_default());
    let mut point = line;
    point[along] = corners[0][along];
    let depth = point[along] - normal.dot(point - corners[0]) / normal[along];
    // Triangles that are seen from the side have no depth of their own.
    point[along] = if depth.is_finite() { depth.clamp(low, high) } else { high };
    point
}
