//! Closure `lattice`: the density of a wall for particles on a lattice, what a half space of particles adds, rather
//! than a continuum.
//!
//! Fluid at rest lies in layers. Let the wall be filled with the continuation of the fluid's cubic lattice, spacing
//! a = 2 rp, volume a^3 each, its first layer rp behind the surface. A particle at height d above one of the sites gets
//! ```text
//! R_lattice(d) = sum over layers k = 0, 1, .. of L(d + (2 k + 1) rp),
//! L(z) = a^3 sum over i, j of W(sqrt(z^2 + (i a)^2 + (j a)^2))
//! ```
//! At the resting heights d = rp, 3 rp, 5 rp, .. the fluid above and R_lattice together are the sum over the full
//! lattice, and the fluid's gradient and R_lattice' cancel: with equal pressures no layer moves. The continuum's R
//! gives the first layer too much (0.188 instead of 0.150; cubic spline, r = 4 rp), which pushes it off the wall.

use super::model::{Model, Setup};
use super::plane;
use super::wall::Walls;
use crate::kernel::KernelKind;
use std::sync::Arc;

/// Spacings in a support radius above which the lattice is as good as a continuum, and too long to sum over.
const FINEST: f64 = 16.0;

pub(super) fn new(setup: &Setup) -> Arc<dyn Model> {
    let (kernel, radius) = (setup.kernel.kind(), setup.particle_radius / setup.kernel.support_radius());
    let layers = |d: f64| density(kernel, radius, d).unwrap_or_else(|| plane::density(kernel, d));
    Arc::new(Walls::new(setup.kernel, layers, None))
}

/// R_lattice and its derivative at d >= 0; `None` where the lattice is too fine for its sum to matter, or none. Lengths
/// in support radii.
pub(crate) fn density(kernel: KernelKind, particle_radius: f64, d: f64) -> Option<[f64; 2]> {
    let spacing = 2.0 * particle_radius;
    if !(spacing * FINEST >= 1.0 && spacing.is_finite()) {
        return None;
    }
    let mut sum = [0.0; 2];
    let mut z = d + particle_radius;
    while z < 1.0 {
        let [value, slope] = layer(kernel, spacing, z);
        sum = [sum[0] + value, sum[1] + slope];
        z += spacing;
    }
    Some(sum)
}

/// L and L' of a layer at distance z > 0.
fn layer(kernel: KernelKind, spacing: f64, z: f64) -> [f64; 2] {
    let reach = (1.0 / spacing) as i32;
    let volume = spacing.powi(3);
    let mut sum = [0.0; 2];
    for i in -reach..=reach {
        for j in -reach..=reach {
            let across = f64::from(i * i + j * j) * spacing * spacing;
            let distance = (z * z + across).sqrt();
            sum[0] += volume * kernel.unit_value(distance);
            sum[1] += volume * kernel.unit_derivative(distance) * z / distance;
        }
    }
    sum
}
