//! Particles that can't be where they were put: in a body, out of the domain, or on top of another.

use super::numbers::Region;
use glam::DVec3;
use volmap_fluid::cubes::Cubes;
use volmap_runtime::{PosedMap, Values};

/// Particles closer to a body than this many rp are left out. It is less than 0.25, the distance that a map with cells
/// of half the support radius gives for a particle in a tank's corner, which must stay.
pub const BODY_MARGIN: f64 = 0.2;
/// Points per query of a map.
const BLOCK: usize = 4096;

/// Drops the points that lie in a body or closer to it than `margin`, metres. Returns how many.
pub(super) fn drop_in_bodies(points: &mut Vec<DVec3>, bodies: &[PosedMap], margin: f64) -> u64 {
    let before = points.len();
    let mut values: Vec<Values> = Vec::new();
    for body in bodies {
        let mut kept = Vec::with_capacity(points.len());
        for block in points.chunks(BLOCK) {
            body.sample_batch(block, &mut values);
            kept.extend(
                block.iter().zip(&values).filter(|(_, at)| at.distance >= margin).map(|(point, _)| *point),
            );
        }
        *points = kept;
    }
    (before - points.len()) as u64
}

/// Drops the points out of a box. Returns how many.
pub(super) fn drop_outside(points: &mut Vec<DVec3>, domain: Option<&Region>) -> u64 {
    let before = points.len();
    if let Some(domain) = domain {
        points.retain(|&point| domain.contains(point));
    }
    (before - points.len()) as u64
}

/// The particles that were placed so far, sorted into cubes of the least distance.
pub(super) struct Placed {
    cubes: Cubes<()>,
    bounds: Vec<[DVec3; 2]>,
}

impl Placed {
    /// No particles yet; those closer than `least` are duplicates.
    pub fn new(least: f64) -> Placed {
        Placed { cubes: Cubes::new(least), bounds: Vec::new() }
    }

    /// Drops the points that are too close to those of other sources. Returns how many.
    pub fn drop_duplicates(&self, points: &mut Vec<DVec3>) -> u64 {
        let before = points.len();
        points.retain(|&point| !self.is_taken(point));
        (before - points.len()) as u64
    }

    /// Adds a source's points. Those that no box of `later` sources reaches are not kept.
    pub fn add(&mut self, points: &[DVec3], later: &[[DVec3; 2]]) {
        let least = self.cubes.edge();
        for &point in points.iter().filter(|&&point| is_reached(point, later, least)) {
            self.cubes.add(point, ());
        }
        self.bounds.extend(bounds(points));
    }

    fn is_taken(&self, point: DVec3) -> bool {
        let least = self.cubes.edge();
        let limit = least * least * (1.0 - 1e-6);
        is_reached(point, &self.bounds, least)
            && self.cubes.around(point).any(|(other, ())| other.distance_squared(point) < limit)
    }
}

/// Whether a point is in one of these boxes, or no farther than the least distance from it.
fn is_reached(point: DVec3, boxes: &[[DVec3; 2]], least: f64) -> bool {
    boxes.iter().any(|[low, high]| point.cmpge(*low - least).all() && point.cmple(*high + least).all())
}

/// The box of some points, if there are any.
pub(super) fn bounds(points: &[DVec3]) -> Option<[DVec3; 2]> {
    let first = *points.first()?;
    Some(points.iter().fold([first; 2], |[low, high], &point| [low.min(point), high.max(point)]))
}
