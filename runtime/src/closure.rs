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
//! - `wedge`: the same, but where V < V_plane the exponent grows with the deficit up to what a convex edge of 90 degrees
//!   needs ([`wedge`]); a second look at the map, into the solid, tells edges from balls
//!   ([`Closure::density_probing`]).
//! - `lattice`: as `calibrated`, R being what a half space of particles on a lattice adds instead of a continuum
//!   ([`lattice`]), so that a fluid's layers rest at rp, 3 rp, ..
//! - `mirror`: as `wedge`, R being what the fluid's mirror image adds ([`mirror`]): value, slope and mirrored pressure
//!   belong together, so that a fluid comes to rest, at rp from walls and calmly.
//!
//! The gradient of these is that along the normal, at constant V / V_plane; with the gradient of V, which the map
//! gives too, it is the true one ([`Closure::density_with_gradient`]).
//!
//! The map is the same for all kernels and closures; tables are computed when a [`Closure`] is made, which takes
//! less than a millisecond, and only read afterwards.
//!
//! Inside the solid (Phi < 0) every closure's density grows with depth and its gradient keeps its direction, so that
//! pressure pushes a particle out: `paper` continues W oddly about the surface (2 W(0) - W, slope W'), and
//! `calibrated` continues R along its tangent.

mod lattice;
mod mirror;
mod plane;
pub(crate) mod quadrature;
mod table;
mod wedge;

use crate::kernel::{Kernel, KernelKind};
use crate::query::{Boundary, Sample};
use glam::DVec3;
use mirror::Mirror;
use std::fmt;
use std::str::FromStr;
use table::Table;

/// How a volume becomes a density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ClosureKind {
    /// All the volume at the closest point: Bender et al. 2020, Eq. 14.
    Paper,
    /// The volume at a point behind the surface, as SPlisHSPlasH has it.
    Offset,
    /// Exact at a flat wall and to first order in curvature.
    #[default]
    Calibrated,
    /// As `calibrated`, and close to exact at convex edges.
    Wedge,
    /// As `calibrated`, from a lattice of particles in the wall: for fluids whose particles lie in layers.
    Lattice,
    /// As `wedge`, from the fluid's mirror image: particles rest at one particle radius from a wall, calmly.
    Mirror,
}

impl ClosureKind {
    /// All of them.
    pub const ALL: [ClosureKind; 6] = [
        ClosureKind::Paper,
        ClosureKind::Offset,
        ClosureKind::Calibrated,
        ClosureKind::Wedge,
        ClosureKind::Lattice,
        ClosureKind::Mirror,
    ];

    fn name(self) -> &'static str {
        match self {
            ClosureKind::Paper => "paper",
            ClosureKind::Offset => "offset",
            ClosureKind::Calibrated => "calibrated",
            ClosureKind::Wedge => "wedge",
            ClosureKind::Lattice => "lattice",
            ClosureKind::Mirror => "mirror",
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

/// Intervals of the table of edges, whose values are needed less exactly.
const EDGE_INTERVALS: usize = 32;

/// Depth below the surface, in support radii, at which a probe tells an edge from a ball.
const PROBE_DEPTH: f64 = 0.25;

/// How much nearer than [`PROBE_DEPTH`] to the surface, in parts of it, a probe at an edge is: of 90 degrees 0.29, of
/// 120 degrees 0.13. Below it the exponent is led over to that of a ball.
const PROBE_EDGE: f64 = 0.15;

/// Part of an edge's volume deficit below which a probe isn't worth its time: there the exponents differ by less than 3 %
/// of the way, the densities by 0.2 %.
const PROBE_FROM: f64 = 0.1;

/// A closure for one kernel and particle size.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    kind: ClosureKind,
    kernel: Kernel,
    particle_radius: f64,
    per_radius: f64,
    /// -ln r^3.
    log_unit: f64,
    /// Over Phi / r: R, ln(V_plane / r^3), beta.
    plane: Table<3>,
    /// Over Phi / r: V_edge / V_plane, the exponent there.
    edges: Option<Table<2>>,
}

/// What is known of the solid around a particle, as far as it is a wall.
struct Wall {
    /// R and dR/dPhi, r times.
    density: [f64; 2],
    /// ln(V / V_plane).
    log_ratio: f64,
    /// r d ln V_plane / dPhi.
    log_plane_slope: f64,
    exponent: Exponent,
}

/// The exponent of V / V_plane.
#[derive(Clone, Copy)]
struct Exponent {
    value: f64,
    /// r times that with respect to Phi, and that with respect to ln(V / V_plane).
    slope: f64,
    ratio_slope: f64,
}

impl Closure {
    /// A closure for particles of radius rp = `particle_radius` (metres, positive and finite; half of their spacing).
    /// The kernel's support radius must be that of the maps it is used with.
    pub fn new(kind: ClosureKind, kernel: Kernel, particle_radius: f64) -> Closure {
        let radius = kernel.support_radius();
        let wall = WallDensity::new(kind, kernel.kind(), particle_radius / radius);
        let plane = Table::new(-2.0, 1.0, 3 * PER_RADIUS, |d| {
            let [volume, slope] = plane::volume(d);
            [wall.at(d), [volume.ln(), slope / volume], exponent_of_plane(kernel, d)]
        });
        let edges = || {
            let edge = |d: f64| wedge::edge(kernel.kind(), d);
            Table::new(0.0, wedge::LAST, EDGE_INTERVALS, |d| with_slopes(edge, d, 0.0, wedge::LAST))
        };
        Closure {
            kind,
            kernel,
            particle_radius,
            per_radius: 1.0 / radius,
            log_unit: -3.0 * radius.ln(),
            plane: plane.limit(0),
            edges: matches!(kind, ClosureKind::Wedge | ClosureKind::Mirror).then(edges),
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
    /// adds nothing. `wedge` takes what bends away from the particle for an edge.
    #[inline]
    pub fn density(&self, boundary: &Boundary, position: DVec3) -> Option<BoundaryDensity> {
        self.answer(boundary, position, None, |_| 1.0)
    }

    /// As [`Closure::density`], with the true gradient of the density, from that of the volume
    /// ([`VolumeMap::sample_with_gradient`](crate::VolumeMap::sample_with_gradient); m^2). `paper` and `offset` have no
    /// use for it.
    #[inline]
    pub fn density_with_gradient(
        &self,
        boundary: &Boundary,
        volume_gradient: DVec3,
        position: DVec3,
    ) -> Option<BoundaryDensity> {
        self.answer(boundary, position, Some(volume_gradient), |_| 1.0)
    }

    /// As [`Closure::density`], or with a gradient of the volume as [`Closure::density_with_gradient`], where `wedge` asks
    /// for the distance (metres) at a second point below the surface, for particles that see much less volume than a
    /// flat wall's: `|x| map.values(x).distance`. The other closures don't ask.
    #[inline]
    pub fn density_probing(
        &self,
        boundary: &Boundary,
        volume_gradient: Option<DVec3>,
        position: DVec3,
        distance: impl FnOnce(DVec3) -> f64,
    ) -> Option<BoundaryDensity> {
        let depth = PROBE_DEPTH * self.kernel.support_radius();
        self.answer(boundary, position, volume_gradient, |boundary| {
            let nearer = 1.0 + distance(boundary.closest_point - depth * boundary.normal) / depth;
            (nearer / PROBE_EDGE).clamp(0.0, 1.0)
        })
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

    /// `sharpness` says how much of an edge, 0 to 1, a place is that could be one.
    #[inline]
    fn answer(
        &self,
        boundary: &Boundary,
        position: DVec3,
        volume_gradient: Option<DVec3>,
        sharpness: impl FnOnce(&Boundary) -> f64,
    ) -> Option<BoundaryDensity> {
        if !(boundary.volume > 0.0 && boundary.distance < self.kernel.support_radius()) {
            return None;
        }
        match self.kind {
            ClosureKind::Paper => Some(self.paper(boundary)),
            ClosureKind::Offset => self.offset(boundary, position),
            ClosureKind::Calibrated | ClosureKind::Wedge | ClosureKind::Lattice | ClosureKind::Mirror => {
                let wall = self.wall(boundary, || sharpness(boundary));
                Some(self.calibrated(boundary, &wall, volume_gradient))
            }
        }
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

    #[inline]
    fn wall(&self, boundary: &Boundary, sharpness: impl FnOnce() -> f64) -> Wall {
        let d = boundary.distance * self.per_radius;
        let [density, log_plane, [value, slope]] = self.plane.at(d);
        let log_ratio = boundary.volume.ln() + self.log_unit - log_plane[0];
        let flat = Exponent { value, slope, ratio_slope: 0.0 };
        let exponent = match &self.edges {
            Some(edges) if log_ratio < 0.0 => towards_edge(flat, edges, d, log_ratio.exp(), sharpness),
            _ => flat,
        };
        Wall { density, log_ratio, log_plane_slope: log_plane[1], exponent }
    }

    fn calibrated(
        &self,
        boundary: &Boundary,
        wall: &Wall,
        volume_gradient: Option<DVec3>,
    ) -> BoundaryDensity {
        let Wall { density: [value, slope], log_ratio, log_plane_slope, exponent } = *wall;
        let factor = (exponent.value * log_ratio).exp();
        let density = value * factor;
        let gradient = match volume_gradient {
            None => slope * factor * self.per_radius * boundary.normal,
            Some(volume_gradient) => {
                let power = exponent.value + exponent.ratio_slope * log_ratio;
                let along = slope * factor + density * (exponent.slope * log_ratio - power * log_plane_slope);
                along * self.per_radius * boundary.normal
                    + density * power / boundary.volume * volume_gradient
            }
        };
        BoundaryDensity { density, gradient, point: boundary.closest_point }
    }
}

/// The exponent at distance d of a place that has `ratio` < 1 of a flat wall's volume: from the flat wall's to the edge's
/// by a smooth step, which follows the way from the face of an edge around it to within 4 %.
fn towards_edge(
    flat: Exponent,
    edges: &Table<2>,
    d: f64,
    ratio: f64,
    sharpness: impl FnOnce() -> f64,
) -> Exponent {
    let [[edge_ratio, ratio_slope], [edge_value, edge_slope]] = edges.at(d);
    let inside = if (0.0..wedge::LAST).contains(&d) { 1.0 } else { 0.0 };
    let deficit = (1.0 - ratio) / (1.0 - edge_ratio);
    let sharpness = if deficit > PROBE_FROM { sharpness() } else { 1.0 };
    let s = deficit.min(1.0);
    let (step, rise) = (s * s * (3.0 - 2.0 * s) * sharpness, 6.0 * s * (1.0 - s) * sharpness);
    let way = edge_value - flat.value;
    let deficit_slope = inside * deficit * ratio_slope / (1.0 - edge_ratio);
    Exponent {
        value: flat.value + way * step,
        slope: flat.slope + (inside * edge_slope - flat.slope) * step + way * rise * deficit_slope,
        ratio_slope: -way * rise * ratio / (1.0 - edge_ratio),
    }
}

/// R of a flat wall over the distance, in support radii.
enum WallDensity {
    Continuum(KernelKind),
    /// Kernel and particle radius.
    Lattice(KernelKind, f64),
    Mirror(Mirror),
}

impl WallDensity {
    fn new(kind: ClosureKind, kernel: KernelKind, particle_radius: f64) -> WallDensity {
        match kind {
            ClosureKind::Lattice => WallDensity::Lattice(kernel, particle_radius),
            ClosureKind::Mirror => WallDensity::Mirror(Mirror::new(kernel, particle_radius)),
            _ => WallDensity::Continuum(kernel),
        }
    }

    /// R and R'; in the solid along a tangent.
    fn at(&self, d: f64) -> [f64; 2] {
        let outside = d.max(0.0);
        let [value, slope] = match self {
            WallDensity::Mirror(mirror) => return mirror.density(d),
            WallDensity::Continuum(kernel) => plane::density(*kernel, outside),
            WallDensity::Lattice(kernel, radius) => lattice::density(*kernel, *radius, outside)
                .unwrap_or_else(|| plane::density(*kernel, outside)),
        };
        [value + slope * d.min(0.0), slope]
    }
}

/// beta and its derivative.
fn exponent_of_plane(kernel: Kernel, d: f64) -> [f64; 2] {
    with_slopes(|d| [plane::exponent(kernel.kind(), d)], d, -3.0, 1.0)[0]
}

/// Functions and their derivatives, from differences within low..=high.
fn with_slopes<const N: usize>(f: impl Fn(f64) -> [f64; N], d: f64, low: f64, high: f64) -> [[f64; 2]; N] {
    const STEP: f64 = 1e-5;
    let (from, to) = ((d - STEP).max(low), (d + STEP).min(high));
    let (value, below, above) = (f(d), f(from), f(to));
    std::array::from_fn(|n| [value[n], (above[n] - below[n]) / (to - from)])
}

#[cfg(test)]
mod tests;
