//! Particles as balls on the picture. van der Laan, Green and Sainz 2009, *Screen Space Fluid Rendering with Curvature
//! Flow*, sections 3.1 and 3.4: depth and thickness of the fluid, a ball at a time.

use super::bands::{BAND, Bands};
use super::view::View;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
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

impl Splat {
    /// Calls `ball` for every pixel of the band that it covers, with the pixel's place in the band and half of the
    /// chord there, in parts of the radius.
    #[inline]
    pub fn cover(&self, band: usize, [width, height]: [usize; 2], mut ball: impl FnMut(usize, f32)) {
        let first = band * BAND;
        let rows = pixels(self.at[1], self.radius, first..(first + BAND).min(height));
        let inverse = 1.0 / (self.radius * self.radius);
        for row in rows {
            let down = row as f32 + 0.5 - self.at[1];
            let left = 1.0 - down * down * inverse;
            if left <= 0.0 {
                continue;
            }
            let start = (row - first) * width;
            for column in pixels(self.at[0], self.radius * left.sqrt(), 0..width) {
                let across = column as f32 + 0.5 - self.at[0];
                let square = left - across * across * inverse;
                if square > 0.0 {
                    ball(start + column, square.sqrt());
                }
            }
        }
    }

    /// Draws it into a band: nearest depth with the value there, and thickness, both in front of `limit`. `radius` is
    /// that of the ball in metres.
    pub fn draw(
        &self,
        band: usize,
        size: [usize; 2],
        radius: f32,
        fluid: &mut [Fluid],
        limit: impl Fn(usize) -> f32,
    ) {
        self.cover(band, size, |at, chord| {
            let front = self.depth - radius * chord;
            let pixel = &mut fluid[at];
            if front < limit(at) {
                pixel.thickness += 2.0 * radius * chord;
                if front < pixel.depth {
                    (pixel.depth, pixel.value) = (front, self.value);
                }
            }
        });
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
