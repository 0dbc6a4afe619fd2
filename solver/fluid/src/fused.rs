//! Particles that lie in each other: parted. Between two at one place the kernel has no gradient, so no pressure can
//! ever part them, and they would stay one of twice the mass for good.
//!
//! Looked for now and then only, as such pairs last. Both get the mean of their velocities, and are moved apart by the
//! same way along a direction that depends on their names, if the fluid around leaves room; pressures do the rest. So
//! momentum, angular momentum and centre of mass stay, and energy doesn't grow.

use crate::bodies::Bodies;
use crate::cells::Cells;
use crate::particles::{CHUNK, Particles};
use rayon::prelude::*;
use volmap_runtime::{DVec3, Dimension};

/// Steps from one search to the next: about half a second. Where layers meet in corners, water at rest likes pairs, and
/// parted ones come together again; parted every 8 steps, they kept a tank's lowest layer moving.
const EVERY: u64 = 256;
/// Particles nearer than this part of a spacing lie in each other.
const FUSED: f64 = 0.05;
/// How far each is moved, in spacings: far enough for a gradient, by which pressures part them further. With 0.3 their
/// neighbours were pressed by a tenth.
const WAY: f64 = 0.05;
/// Nearer to another particle than this part of a spacing there is no room; nor nearer to a body.
const NEAREST: f64 = 0.5;
const NEAREST_BODY: f64 = 0.25;
/// Directions that are tried.
const DIRECTIONS: u64 = 16;

/// What pairs are looked for in.
pub struct Pairs<'a> {
    /// Cells of the particles, sorted by them.
    pub cells: &'a Cells,
    /// What particles must not be moved into.
    pub bodies: &'a Bodies,
    /// Spacing of the fluid at rest, metres.
    pub spacing: f64,
    /// In two dimensions they stay in the plane.
    pub dimension: Dimension,
}

/// Whether pairs are looked for in a step.
pub fn is_due(step: u64) -> bool {
    step % EVERY == EVERY - 1
}

impl Pairs<'_> {
    /// Parts all pairs that last: those that a step of `dt` seconds would not part. How many particles were moved.
    pub fn part(&self, particles: &mut Particles, dt: f64) -> usize {
        let mut moved = 0;
        for [a, b] in self.find(&particles.positions) {
            let [u, v] = [a, b].map(|n| DVec3::from_array(particles.velocities[n].map(f64::from)));
            // One that was moved already may be near no more.
            let way = particles.positions[a] - particles.positions[b];
            let reach = FUSED * self.spacing;
            if way.length() >= reach || (u - v).length() * dt >= reach {
                continue;
            }
            let mean = (0.5 * (u + v)).as_vec3().to_array();
            [particles.velocities[a], particles.velocities[b]] = [mean; 2];
            let middle = particles.positions[b] + 0.5 * way;
            if let Some(half) = self.room(particles, [a, b], middle) {
                particles.positions[a] = middle + half;
                particles.positions[b] = middle - half;
                moved += 2;
            }
        }
        moved
    }

    /// All pairs of particles that lie in each other, in their order.
    fn find(&self, positions: &[DVec3]) -> Vec<[usize; 2]> {
        let reach = FUSED * self.spacing;
        let chunk = |chunk: usize| {
            let mut out = Vec::new();
            for a in chunk * CHUNK..positions.len().min((chunk + 1) * CHUNK) {
                for b in self.near(positions[a], reach).filter(|&b| b > a) {
                    if positions[a].distance_squared(positions[b]) < reach * reach {
                        out.push([a, b]);
                    }
                }
            }
            out
        };
        (0..positions.len().div_ceil(CHUNK)).into_par_iter().flat_map_iter(chunk).collect()
    }

    /// Particles of all cells that a cube of twice this edge around a place meets.
    fn near(&self, place: DVec3, reach: f64) -> impl Iterator<Item = usize> {
        let [low, high] = [-reach, reach].map(|way| self.cells.cell(place + way));
        let along = move |axis: usize| low[axis]..=high[axis];
        let cells = along(2)
            .flat_map(move |z| along(1).flat_map(move |y| along(0).map(move |x| glam::IVec3::new(x, y, z))));
        cells.flat_map(|cell| self.cells.particles(cell))
    }

    /// Half of the way from one particle of a pair to the other, so that both have room; none if there is none.
    fn room(&self, particles: &Particles, pair: [usize; 2], middle: DVec3) -> Option<DVec3> {
        let reach = (WAY + NEAREST) * self.spacing;
        let others: Vec<DVec3> = self
            .near(middle, reach)
            .filter(|n| !pair.contains(n))
            .map(|n| particles.positions[n])
            .filter(|x| x.distance(middle) < reach)
            .collect();
        let [first, second] = pair.map(|n| u64::from(particles.ids[n]));
        let seed = first.min(second) << 32 | first.max(second);
        let directions = (0..DIRECTIONS).map(|n| self.direction(seed, n));
        let clearance = |half: DVec3| {
            let away = |end: DVec3| others.iter().map(|x| x.distance(end)).fold(f64::INFINITY, f64::min);
            away(middle + half).min(away(middle - half))
        };
        // The first of those that are best.
        let best = directions.fold((f64::NEG_INFINITY, DVec3::X), |best, direction| {
            let clear = clearance(WAY * self.spacing * direction);
            if clear > best.0 { (clear, direction) } else { best }
        });
        let (clear, half) = (best.0, WAY * self.spacing * best.1);
        let is_room =
            clear >= NEAREST * self.spacing && [half, -half].iter().all(|&way| self.is_out(middle + way));
        is_room.then_some(half)
    }

    fn is_out(&self, place: DVec3) -> bool {
        self.bodies.posed().iter().all(|body| body.values(place).distance >= NEAREST_BODY * self.spacing)
    }

    /// One of several directions that a pair's names give.
    fn direction(&self, seed: u64, number: u64) -> DVec3 {
        let [a, b] = [0, 1].map(|n| unit(mix(seed ^ mix(2 * number + n))));
        let turn = std::f64::consts::TAU * a;
        let height = if self.dimension == Dimension::Two { 0.0 } else { 2.0 * b - 1.0 };
        let across = (1.0 - height * height).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), height)
    }
}

/// SplitMix64 (Steele et al. 2014).
fn mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// From 64 bits to a number from 0 to below 1.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::fill_box;

    const SPACING: f64 = 0.05;

    /// A block in which a particle lies on every tenth one.
    fn doubled() -> Particles {
        let mut places: Vec<DVec3> = fill_box([DVec3::ZERO, DVec3::splat(0.5)], SPACING).collect();
        places.extend(places.clone().iter().step_by(10).map(|x| *x + 1e-4 * DVec3::Y));
        let mut particles = Particles::default();
        let velocity = |n: usize| [0.01 * (n % 7) as f32, 0.1, 0.0];
        let velocities: Vec<[f32; 3]> = (0..places.len()).map(velocity).collect();
        particles.add(&places, &velocities);
        particles
    }

    fn nearest(particles: &Particles) -> f64 {
        let at = &particles.positions;
        let from = |n: usize| at[..n].iter().map(|x| x.distance(at[n])).fold(f64::INFINITY, f64::min);
        (1..at.len()).map(from).fold(f64::INFINITY, f64::min)
    }

    /// Momentum, angular momentum and centre, and energy, of particles of mass 1.
    fn sums(particles: &Particles) -> ([DVec3; 3], f64) {
        let all = particles.positions.iter().zip(&particles.velocities);
        all.fold(([DVec3::ZERO; 3], 0.0), |([p, l, c], e), (&x, v)| {
            let v = DVec3::from_array(v.map(f64::from));
            ([p + v, l + x.cross(v), c + x], e + v.length_squared())
        })
    }

    #[test]
    fn pairs_part_and_nothing_is_gained() {
        let mut particles = doubled();
        let (mut cells, mut order) = (Cells::default(), Vec::new());
        cells.sort(&particles.positions, 2.0 * SPACING, &mut order);
        particles.reorder(&order, &mut Particles::default());
        assert!(nearest(&particles) < 2e-4);
        let (before, energy) = sums(&particles);
        let bodies = Bodies::new(Vec::new(), DVec3::ZERO).unwrap();
        let pairs = Pairs { cells: &cells, bodies: &bodies, spacing: SPACING, dimension: Dimension::Three };
        pairs.part(&mut particles, 1e-3);
        assert!(nearest(&particles) > 0.09 * SPACING, "{}", nearest(&particles));
        let (after, left) = sums(&particles);
        for (a, b) in before.iter().zip(&after) {
            assert!(a.distance(*b) < 1e-5 * a.length(), "{a} {b}");
        }
        assert!(left <= energy);
        // Again: there are none.
        let once = particles.clone();
        pairs.part(&mut particles, 1e-3);
        assert_eq!(particles, once);
    }

    #[test]
    fn pairs_that_part_by_themselves_are_left_alone() {
        let mut particles = Particles::default();
        particles.add(&[DVec3::ZERO, DVec3::splat(1e-4)], &[[3.0, 0.0, 0.0], [-3.0, 0.0, 0.0]]);
        let (mut cells, mut order) = (Cells::default(), Vec::new());
        cells.sort(&particles.positions, 2.0 * SPACING, &mut order);
        let bodies = Bodies::new(Vec::new(), DVec3::ZERO).unwrap();
        let pairs = Pairs { cells: &cells, bodies: &bodies, spacing: SPACING, dimension: Dimension::Three };
        let before = particles.clone();
        pairs.part(&mut particles, 1e-3);
        assert_eq!(particles, before, "they were moved");
        // In the plane they stay in it.
        particles.velocities.fill([0.0; 3]);
        Pairs { dimension: Dimension::Two, ..pairs }.part(&mut particles, 1e-3);
        let [a, b] = particles.positions[..] else { panic!() };
        assert!(a.distance(b) > 0.09 * SPACING && (a.z - b.z).abs() < 1e-12);
    }
}
