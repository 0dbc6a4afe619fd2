//! Closures: from the volume of the boundary to its density and density gradient at a particle, which the map leaves
//! open. Bender et al. 2020, section 4.3, and what makes it exact at a flat wall.
//!
//! - `paper` (Eq. 14 and 15): all of V at the closest point x*, rho_B = rho_0 V W(|x - x*|). At a flat wall and
//!   r = 4 rp this is 18 to 40 times the integral of W over the solid, so particles keep 2.3 to 2.8 rp away.
//! - `offset`: what SPlisHSPlasH computes up to version 2.18, x* = x - max(Phi + rp/2, 2 rp) n, with 0.8 V;
//!   4 to 12 times the integral.
//! - `calibrated`: with the half space's density R(d), its volume V_plane(d) and beta(d) ([`plane`])
//!   ```text
//!   rho_B      = rho_0 R(Phi)  (V / V_plane(Phi))^beta(Phi)
//!   grad rho_B = rho_0 R'(Phi) (V / V_plane(Phi))^beta(Phi) n
//!   ```
//!   the integral itself at a flat wall, and to first order in curvature on bowls and balls.
//!
//! The map is the same for all kernels and closures; tables are computed when a [`Closure`] is made, which takes
//! less than a millisecond, and only read afterwards.
//!
//! Inside the solid (Phi < 0) every closure's density grows with depth and its gradient keeps its direction, so that
//! pressure pushes a particle out: `paper` continues W oddly about the surface (2 W(0) - W, slope W'), and
//! `calibrated` continues R along its tangent.

mod plane;
pub(crate) mod quadrature;
mod table;

use crate::kernel::Kernel;
use crate::query::{Boundary, Sample};
use glam::DVec3;
use std::fmt;
use std::str::FromStr;
use table::Table;

/// How a volume becomes a density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ClosureKind {
    /// All the volume at the closest point: Bender et al. 2020, Eq. 14.
    Paper,
    /// The volume at a point behind the surface, as SPlisHSPlasH has it.
    Offset,
    /// Exact at a flat wall and to first order in curvature.
    #[default]
    Calibrated,
}

impl ClosureKind {
    /// All of them.
    pub const ALL: [ClosureKind; 3] = [ClosureKind::Paper, ClosureKind::Offset, ClosureKind::Calibrated];

    fn name(self) -> &'static str {
        match self {
            ClosureKind::Paper => "paper",
            ClosureKind::Offset => "offset",
            ClosureKind::Calibrated => "calibrated",
        }
    }
}

impl fmt::Display for ClosureKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ClosureKind {
    type Err = String;

    fn from_str(text: &str) -> Result<ClosureKind, String> {
        let known = ClosureKind::ALL.into_iter().find(|kind| kind.name() == text);
        known.ok_or_else(|| {
            format!("`{text}` is no closure; take {}", ClosureKind::ALL.map(Self::name).join(", "))
        })
    }
}

/// What the boundary adds to the density of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryDensity {
    /// rho_B over the fluid's rest density.
    pub density: f64,
    /// Its gradient at the particle, 1/m; against the normal.
    pub gradient: DVec3,
    /// The sample point x*, metres: where forces on the body act.
    pub point: DVec3,
}

/// The factor on V that SPlisHSPlasH applies up to version 2.18: its particles have 0.8 (2 rp)^3 instead of the cube's
/// volume, and so its boundaries have less as well.
const OFFSET_FACTOR: f64 = 0.8;

/// Intervals of the tables in a support radius: the interpolated density is within 1e-8 of the integral.
const PER_RADIUS: usize = 128;

/// A closure for one kernel and particle size.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    kind: ClosureKind,
    kernel: Kernel,
    particle_radius: f64,
    /// 1 / r, and -ln r^3.
    per_radius: f64,
    log_unit: f64,
    /// Over Phi / r: R, ln(V_plane / r^3), beta.
    plane: Table<3>,
}

impl Closure {
    /// A closure for particles of radius rp = `particle_radius` (metres, positive and finite; half of their spacing).
    /// The kernel's support radius must be that of the maps it is used with.
    pub fn new(kind: ClosureKind, kernel: Kernel, particle_radius: f64) -> Closure {
        let radius = kernel.support_radius();
        let plane = Table::new(-2.0, 1.0, 3 * PER_RADIUS, |d| {
            let [volume, slope] = plane::volume(d);
            [density_of_plane(kernel, d), [volume.ln(), slope / volume], exponent_of_plane(kernel, d)]
        });
        Closure {
            kind,
            kernel,
            particle_radius,
            per_radius: 1.0 / radius,
            log_unit: -3.0 * radius.ln(),
            plane,
        }
    }

    /// Which one it is.
    pub fn kind(&self) -> ClosureKind {
        self.kind
    }

    /// The kernel it was made for.
    pub fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// The particle radius it was made for, metres.
    pub fn particle_radius(&self) -> f64 {
        self.particle_radius
    }

    /// Density, gradient and sample point for a particle at `position` that sees `boundary`; `None` where the boundary
    /// adds nothing.
    #[inline]
    pub fn density(&self, boundary: &Boundary, position: DVec3) -> Option<BoundaryDensity> {
        if !(boundary.volume > 0.0 && boundary.distance < self.kernel.support_radius()) {
            return None;
        }
        match self.kind {
            ClosureKind::Paper => Some(self.paper(boundary)),
            ClosureKind::Offset => self.offset(boundary, position),
            ClosureKind::Calibrated => Some(self.calibrated(boundary)),
        }
    }

    /// [`Closure::density`] of every sample and its position, into `densities`, whose old content is dropped. A sample
    /// deep inside gives `None`, as one outside does: the way out is unknown there.
    pub fn density_batch(
        &self,
        samples: &[Sample],
        positions: &[DVec3],
        densities: &mut Vec<Option<BoundaryDensity>>,
    ) {
        densities.clear();
        let density = |(sample, position): (&Sample, &DVec3)| self.density(&sample.near()?, *position);
        densities.extend(samples.iter().zip(positions).map(density));
    }

    fn paper(&self, boundary: &Boundary) -> BoundaryDensity {
        let distance = boundary.distance.abs();
        let value = self.kernel.value(distance);
        let value = if boundary.distance < 0.0 { 2.0 * self.kernel.value(0.0) - value } else { value };
        BoundaryDensity {
            density: boundary.volume * value,
            gradient: boundary.volume * self.kernel.derivative(distance) * boundary.normal,
            point: boundary.closest_point,
        }
    }

    fn offset(&self, boundary: &Boundary, position: DVec3) -> Option<BoundaryDensity> {
        let distance = (boundary.distance + 0.5 * self.particle_radius).max(2.0 * self.particle_radius);
        let volume = OFFSET_FACTOR * boundary.volume;
        (distance < self.kernel.support_radius()).then(|| BoundaryDensity {
            density: volume * self.kernel.value(distance),
            gradient: volume * self.kernel.derivative(distance) * boundary.normal,
            point: position - distance * boundary.normal,
        })
    }

    fn calibrated(&self, boundary: &Boundary) -> BoundaryDensity {
        let [density, log_plane, exponent] = self.plane.at(boundary.distance * self.per_radius);
        let factor = (exponent[0] * (boundary.volume.ln() + self.log_unit - log_plane[0])).exp();
        BoundaryDensity {
            density: density[0] * factor,
            gradient: density[1] * self.per_radius * factor * boundary.normal,
            point: boundary.closest_point,
        }
    }
}

/// R and R', inside the solid along the tangent at its surface.
fn density_of_plane(kernel: Kernel, d: f64) -> [f64; 2] {
    let [value, slope] = plane::density(kernel.kind(), d.max(0.0));
    [value + slope * d.min(0.0), slope]
}

/// beta and its derivative, from differences within the table.
fn exponent_of_plane(kernel: Kernel, d: f64) -> [f64; 2] {
    const STEP: f64 = 1e-5;
    let value = |d: f64| plane::exponent(kernel.kind(), d);
    let (low, high) = (d - STEP, (d + STEP).min(1.0));
    [value(d), (value(high) - value(low)) / (high - low)]
}

#[cfg(test)]
mod tests;
