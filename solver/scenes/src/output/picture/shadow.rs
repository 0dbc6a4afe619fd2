//! Shadows by a picture from the light. Williams 1978, *Casting Curved Shadows on Curved Surfaces*; soft borders by
//! Reeves, Salesin and Cook 1987, *Rendering Antialiased Shadows with Depth Maps*.

use super::camera::Bounds;
use super::model::Model;
use super::splat;
use glam::Vec3;
use rayon::prelude::*;
use volmap_figures::raster::{self, BAND, Fragment, Sides, View};
use volmap_runtime::{DVec3, Pose};

/// Pixels of the light's picture along each side.
const SIZE: usize = 1024;
/// Pixels between two looks into it.
const SPACING: f32 = 2.6;

/// What the light sees.
pub struct Shadow {
    view: View,
    depth: Vec<f32>,
    /// Rows and columns with something in them, first and last.
    occupied: [[f32; 2]; 2],
    /// Surfaces this close behind what the light sees are lit, metres.
    bias: f32,
}

/// Casts particles of this radius and models, which are in the bounds, on whatever is behind them.
pub fn cast(
    light: Vec3,
    bounds: Bounds,
    positions: &[DVec3],
    radius: f32,
    models: &[(&Model, Pose)],
) -> Shadow {
    let size = bounds.size();
    let right = light.any_orthonormal_vector();
    let view = View {
        origin: bounds.centre(),
        right,
        up: right.cross(-light),
        forward: -light,
        size: [SIZE; 2],
        scale: SIZE as f32 / size,
        parallel: true,
        near: 0.0,
    };
    let splats = splat::project(&view, positions, |_| 0.0, radius);
    let splat_bands = splat::sorted(&splats, SIZE);
    let project = |(model, pose): &(&Model, Pose)| model.project(&view, pose, Sides::Both, 0);
    let faces: Vec<_> = models.iter().flat_map(project).collect();
    let face_bands = raster::sorted(&faces, SIZE);
    let mut depth = vec![f32::INFINITY; SIZE * SIZE];
    depth.par_chunks_mut(BAND * SIZE).enumerate().for_each(|(band, depth)| {
        if face_bands.of(band).next().is_some() {
            let mut solid = vec![Fragment::NONE; depth.len()];
            face_bands.of(band).for_each(|face| faces[face].draw(band, &view, &mut solid));
            depth.iter_mut().zip(&solid).for_each(|(depth, solid)| *depth = solid.depth);
        }
        splat_bands.of(band).for_each(|ball| splats[ball].draw_flat(band, view.size, depth));
    });
    let occupied = occupied(&depth);
    Shadow { view, depth, occupied, bias: 0.004 * size + radius }
}

fn occupied(depth: &[f32]) -> [[f32; 2]; 2] {
    let mut found = [[f32::INFINITY, f32::NEG_INFINITY]; 2];
    for (row, line) in depth.chunks(SIZE).enumerate() {
        let there = |depth: &f32| *depth < f32::INFINITY;
        if let (Some(first), Some(last)) = (line.iter().position(there), line.iter().rposition(there)) {
            found[0] = [found[0][0].min(row as f32), row as f32 + 1.0];
            found[1] = [found[1][0].min(first as f32), found[1][1].max(last as f32 + 1.0)];
        }
    }
    found
}

impl Shadow {
    /// How much of the light reaches a point, by all four phases where the first is in doubt.
    pub fn mean_light_at(&self, point: Vec3) -> f32 {
        let first = self.light_at(point, 0);
        if first == 0.0 || first == 1.0 {
            return first;
        }
        0.25 * (first + (1..4).map(|phase| self.light_at(point, phase)).sum::<f32>())
    }

    /// How much of the light reaches a point, 0 to 1. The four `phase`s of a pixel look at different places.
    pub fn light_at(&self, point: Vec3, phase: usize) -> f32 {
        let local = self.view.local(point);
        let [x, y] = self.view.pixel(local);
        let far = |at: f32, [low, high]: [f32; 2]| at < low - 3.0 * SPACING || at > high + 3.0 * SPACING;
        if far(y, self.occupied[0]) || far(x, self.occupied[1]) {
            return 1.0;
        }
        let (dx, dy) = ((phase & 1) as f32, (phase >> 1) as f32);
        let mut lit = 0;
        for (i, j) in (0..9).map(|n| (n % 3, n / 3)) {
            let place = |at: f32, n: usize, d: f32| at + SPACING * (2.0 * n as f32 + d - 2.5);
            let (column, row) = (place(x, i, dx), place(y, j, dy));
            let inside = column >= 0.0 && row >= 0.0 && column < SIZE as f32 && row < SIZE as f32;
            let shaded = inside && self.depth[row as usize * SIZE + column as usize] < local.z - self.bias;
            lit += usize::from(!shaded);
        }
        lit as f32 / 9.0
    }
}
