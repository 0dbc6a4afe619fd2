//! The density of a wall in which a particle sees the mirror image of the fluid, layer by layer.
//!
//! Let a particle be at distance d, in the layer of the fluid next to the wall. Its own layer's image lies at 2 d from
//! it, the images of the layers above at a = 2 rp each behind that one. A layer is a sheet of volume a for each area,
//! so
//! ```text
//! R_mirror(d)  = a sum over k = 0, 1, .. of W_1(2 d + k a),   W_1(z) = 2 pi integral from |z| to 1 of W(s) s ds
//! R_mirror'(d) = -4 pi a sum of z W(z) at z = 2 d + k a
//! ```
//! (in two dimensions layers are lines, and W_1(z) = 2 integral of W(sqrt(z^2 + t^2)) dt from t = 0 on). At d = rp that
//! is the density of the layers that a wall filled with more fluid would have. The image moves as the particle does, so
//! the slope is twice that of a wall at rest: it holds the mirrored pressure of Akinci et al. 2012 (Eq. 15 of Bender et
//! al. 2020, the term with p~ = p_i), as the derivative of a density. So forces are conservative, and under equal
//! pressure the first layer is in equilibrium at d = rp, where the fluid pushes it as much as the image does.
//!
//! The wall stands back by a fortieth of rp ([`STANDS_BACK`]): d is that much more than the distance. Fluid that has
//! come to rest is no lattice, and keeps as much farther from a wall than its volume says. Small as it is, it counts on
//! every face of a tank and of what floats in it: without it a box of 8 rp floats a quarter of rp too high.
//!
//! Nearer than where it is steepest, R_mirror goes on along its tangent: images never let a particle through.

use crate::kernel::KernelKind;
use crate::quadrature::integrate_pieces;
use std::f64::consts::PI;
use volmap_formats::asset::Dimension;

/// The image's density as a function of the distance; lengths in support radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mirror {
    kernel: KernelKind,
    dimension: Dimension,
    spacing: f64,
    /// By so much the wall stands back.
    back: f64,
    /// Where it is steepest.
    steepest: f64,
}

/// By so much a wall stands back, in rp. Measured: bodies that float in tanks of 24 to 40 rp displace the volume of
/// their weight with it (solver/VALIDATION.md). In three dimensions; in the plane nothing floats yet.
const STANDS_BACK: f64 = 0.025;

/// Layers at most; more than these are as good as a continuum.
const MOST_LAYERS: f64 = 64.0;

impl Mirror {
    /// For particles of a radius > 0.
    pub fn new(kernel: KernelKind, dimension: Dimension, particle_radius: f64) -> Mirror {
        let spacing = (2.0 * particle_radius).max(1.0 / MOST_LAYERS);
        let back = match dimension {
            Dimension::Two => 0.0,
            Dimension::Three => STANDS_BACK * particle_radius,
        };
        let mut mirror = Mirror { kernel, dimension, spacing, back, steepest: 0.0 };
        let places = (0..=1024).map(|n| f64::from(n) / 1024.0 * particle_radius);
        mirror.steepest = places
            .map(|d| (d, mirror.images(d)[1]))
            .fold((0.0, f64::INFINITY), |best, place| if place.1 < best.1 { place } else { best })
            .0;
        mirror
    }

    /// R_mirror and its derivative.
    pub fn density(&self, d: f64) -> [f64; 2] {
        let at = d.max(self.steepest);
        let [value, slope] = self.images(at);
        [value + slope * (d - at), slope]
    }

    fn images(&self, d: f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        let mut z = 2.0 * (d + self.back);
        while z < 1.0 {
            let [value, slope] = match self.dimension {
                Dimension::Two => line(self.kernel, z),
                Dimension::Three => sheet(self.kernel, z),
            };
            sum[0] += self.spacing * value;
            sum[1] += 2.0 * self.spacing * slope;
            z += self.spacing;
        }
        sum
    }
}

/// W_1 and W_1': the kernel integrated over a plane at distance z >= 0.
fn sheet(kernel: KernelKind, z: f64) -> [f64; 2] {
    let value = 2.0 * PI * integrate_pieces(&[0.5], z, 1.0, |s| kernel.unit_value(s) * s);
    [value, -2.0 * PI * z * kernel.unit_value(z)]
}

/// The same over a line in the plane. No polynomials, so in more pieces, with the kernel's break in their middle.
fn line(kernel: KernelKind, z: f64) -> [f64; 2] {
    let along = |s: f64| (s * s - z * z).max(0.0).sqrt();
    let (middle, end) = (along(0.5), along(1.0));
    let piece = |n: usize| {
        let part = n as f64 / PIECES as f64;
        if part <= 0.5 { 2.0 * part * middle } else { middle + (2.0 * part - 1.0) * (end - middle) }
    };
    let pieces: [f64; PIECES + 1] = std::array::from_fn(piece);
    let over =
        |f: &dyn Fn(f64) -> f64| 2.0 * kernel.plane_thickness() * integrate_pieces(&pieces, 0.0, end, f);
    let distance = |t: f64| z.hypot(t).max(f64::MIN_POSITIVE);
    [
        over(&|t| kernel.unit_value(distance(t))),
        over(&|t| kernel.unit_derivative(distance(t)) * z / distance(t)),
    ]
}

/// Of a line's integral.
const PIECES: usize = 16;
