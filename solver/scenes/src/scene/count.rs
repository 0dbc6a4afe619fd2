//! As many particles as a space holds: what a lattice has too few is added where most is empty, what it has too many is
//! taken away next to the walls. They are spread afterwards, so it is the number that counts.

use super::space::Space;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use volmap_fluid::cubes::Cubes;

/// Places that are looked at are so far apart, and so deep in the space, in rp: deeper a lattice has no gaps.
const STEP: f64 = 1.0;
const DEPTHS: [f64; 2] = [0.5, 5.0];

/// Adds or removes points of a lattice until there are so many; fewer where no more have room.
pub(super) fn make_count(points: &mut Vec<DVec3>, space: Space, count: usize) {
    if points.len() > count {
        remove(points, space, points.len() - count);
    } else if points.len() < count {
        add(points, space, count - points.len());
    }
}

/// Removes the points that are nearest to the walls; of equal ones the first.
fn remove(points: &mut Vec<DVec3>, space: Space, excess: usize) {
    let depths = space.depths(points);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| depths[a].total_cmp(&depths[b]).then(a.cmp(&b)));
    let mut is_kept = vec![true; points.len()];
    order[..excess].iter().for_each(|&n| is_kept[n] = false);
    let mut kept = is_kept.into_iter();
    points.retain(|_| kept.next() == Some(true));
}

/// Adds points, each where the next one is farthest.
fn add(points: &mut Vec<DVec3>, space: Space, missing: usize) {
    let mut taken = Cubes::new(2.0 * space.rp);
    points.iter().for_each(|&point| taken.add(point, ()));
    let places = candidates(space);
    let mut heap: BinaryHeap<Candidate> =
        (0..places.len()).map(|n| Candidate { distance: nearest(&taken, places[n]), n }).collect();
    let mut left = missing;
    while left > 0 {
        let Some(best) = heap.pop() else { return };
        // What was added since may be nearer.
        let distance = nearest(&taken, places[best.n]);
        if distance < best.distance {
            heap.push(Candidate { distance, ..best });
            continue;
        }
        taken.add(places[best.n], ());
        points.push(places[best.n]);
        left -= 1;
    }
}

/// Places near the walls of a space.
fn candidates(space: Space) -> Vec<DVec3> {
    let Some([low, high]) = space.bounds() else { return Vec::new() };
    let step = STEP * space.rp;
    let counts = ((high - low) / step).floor().as_uvec3();
    let mut out = Vec::new();
    for z in 0..counts.z {
        let at = |x: u32, y: u32| low + step * (DVec3::new(x.into(), y.into(), z.into()) + 0.5);
        let layer: Vec<DVec3> =
            (0..counts.y).flat_map(|y| (0..counts.x).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect();
        let [least, most] = DEPTHS.map(|depth| depth * space.rp);
        let depths = space.depths(&layer);
        out.extend(layer.into_iter().zip(depths).filter(|(_, d)| (least..most).contains(d)).map(|(x, _)| x));
    }
    out
}

/// A place, and how far the nearest point is.
struct Candidate {
    distance: f64,
    n: usize,
}

impl Ord for Candidate {
    /// The farthest first, then that of the lowest number.
    fn cmp(&self, other: &Candidate) -> Ordering {
        self.distance.total_cmp(&other.distance).then(other.n.cmp(&self.n))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Candidate) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Candidate) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// Distance of the nearest point, at most the cubes' edge.
fn nearest(taken: &Cubes<()>, place: DVec3) -> f64 {
    taken.around(place).map(|(other, ())| other.distance(place)).fold(taken.edge(), f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::numbers::Region;

    #[test]
    fn gaps_are_filled_first_and_excess_goes_from_the_walls() {
        let region = Some(Region { min: [0.0; 3], max: [8.0; 3] });
        let space = Space { region, solid: None, bodies: &[], gap: 0.0, rp: 1.0 };
        let lattice = || -> Vec<DVec3> {
            let at = |n: i32| DVec3::new(f64::from(n % 4), f64::from(n / 4 % 4), f64::from(n / 16));
            (0..64).map(|n| 2.0 * at(n) + 1.0).collect()
        };
        let mut points = lattice();
        let corner = points.remove(0);
        make_count(&mut points, space, 64);
        assert_eq!(points.len(), 64);
        assert!(points[63].distance(corner) < 1.0, "{}", points[63]);
        let mut points = lattice();
        make_count(&mut points, space, 60);
        assert_eq!(points.len(), 60);
        let middle = |x: &&DVec3| space.depths(&[**x])[0] > 2.0;
        assert_eq!(points.iter().filter(middle).count(), 8);
    }
}
