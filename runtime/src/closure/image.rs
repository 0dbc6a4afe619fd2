//! Closure `mirror`: the density of the fluid's mirror image as a function of the boundary's volume.
//!
//! The image's density R_mirror ([`mirror`](super::mirror)) ends at half of the kernel's support radius r. So does the
//! volume V of a map of support radius r / 4, whose extension (Eq. 13 of Bender et al. 2020) reaches as far again as
//! its ball; and at a flat wall one is nearly in proportion to the other:
//! ```text
//! R_mirror(d) = F(V_plane(d)),   rho_B = rho_0 F(V),   grad rho_B = rho_0 F'(V) grad V
//! ```
//! V is a sum over the solid, and so F(V) is, nearly, the image's density wherever walls meet as well: at r = 4 rp the
//! particle next to a concave edge gets 0.26 (0.28 to fill up a lattice), that in a corner 0.35 (0.39). And V is smooth
//! where the distance isn't: at the ridge of a concave edge the closest point jumps, and along it a fluid shivers whose
//! density follows the distance. Distance and normal don't matter here.
//!
//! In two dimensions all is the same with areas.

use super::mirror::Mirror;
use super::model::{BoundaryDensity, Model, Particle, Setup};
use super::plane;
use super::table::Table;
use crate::sample::Surface;
use std::sync::Arc;
use volmap_formats::asset::Dimension;

/// The kernel's support radius over the maps'.
pub(super) const MAPS_PER_RADIUS: f64 = 4.0;

/// Intervals of the tables.
const INTERVALS: usize = 192;
const WIDE_INTERVALS: usize = 64;

/// Distances in the map's support radius: there the volume ends; here the ball is full of solid.
const FARTHEST: f64 = 2.0;
const DEEPEST: f64 = -1.0;

/// F.
#[derive(Debug)]
struct Image {
    /// 1 / (support radius of the map)^d, and 1 / it.
    per_volume: f64,
    per_radius: f64,
    /// Over u, the fourth root of V: F, and the slope of R_mirror over the distance. Both end as powers, u is where
    /// they are smooth.
    table: Table<2>,
    /// Over the distance in r: the half space's volume in the ball of r, m^3, with an end at r / 2.
    wide: Table<1>,
}

pub(super) fn new(setup: &Setup) -> Arc<dyn Model> {
    Arc::new(Image::new(setup))
}

impl Image {
    fn new(&Setup { kernel, particle_radius }: &Setup) -> Image {
        let radius = kernel.support_radius();
        let map_radius = radius / MAPS_PER_RADIUS;
        let (dimension, half_space) = (kernel.dimension(), half_space(kernel.dimension()));
        let mirror = Mirror::new(kernel.kind(), dimension, particle_radius / radius);
        let high = half_space(DEEPEST)[0].sqrt().sqrt();
        let step = high / INTERVALS as f64;
        let nodes = nodes(&mirror, half_space, step);
        let node = |u: f64| {
            let n = (u / step).round() as usize;
            let [value, slope, along] = nodes[n];
            let (below, above) = (nodes[n.saturating_sub(1)], nodes[(n + 1).min(INTERVALS)]);
            // Where the ball is nearly full F grows without limit over u: it must not overshoot (Fritsch and Carlson
            // 1980).
            let least_rise = (value - below[0]).min(above[0] - value).max(0.0);
            let most = if n == 0 { 0.0 } else { 3.0 * least_rise / step };
            [[value, slope.min(most)], [along, (above[2] - below[2]) / (2.0 * step)]]
        };
        Image {
            per_volume: map_radius.powi(-(dimension.count() as i32)),
            per_radius: 1.0 / map_radius,
            table: Table::new(0.0, high, INTERVALS, node),
            wide: Table::new(-0.5, 0.5, WIDE_INTERVALS, |d| {
                wide_volume(d).map(|both| both.map(|v| v * radius.powi(3)))
            }),
        }
    }
}

impl Model for Image {
    /// Without the gradient of the volume its own is that at a flat wall, along the normal. `None` where there is no
    /// volume.
    fn density(&self, particle: Particle) -> Option<BoundaryDensity> {
        let surface = particle.seen.surface;
        let root = (surface.volume * self.per_volume).sqrt().sqrt();
        let [[density, slope], [along, _]] = self.table.at(root);
        let gradient = match particle.seen.volume_gradient {
            Some(of_volume) => slope / (4.0 * root * root * root) * self.per_volume * of_volume,
            None => along.min(0.0) * self.per_radius * surface.normal,
        };
        (root > SMALLEST).then_some(BoundaryDensity { density, gradient, point: surface.closest_point })
    }

    fn volume(&self, surface: &Surface) -> f64 {
        self.wide.at(surface.distance * self.per_radius / MAPS_PER_RADIUS)[0][0]
    }
}

/// The half space's volume for r = 1 and its slope, by a smooth step to zero between 1/4 and 1/2.
fn wide_volume(d: f64) -> [[f64; 2]; 1] {
    let [volume, slope] = plane::volume(d);
    let s = ((0.5 - d) * MAPS_PER_RADIUS).clamp(0.0, 1.0);
    let (step, fall) = (s * s * (3.0 - 2.0 * s), -6.0 * s * (1.0 - s) * MAPS_PER_RADIUS);
    [[volume * step, slope * step + volume * fall]]
}

/// Volume and slope over the distance.
type HalfSpace = fn(f64) -> [f64; 2];

fn half_space(dimension: Dimension) -> HalfSpace {
    match dimension {
        Dimension::Two => plane::area,
        Dimension::Three => plane::volume,
    }
}

/// F, dF/du and the slope of R_mirror over the distance (in the map's support radius) at equal steps of u.
fn nodes(mirror: &Mirror, half_space: HalfSpace, step: f64) -> Vec<[f64; 3]> {
    let mut distance = FARTHEST;
    let mut nodes = vec![[0.0; 3]];
    for n in 1..=INTERVALS {
        let root = step * n as f64;
        distance = distance_of(half_space, root.powi(4), distance);
        let [value, slope] = mirror.density(distance / MAPS_PER_RADIUS);
        let along = slope / MAPS_PER_RADIUS;
        // dF/du = R' / V' dV/du; V' vanishes where the ball is full.
        let slope = along / half_space(distance)[1].min(-f64::MIN_POSITIVE) * 4.0 * root.powi(3);
        nodes.push([value, slope, along]);
    }
    nodes
}

/// u below which the density is less than 1e-9: what is left there is the map's rounding.
const SMALLEST: f64 = 2e-3;

/// Where a flat wall has this volume, below `high`: bisection. Lengths in the map's support radius.
fn distance_of(half_space: HalfSpace, volume: f64, mut high: f64) -> f64 {
    let mut low = DEEPEST;
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if half_space(middle)[0] > volume { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
