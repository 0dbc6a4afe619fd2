//! Closures that take what is near for a wall: at a distance, with more or less volume than a flat one.
//!
//! With the half space's density R(d), its volume V_plane(d) and beta(d) ([`plane`])
//! ```text
//! rho_B = rho_0 R(Phi) (V / V_plane(Phi))^beta(Phi)
//! ```
//! `calibrated` is that; `wedge` lets the exponent grow at convex edges ([`wedge`]); `lattice` has another R ([`lattice`]).

use super::table::Table;
use super::{BoundaryDensity, ClosureKind, lattice, plane, wedge};
use crate::kernel::{Kernel, KernelKind};
use crate::query::Boundary;
use glam::DVec3;

/// Intervals of the tables in a support radius: the interpolated density is within 1e-8 of the integral.
const PER_RADIUS: usize = 128;

/// Intervals of the table of edges, whose values are needed less exactly.
const EDGE_INTERVALS: usize = 32;

/// Part of an edge's volume deficit below which a probe isn't worth its time: there the exponents differ by less than 3 %
/// of the way, the densities by 0.2 %.
const PROBE_FROM: f64 = 0.1;

/// What is tabulated of walls.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Walls {
    per_radius: f64,
    /// -ln r^3.
    log_unit: f64,
    /// Over Phi / r: R, ln(V_plane / r^3), beta.
    pub(super) plane: Table<3>,
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

impl Walls {
    pub fn new(kind: ClosureKind, kernel: Kernel, particle_radius: f64) -> Walls {
        let radius = kernel.support_radius();
        let spacing = (kind == ClosureKind::Lattice).then_some(particle_radius / radius);
        let wall = WallDensity { kernel: kernel.kind(), lattice: spacing };
        let plane = Table::new(-2.0, 1.0, 3 * PER_RADIUS, |d| {
            let [volume, slope] = plane::volume(d);
            [wall.at(d), [volume.ln(), slope / volume], exponent_of_plane(kernel, d)]
        });
        let edges = || {
            let edge = |d: f64| wedge::edge(kernel.kind(), d);
            Table::new(0.0, wedge::LAST, EDGE_INTERVALS, |d| with_slopes(edge, d, 0.0, wedge::LAST))
        };
        Walls {
            per_radius: 1.0 / radius,
            log_unit: -3.0 * radius.ln(),
            plane: plane.limit(0),
            edges: (kind == ClosureKind::Wedge).then(edges),
        }
    }

    /// `sharpness` says how much of an edge, 0 to 1, a place is that could be one; with the volume's gradient (m^2) the density's
    /// is the true one.
    #[inline]
    pub fn density(
        &self,
        boundary: &Boundary,
        volume_gradient: Option<DVec3>,
        sharpness: impl FnOnce() -> f64,
    ) -> BoundaryDensity {
        let wall = self.wall(boundary, sharpness);
        self.calibrated(boundary, &wall, volume_gradient)
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
struct WallDensity {
    kernel: KernelKind,
    /// The particle radius, for particles on a lattice.
    lattice: Option<f64>,
}

impl WallDensity {
    /// R and R'; in the solid along a tangent.
    fn at(&self, d: f64) -> [f64; 2] {
        let outside = d.max(0.0);
        let layers = self.lattice.and_then(|radius| lattice::density(self.kernel, radius, outside));
        let [value, slope] = layers.unwrap_or_else(|| plane::density(self.kernel, outside));
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
