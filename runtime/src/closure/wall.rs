//! Closures that take what is near for a wall: at a distance, with more or less volume than a flat one.
//!
//! With the half space's density R(d), its volume V_plane(d) and beta(d) ([`plane`])
//! ```text
//! rho_B = rho_0 R(Phi) (V / V_plane(Phi))^beta(Phi)
//! ```
//! `calibrated` is that; `wedge` lets the exponent grow at convex edges ([`wedge`](super::wedge)); `lattice`
//! has another R ([`lattice`](super::lattice)). Inside the solid R goes on along its tangent.

use super::model::{BoundaryDensity, Model, Particle, Probe, Seen};
use super::plane;
use super::table::{Table, with_slopes};
use crate::kernel::Kernel;
use crate::sample::Surface;

/// Intervals of the tables in a support radius: the interpolated density is within 1e-8 of the integral.
const PER_RADIUS: usize = 128;

/// Distance, in support radii, beyond which the edge's exponent is held: both densities vanish at 1, and are below 1e-4
/// here.
pub(super) const LAST_EDGE: f64 = 0.9;

/// Depth below the surface, in support radii, at which a probe tells an edge from a ball.
const PROBE_DEPTH: f64 = 0.25;

/// How much nearer than [`PROBE_DEPTH`] to the surface, in parts of it, a probe at an edge is: of 90 degrees 0.29, of
/// 120 degrees 0.13. Below it the exponent is led over to that of a ball.
const PROBE_EDGE: f64 = 0.15;

/// Part of an edge's volume deficit below which a probe isn't worth its time: there the exponents differ by less than 3
/// % of the way, the densities by 0.2 %.
const PROBE_FROM: f64 = 0.1;

/// What is tabulated of walls.
#[derive(Debug)]
pub(super) struct Walls {
    support_radius: f64,
    per_radius: f64,
    /// -ln r^3.
    log_unit: f64,
    /// Over Phi / r: R, ln(V_plane / r^3), beta.
    pub(super) plane: Table<3>,
    /// Over Phi / r: V_edge / V_plane, the exponent there.
    edges: Option<Table<2>>,
}

/// What is known of the solid around a particle, as far as it is a wall.
struct FlatWall {
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

impl Walls {
    /// With the half space's density R and its derivative over the distance d >= 0 (in support radii), and what edges
    /// are.
    pub fn new(kernel: Kernel, density: impl Fn(f64) -> [f64; 2], edges: Option<Table<2>>) -> Walls {
        let radius = kernel.support_radius();
        // In the solid along a tangent.
        let density = |d: f64| {
            let [value, slope] = density(d.max(0.0));
            [value + slope * d.min(0.0), slope]
        };
        let plane = Table::new(-2.0, 1.0, 3 * PER_RADIUS, |d| {
            let [volume, slope] = plane::volume(d);
            [density(d), [volume.ln(), slope / volume], exponent_of_plane(kernel, d)]
        });
        Walls {
            support_radius: radius,
            per_radius: 1.0 / radius,
            log_unit: -3.0 * radius.ln(),
            plane: plane.limit(0),
            edges,
        }
    }

    #[inline]
    fn wall(&self, surface: &Surface, probe: Option<Probe>) -> FlatWall {
        let d = surface.distance * self.per_radius;
        let [density, log_plane, [value, slope]] = self.plane.at(d);
        let log_ratio = surface.volume.ln() + self.log_unit - log_plane[0];
        let flat = Exponent { value, slope, ratio_slope: 0.0 };
        let exponent = match &self.edges {
            Some(edges) if log_ratio < 0.0 => {
                towards_edge(flat, edges, d, log_ratio.exp(), || self.sharpness(surface, probe))
            }
            _ => flat,
        };
        FlatWall { density, log_ratio, log_plane_slope: log_plane[1], exponent }
    }

    /// How much of an edge, 0 to 1, a place is that could be one; without a probe it is taken for one.
    #[inline]
    fn sharpness(&self, surface: &Surface, probe: Option<Probe>) -> f64 {
        let Some(distance) = probe else { return 1.0 };
        let depth = PROBE_DEPTH * self.support_radius;
        let nearer = 1.0 + distance(surface.closest_point - depth * surface.normal) / depth;
        (nearer / PROBE_EDGE).clamp(0.0, 1.0)
    }

    #[inline]
    fn calibrated(&self, seen: Seen, wall: &FlatWall) -> BoundaryDensity {
        let FlatWall { density: [value, slope], log_ratio, log_plane_slope, exponent } = *wall;
        let (surface, factor) = (seen.surface, (exponent.value * log_ratio).exp());
        let density = value * factor;
        let gradient = match seen.volume_gradient {
            None => slope * factor * self.per_radius * surface.normal,
            Some(volume_gradient) => {
                let power = exponent.value + exponent.ratio_slope * log_ratio;
                let along = slope * factor + density * (exponent.slope * log_ratio - power * log_plane_slope);
                along * self.per_radius * surface.normal + density * power / surface.volume * volume_gradient
            }
        };
        BoundaryDensity { density, gradient, point: surface.closest_point }
    }
}

impl Model for Walls {
    fn density(&self, particle: Particle) -> Option<BoundaryDensity> {
        let wall = self.wall(particle.seen.surface, particle.probe);
        Some(self.calibrated(particle.seen, &wall))
    }
}

/// The exponent at distance d of a place that has `ratio` < 1 of a flat wall's volume: from the flat wall's to the
/// edge's by a smooth step, which follows the way from the face of an edge around it to within 4 %.
fn towards_edge(
    flat: Exponent,
    edges: &Table<2>,
    d: f64,
    ratio: f64,
    sharpness: impl FnOnce() -> f64,
) -> Exponent {
    let [[edge_ratio, ratio_slope], [edge_value, edge_slope]] = edges.at(d);
    let inside = if (0.0..LAST_EDGE).contains(&d) { 1.0 } else { 0.0 };
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

/// beta and its derivative.
fn exponent_of_plane(kernel: Kernel, d: f64) -> [f64; 2] {
    with_slopes(|d| [plane::exponent(kernel.kind(), d)], d, -3.0, 1.0)[0]
}
