//! Points on the surface of a mesh: as many as squares of the wanted distance fit its area, spread evenly.
//!
//! Yuksel 2015, *Sample Elimination for Generating Poisson Disk Sample Sets*: of five times as many random points,
//! the one that is most crowded goes, until enough are left. That is blue noise, which is denser here and thinner
//! there, and a wall that slides under water drags it along by these bumps. So the points then push each other along
//! the surface, as in Turk 1992, *Re-Tiling Polygonal Surfaces*, until they lie as evenly as they can.
//!
//! Distances are straight ones, so the sides of a thin plate share its points. The same mesh and distance give the same
//! points everywhere.

use crate::cells::Cells;
use crate::settings::BoundarySampling;
use glam::IVec3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use volmap_bake::random::Random;
use volmap_bake::sdf::bvh::Bvh;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::DVec3;

/// Random points for each that is left.
const CANDIDATES: usize = 5;
/// Exponent of the weight, and the two of its limit: section 3 of the paper, alpha, beta and gamma.
const ALPHA: i32 = 8;
const BETA: f64 = 0.65;
const GAMMA: f64 = 1.5;
/// How often points push each other, how far they reach, and how far they go for the push of one that is right beside
/// them: in wanted distances. Water in a ball that turns is given a hundredth of the energy that blue noise gives it;
/// 100 times and a reach of 3 leave four fifths of that.
const ROUNDS: usize = 30;
const REACH: f64 = 2.5;
const STRIDE: f64 = 0.2;

/// How many points a mesh gets at this distance (metres); 0 if it has no area.
pub fn count(mesh: &TriangleMesh, distance: f64) -> u64 {
    let squares = areas(mesh).sum::<f64>() / (distance * distance);
    if squares > 0.0 { squares.round().max(1.0) as u64 } else { 0 }
}

/// Points on a mesh, `distance` (metres) from each other about: [`count`] of them.
pub fn sample(mesh: &TriangleMesh, distance: f64, kind: BoundarySampling) -> Vec<DVec3> {
    let wanted = count(mesh, distance) as usize;
    let candidates = scatter(mesh, CANDIDATES * wanted);
    let noise = eliminate(candidates, wanted, areas(mesh).sum());
    match kind {
        BoundarySampling::Even => even_out(mesh, noise, distance),
        BoundarySampling::BlueNoise => noise,
    }
}

fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [DVec3; 3]> {
    mesh.triangles.iter().map(|triangle| triangle.map(|v| DVec3::from(mesh.vertices[v as usize])))
}

fn areas(mesh: &TriangleMesh) -> impl Iterator<Item = f64> {
    corners(mesh).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
}

/// Random points, evenly over the area: the n-th in the n-th of equal parts of it.
fn scatter(mesh: &TriangleMesh, count: usize) -> Vec<DVec3> {
    let mut random = Random::new(1);
    let part = areas(mesh).sum::<f64>() / count.max(1) as f64;
    let (mut points, mut passed) = (Vec::with_capacity(count), 0.0);
    let mut next = random.unit() * part;
    for ([a, b, c], area) in corners(mesh).zip(areas(mesh)) {
        while next < passed + area && points.len() < count {
            let (s, t) = (random.unit().sqrt(), random.unit());
            points.push(a + s * ((b - a) + t * (c - b)));
            next = (points.len() as f64 + random.unit()) * part;
        }
        passed += area;
    }
    points
}

/// The most crowded goes first; of equals the one with the lower index.
#[derive(PartialEq)]
struct Crowded {
    weight: f64,
    point: usize,
}

impl Eq for Crowded {}

impl Ord for Crowded {
    fn cmp(&self, other: &Self) -> Ordering {
        self.weight.total_cmp(&other.weight).then(other.point.cmp(&self.point))
    }
}

impl PartialOrd for Crowded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Leaves `wanted` of the points, which lie on a surface of this area (m^2).
fn eliminate(points: Vec<DVec3>, wanted: usize, area: f64) -> Vec<DVec3> {
    if points.len() <= wanted {
        return points;
    }
    // Largest radius of as many discs on a plane, Eq. 2.
    let largest = (area / (2.0 * 3_f64.sqrt() * wanted as f64)).sqrt();
    let least = largest * BETA * (1.0 - (wanted as f64 / points.len() as f64).powf(GAMMA));
    let crowd = Crowd::new(points, 2.0 * largest, 2.0 * least);
    let mut weights: Vec<f64> = (0..crowd.points.len()).map(|point| crowd.weight(point)).collect();
    let mut is_left = vec![true; weights.len()];
    let mut left = weights.len();
    let all = weights.iter().enumerate();
    let mut heap: BinaryHeap<Crowded> = all.map(|(point, &weight)| Crowded { weight, point }).collect();
    while left > wanted {
        let Some(Crowded { weight, point }) = heap.pop() else { break };
        // Weights only fall: one that has fallen since goes back to its place.
        if weight != weights[point] {
            heap.push(Crowded { weight: weights[point], point });
            continue;
        }
        is_left[point] = false;
        left -= 1;
        crowd.around(point, |other, weight| weights[other] -= weight);
    }
    crowd.points.iter().zip(is_left).filter(|(_, is_left)| *is_left).map(|(point, _)| *point).collect()
}

/// Lets points that are `distance` (metres) apart push each other along the surface.
fn even_out(mesh: &TriangleMesh, mut points: Vec<DVec3>, distance: f64) -> Vec<DVec3> {
    if points.is_empty() {
        return points;
    }
    let surface = Bvh::new(&corners(mesh).collect::<Vec<_>>());
    for _ in 0..ROUNDS {
        let crowd = Crowd::new(points, REACH * distance, 0.0);
        let step = |point: usize| {
            let way = STRIDE * distance * crowd.push(point);
            // The point was on the surface, so that is no farther than the way.
            surface.closest(crowd.points[point] + way, way.length()).point
        };
        points = (0..crowd.points.len()).into_par_iter().map(step).collect();
    }
    points
}

/// Points by cells.
struct Crowd {
    points: Vec<DVec3>,
    cells: Cells,
    /// Farther ones don't matter, nearer ones than `least` no more than that: metres.
    reach: f64,
    least: f64,
}

impl Crowd {
    fn new(points: Vec<DVec3>, reach: f64, least: f64) -> Crowd {
        let (mut cells, mut order) = (Cells::default(), Vec::new());
        cells.sort(&points, reach, &mut order);
        let points = order.iter().map(|&old| points[old as usize]).collect();
        Crowd { points, cells, reach, least }
    }

    fn weight(&self, point: usize) -> f64 {
        let mut sum = 0.0;
        self.around(point, |_, weight| sum += weight);
        sum
    }

    /// Calls `f` with every other point in reach and its weight, Eq. 3.
    fn around(&self, point: usize, mut f: impl FnMut(usize, f64)) {
        self.near(point, |other, distance| {
            f(other, (1.0 - distance.max(self.least) / self.reach).powi(ALPHA));
        });
    }

    /// Sum of the directions away from the others in reach, the less the farther they are.
    fn push(&self, point: usize) -> DVec3 {
        let mut sum = DVec3::ZERO;
        self.near(point, |other, distance| {
            let away = self.points[point] - self.points[other];
            sum += (1.0 - distance / self.reach).powi(2) / distance.max(f64::MIN_POSITIVE) * away;
        });
        sum
    }

    /// Calls `f` with every other point in reach and its distance.
    fn near(&self, point: usize, mut f: impl FnMut(usize, f64)) {
        let at = self.points[point];
        let cell = self.cells.cell(at);
        for n in 0..27 {
            let near = cell + IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
            for other in self.cells.particles(near) {
                let distance = self.points[other].distance(at);
                if other != point && distance < self.reach {
                    f(other, distance);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::BoundarySampling::{BlueNoise, Even};
    use crate::shapes::{ball, cuboid};

    /// Distance of each point to the nearest other one.
    fn nearest(points: &[DVec3]) -> Vec<f64> {
        let to_others = |i: usize| {
            let others = points.iter().enumerate().filter(move |(j, _)| *j != i);
            others.map(|(_, x)| x.distance(points[i])).fold(f64::INFINITY, f64::min)
        };
        (0..points.len()).map(to_others).collect()
    }

    #[test]
    fn points_are_as_many_as_told_and_apart() {
        for (mesh, distance) in [(cuboid(DVec3::ZERO, DVec3::new(1.0, 0.7, 0.4)), 0.05), (ball(0.5, 4), 0.05)]
        {
            // The densest packing would have 1.07 of the distance.
            for (kind, bounds) in [(BlueNoise, [0.6, 0.8]), (Even, [0.7, 0.92])] {
                let points = sample(&mesh, distance, kind);
                assert_eq!(points.len() as u64, count(&mesh, distance));
                let apart = nearest(&points);
                let least = apart.iter().copied().fold(f64::INFINITY, f64::min) / distance;
                let mean = apart.iter().sum::<f64>() / points.len() as f64 / distance;
                assert!(least > bounds[0] && mean > bounds[1], "{kind:?}: {least} {mean}");
                assert_eq!(points, sample(&mesh, distance, kind));
            }
        }
    }

    #[test]
    fn points_lie_on_the_surface_and_leave_no_holes() {
        let size = DVec3::new(1.0, 0.7, 0.4);
        for (kind, hole) in [(BlueNoise, 1.0), (Even, 0.85)] {
            let points = sample(&cuboid(DVec3::ZERO, size), 0.05, kind);
            let off = |x: &DVec3| {
                x.min(size - *x).min_element().abs()
                    + (x.min(DVec3::ZERO) + (size - *x).min(DVec3::ZERO)).length()
            };
            assert!(points.iter().all(|x| off(x) < 1e-12));
            // Places on the top face, its edges and corners among them.
            for n in 0..1600 {
                let place = DVec3::new(f64::from(n % 40) / 39.0, 0.7, 0.4 * f64::from(n / 40) / 39.0);
                let near = points.iter().map(|x| x.distance(place)).fold(f64::INFINITY, f64::min);
                assert!(near < hole * 0.05, "{kind:?}: {near} at {place}");
            }
        }
    }

    #[test]
    fn nothing_has_no_points() {
        assert_eq!(sample(&TriangleMesh::default(), 0.1, Even).len(), 0);
        let flat = TriangleMesh { vertices: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 2]] };
        assert_eq!((count(&flat, 0.1), sample(&flat, 0.1, Even).len()), (0, 0));
    }
}
