//! Particles as balls on the picture. van der Laan, Green and Sainz 2009, *Screen Space Fluid Rendering with Curvature
//! Flow*, sections 3.1 and 3.4: depth and thickness of the fluid, a ball at a time.

use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use volmap_figures::raster::{BAND, Bands, View};
use volmap_runtime::DVec3;

/// A ball on the picture.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Middle, pixels.
    at: [f32; 2],
    /// Pixels.
    radius: f32,
    /// Of its middle, metres.
    pub depth: f32,
    /// What its colour stands for.
    value: f32,
}

/// Smallest radius, pixels: far particles don't vanish.
const SMALLEST: f32 = 0.7;

/// The particles in front of the eye, as balls of this radius in metres.
pub fn project(
    view: &View,
    positions: &[DVec3],
    value: impl Fn(usize) -> f32 + Sync,
    radius: f32,
) -> Vec<Splat> {
    let splat = |(index, point): (usize, &DVec3)| {
        let local: Vec3 = view.local(point.as_vec3());
        let visible = local.is_finite() && (view.parallel || local.z > view.near + radius);
        visible.then(|| Splat {
            at: view.pixel(local),
            radius: (radius * view.scale_at(local.z)).max(SMALLEST),
            depth: local.z,
            value: value(index),
        })
    };
    positions.par_iter().enumerate().with_min_len(1 << 10).filter_map(splat).collect()
}

/// Splats by the bands that they touch.
pub fn sorted(splats: &[Splat], height: usize) -> Bands {
    Bands::new(splats, height, |s| s.at[1] - s.radius..s.at[1] + s.radius)
}

/// Pixels of a row that a ball covers, or that touch its rim.
struct Row {
    /// Their places in the band.
    places: Range<usize>,
    /// Of the first, from the picture's left border.
    column: i32,
    /// Square of half of the row's chord, in parts of the radius.
    left: f32,
}

impl Splat {
    /// The rows of a band that it covers. Of the `n`th pixel of one, [`Splat::square`] tells whether it is covered.
    fn rows(&self, band: usize, [width, height]: [usize; 2]) -> impl Iterator<Item = Row> {
        let first = band * BAND;
        let inverse = self.inverse();
        let rows = pixels(self.at[1], self.radius, first..(first + BAND).min(height));
        rows.filter_map(move |row| {
            let down = row as f32 + 0.5 - self.at[1];
            let left = 1.0 - down * down * inverse;
            let columns = pixels(self.at[0], self.radius * left.max(0.0).sqrt(), 0..width);
            let start = (row - first) * width;
            let places = start + columns.start..start + columns.end;
            (left > 0.0 && !columns.is_empty()).then_some(Row { places, column: columns.start as i32, left })
        })
    }

    fn inverse(&self) -> f32 {
        1.0 / (self.radius * self.radius)
    }

    /// Square of half of the ball's chord at a pixel, in parts of the radius; not positive beside the ball.
    #[inline]
    fn square(&self, row: &Row, n: usize, inverse: f32) -> f32 {
        let across = (row.column + n as i32) as f32 + 0.5 - self.at[0];
        row.left - across * across * inverse
    }

    /// Draws it into a band: nearest depth with the value there, and thickness, both in front of the layer's limits.
    /// `radius` is that of the ball in metres. Without branches, so that the compiler takes several pixels at a time.
    pub fn draw(&self, band: usize, size: [usize; 2], radius: f32, layer: &mut Layer) {
        let inverse = self.inverse();
        for row in self.rows(band, size) {
            let places = row.places.clone();
            let (depth, value) = (&mut layer.depth[places.clone()], &mut layer.value[places.clone()]);
            let (thickness, limit) = (&mut layer.thickness[places.clone()], &layer.limit[places]);
            let pixels = depth.iter_mut().zip(value).zip(thickness).zip(limit).enumerate();
            for (n, (((depth, value), thickness), &limit)) in pixels {
                let square = self.square(&row, n, inverse);
                let chord = square.max(0.0).sqrt();
                let front = self.depth - radius * chord;
                let seen = (square > 0.0) & (front < limit);
                *thickness += if seen { 2.0 * radius * chord } else { 0.0 };
                let nearest = seen & (front < *depth);
                *depth = if nearest { front } else { *depth };
                *value = if nearest { self.value } else { *value };
            }
        }
    }

    /// Draws the depth of its middle into a band.
    pub fn draw_flat(&self, band: usize, size: [usize; 2], depth: &mut [f32]) {
        let inverse = self.inverse();
        for row in self.rows(band, size) {
            for (n, depth) in depth[row.places.clone()].iter_mut().enumerate() {
                let nearer = (self.square(&row, n, inverse) > 0.0) & (self.depth < *depth);
                *depth = if nearer { self.depth } else { *depth };
            }
        }
    }
}

/// Pixels whose middles are within `radius` of a place, of a range.
fn pixels(at: f32, radius: f32, range: Range<usize>) -> Range<usize> {
    // Casts cut off, and end at the limits of the type; the system's `ceil` and `floor` are calls.
    let low = (at - radius - 0.5).max(range.start as f32);
    let first = low as usize + usize::from((low as usize as f32) < low);
    let end = ((at + radius + 0.5).max(0.0) as usize).min(range.end);
    first..end
}

/// The fluid in a band while balls are drawn into it, by fields.
pub struct Layer {
    depth: Vec<f32>,
    value: Vec<f32>,
    thickness: Vec<f32>,
    /// Only what is nearer is seen, metres.
    limit: Vec<f32>,
}

impl Layer {
    /// No fluid; `limit` of each pixel.
    pub fn new(limit: Vec<f32>) -> Layer {
        let none = |x: f32| vec![x; limit.len()];
        Layer {
            depth: none(Fluid::NONE.depth),
            value: none(Fluid::NONE.value),
            thickness: none(Fluid::NONE.thickness),
            limit,
        }
    }

    /// By pixels.
    pub fn store(&self, out: &mut [Fluid]) {
        let fields = self.depth.iter().zip(&self.value).zip(&self.thickness);
        for (out, ((&depth, &value), &thickness)) in out.iter_mut().zip(fields) {
            *out = Fluid { depth, value, thickness };
        }
    }
}

/// The fluid at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Of its surface, metres; infinite where there is none.
    pub depth: f32,
    /// What its colour stands for.
    pub value: f32,
    /// Sum of the chords of the balls, metres.
    pub thickness: f32,
}

impl Fluid {
    /// No fluid.
    pub const NONE: Fluid = Fluid { depth: f32::INFINITY, value: 0.0, thickness: 0.0 };
}
