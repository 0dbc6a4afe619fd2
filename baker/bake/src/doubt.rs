//! How far a map can be trusted: whether it has a solid, and at what part of its nodes the sign is in doubt.
//!
//! Winding numbers of closed meshes are integers, and the sign is exact. Elsewhere it is a guess, which is good where
//! the direction of the closest face says the same. So both are compared at some of the nodes, which costs little
//! beside the bake of such a mesh.

use crate::error::Error;
use crate::random::Random;
use crate::sdf::{BoundaryDistance, SignComparison, compare_signs};
use crate::stage::Stage;
use crate::watch::Watch;
use glam::DVec3;

/// Part of the nodes at which the sign may be in doubt. Measured on a duck and on cubes with holes: small holes give
/// less than 0.3 %, wide ones, half shells and sheets 2 % to 50 % (`README.md`, "Signs").
pub const MAX_SIGN_DISAGREEMENTS: f64 = 0.01;

/// Part of the support radius that a node must lie inside to count: sheets have nodes that rounding puts there.
const ROUNDING: f64 = 1e-9;

/// Nodes at which the signs are compared if not at all of them. At the limit the part is known to 0.16 %.
const SAMPLED: usize = 4096;
const SEED: u64 = 1;

/// Whether a node lies in the solid, by the distances at all nodes (metres).
pub fn has_solid(mut distances: impl Iterator<Item = f64>, support_radius: f64) -> bool {
    distances.any(|phi| phi < -ROUNDING * support_radius)
}

/// Both signs at the nodes, `count` of them at these places: at all of them if that is asked for, else at some of them if
/// the sign isn't exact.
pub(crate) fn compare_at_nodes(
    phi: &BoundaryDistance,
    count: usize,
    places: impl Iterator<Item = DVec3>,
    at_all: bool,
    watch: &Watch,
) -> Result<Option<SignComparison>, Error> {
    if !at_all && phi.mesh.has_integer_winding() {
        return Ok(None);
    }
    let nodes: Vec<DVec3> = if at_all { places.collect() } else { picked(count, places) };
    let work = watch.begin(Stage::CheckSign.step(), nodes.len() as u64)?;
    Ok(Some(compare_signs(&phi.mesh, &nodes, &work)?))
}

/// A node at random of each of up to [`SAMPLED`] stretches of equal length.
fn picked(count: usize, mut places: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    let length = count.div_ceil(SAMPLED).max(1);
    let mut random = Random::new(SEED);
    let mut next = 0;
    let pick = |first: usize| {
        let index = first + random.below(length.min(count - first));
        let place = places.nth(index - next);
        next = index + 1;
        place
    };
    (0..count).step_by(length).filter_map(pick).collect()
}
