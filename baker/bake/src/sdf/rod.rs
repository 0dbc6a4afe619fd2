//! How wide a rod of the solid is where a line passes it: bars, wires and needles, thin in two directions.
//!
//! From outside a rod looks like any edge of the surface. What tells it is that the way through the surface leaves the
//! solid again within `reach`, and that from there no way leads to deeper places: the depth is climbed from ball to
//! ball. In a wedge it goes on rising, in a wall the solid goes on to one side.

use glam::DVec3;

use super::boundary_distance::{BoundaryDistance, SignedDistance};

/// Balls of a climb, and steps over the depth: what is left of the way across a rod after the first half is nothing.
const BALLS: usize = 32;
const STEP: f64 = 1.0 / 3.0;
/// In wedges the depth rises by more than that in the second half: of 15 degrees and more.
const RISE: f64 = 1.05;
/// How often the way in is halved to find the solid: rods down to a thousandth of the reach.
const HALVINGS: i32 = 10;
/// Depths below this part of the reach are rounding.
const NOTHING: f64 = 1e-6;
/// Directions along the surface in which the solid is looked for.
const AROUND: usize = 8;

/// Width, metres, of the rod at a place in it or beside it, whose surface is the closest there at `surface`, if there
/// is one and it is below `reach`: twice the largest depth. None where the surface is moved by a thickness, too.
pub fn rod_width(phi: &BoundaryDistance, place: DVec3, surface: DVec3, reach: f64) -> Option<f64> {
    let inwards = (surface - place).try_normalize().filter(|_| phi.thickness == 0.0)?;
    let is_inside = |p: DVec3| phi.at(p) < 0.0;
    let way_in = || {
        let leaves_again = !is_inside(surface + reach * inwards);
        let mut ways = (1..=HALVINGS).map(|halvings| surface + reach * 0.5_f64.powi(halvings) * inwards);
        ways.find(|p| leaves_again && is_inside(*p))
    };
    let inside = if is_inside(place) { place } else { way_in()? };
    let (centre, across, depth) = climb(phi, inside, 0.5 * reach)?;
    if depth < NOTHING * reach {
        return None;
    }
    let first = across.any_orthonormal_vector();
    let second = across.cross(first);
    let goes_on = |k: usize| {
        let (sin, cos) = (k as f64 * std::f64::consts::TAU / AROUND as f64).sin_cos();
        is_inside(centre + reach * (cos * first + sin * second))
    };
    let around: Vec<usize> = (0..AROUND).filter(|k| goes_on(*k)).collect();
    // To both ends, to one or to none; a wall goes on to one side at least.
    let is_rod = match around[..] {
        [] | [_] => true,
        [a, b] => b - a == AROUND / 2,
        _ => false,
    };
    is_rod.then_some(2.0 * depth)
}

/// The deepest place found from one inside, the way from the surface there, and its depth, if that stays below a bound
/// and rises no more.
fn climb(phi: &BoundaryDistance, inside: DVec3, bound: f64) -> Option<(DVec3, DVec3, f64)> {
    let (mut at, mut known) = (inside, f64::INFINITY);
    let mut deepest = [(inside, DVec3::ZERO, 0.0); 2];
    for ball in 0..BALLS {
        let closest = phi.mesh.closest_within(at, known);
        let depth = closest.distance_squared.sqrt();
        let away = (at - closest.point).try_normalize()?;
        if depth >= bound {
            return None;
        }
        let half = &mut deepest[2 * ball / BALLS];
        if depth > half.2 {
            *half = (at, away, depth);
        }
        // No farther than the ball is free of the surface.
        at += STEP * depth * away;
        known = (1.0 + STEP) * depth * (1.0 + 1e-9);
    }
    let [first, second] = deepest;
    (second.2 <= RISE * first.2).then_some(if second.2 > first.2 { second } else { first })
}
