//! Which vertices are one.

use glam::DVec3;
use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};

/// For every vertex the one that it becomes: the earliest at an equal position (-0 equals 0), then
/// an earlier one within `tolerance` that stays. Finite positions only.
pub fn weld(positions: &[[f64; 3]], tolerance: f64) -> Vec<u32> {
    let mut target = weld_equal(positions);
    if tolerance > 0.0 {
        weld_near(positions, tolerance, &mut target);
    }
    target
}

fn weld_equal(positions: &[[f64; 3]]) -> Vec<u32> {
    let mut places = Places::new(positions);
    (0..positions.len() as u32).map(|k| places.earliest(k)).collect()
}

/// A hash table of positions, by open addressing. Its keys are drawn anew for each table, so that no
/// file can be made to collide; what is found doesn't depend on them.
struct Places<'a> {
    positions: &'a [[f64; 3]],
    /// Vertices that are the earliest of their positions, or `FREE`; a power of two of slots.
    slots: Vec<u32>,
    used: usize,
    /// What was found last for a hash: equal positions are mostly near each other in a file, and this,
    /// unlike the slots of a large mesh, stays in the cache.
    recent: Vec<u32>,
    keys: [u64; 3],
}

const FREE: u32 = u32::MAX;
const RECENT: usize = 1 << 14;

impl Places<'_> {
    fn new(positions: &[[f64; 3]]) -> Places<'_> {
        let random = RandomState::new();
        let keys = [0, 1, 2].map(|k: u64| random.hash_one(k));
        Places { positions, slots: vec![FREE; 1024], used: 0, recent: vec![0; RECENT], keys }
    }

    /// The earliest vertex at the position of `k`; those before `k` were asked for already.
    #[inline]
    fn earliest(&mut self, k: u32) -> u32 {
        let bits = self.bits(k);
        let hash = self.hash(bits);
        let recent = hash >> (64 - RECENT.ilog2());
        let candidate = self.recent[recent as usize];
        if candidate < k && self.bits(candidate) == bits {
            return candidate;
        }
        let found = self.find(hash, bits, k);
        self.recent[recent as usize] = found;
        found
    }

    fn find(&mut self, hash: u64, bits: [u64; 3], k: u32) -> u32 {
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        while self.slots[slot] != FREE {
            if self.bits(self.slots[slot]) == bits {
                return self.slots[slot];
            }
            slot = (slot + 1) & mask;
        }
        self.slots[slot] = k;
        self.used += 1;
        if 2 * self.used > self.slots.len() {
            self.grow();
        }
        k
    }

    fn grow(&mut self) {
        let slots = vec![FREE; 4 * self.slots.len()];
        let mask = slots.len() - 1;
        let old = std::mem::replace(&mut self.slots, slots);
        for k in old.into_iter().filter(|&k| k != FREE) {
            let mut slot = self.hash(self.bits(k)) as usize & mask;
            while self.slots[slot] != FREE {
                slot = (slot + 1) & mask;
            }
            self.slots[slot] = k;
        }
    }

    /// Of a position, with 0 for -0.
    #[inline]
    fn bits(&self, k: u32) -> [u64; 3] {
        self.positions[k as usize].map(|c| (c + 0.0).to_bits())
    }

    #[inline]
    fn hash(&self, [x, y, z]: [u64; 3]) -> u64 {
        let [a, b, c] = self.keys;
        folded(folded(x ^ a, y ^ b) ^ z, c)
    }
}

/// Both halves of the product, joined.
#[inline]
fn folded(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    product as u64 ^ (product >> 64) as u64
}

/// Greedy, in the file's order: a vertex joins the nearest one that stays, or stays itself. Cells of
/// the grid are as wide as the tolerance, so all candidates are in 27 cells. The map is only looked
/// up, never iterated.
fn weld_near(positions: &[[f64; 3]], tolerance: f64, target: &mut [u32]) {
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut joined = vec![u32::MAX; positions.len()];
    for k in 0..positions.len() {
        if target[k] as usize != k {
            joined[k] = joined[target[k] as usize];
            continue;
        }
        let p = positions[k];
        let cell = p.map(|c| (c / tolerance).floor() as i64);
        joined[k] = match nearest(positions, &grid, cell, p, tolerance) {
            Some(stays) => stays,
            None => {
                grid.entry(cell).or_default().push(k as u32);
                k as u32
            }
        };
    }
    target.copy_from_slice(&joined);
}

fn nearest(
    positions: &[[f64; 3]],
    grid: &HashMap<[i64; 3], Vec<u32>>,
    cell: [i64; 3],
    p: [f64; 3],
    tolerance: f64,
) -> Option<u32> {
    let mut best: Option<(f64, u32)> = None;
    for shift in 0..27 {
        let step = [shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1];
        let near: [i64; 3] = std::array::from_fn(|i| cell[i].saturating_add(step[i]));
        for &candidate in grid.get(&near).into_iter().flatten() {
            let apart = DVec3::from(p) - DVec3::from(positions[candidate as usize]);
            // Without overflow, unlike `DVec3::length`.
            let distance = apart.x.hypot(apart.y).hypot(apart.z);
            if distance <= tolerance && best.is_none_or(|best| (distance, candidate) < best) {
                best = Some((distance, candidate));
            }
        }
    }
    best.map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minus_zero_is_zero() {
        let positions = [[0.0, -0.0, 1.0], [-0.0, 0.0, 1.0], [0.0, 0.0, 1.0 + 1e-15]];
        assert_eq!(weld(&positions, 0.0), [0, 0, 2]);
    }

    /// As by sorting, also when the table grows.
    #[test]
    fn the_earliest_of_equal_positions_stays() {
        let positions: Vec<[f64; 3]> = (0..20_000u64)
            .map(|k| k.wrapping_mul(0x9E37_79B9_7F4A_7C15))
            .map(|random| [60, 56, 52].map(|shift| (random >> shift & 15) as f64 * 0.1))
            .collect();
        let mut order: Vec<usize> = (0..positions.len()).collect();
        order.sort_by(|&i, &j| positions[i].partial_cmp(&positions[j]).unwrap());
        let mut expected = vec![0; positions.len()];
        for group in order.chunk_by(|&i, &j| positions[i] == positions[j]) {
            group.iter().for_each(|&k| expected[k] = group[0] as u32);
        }
        let target = weld(&positions, 0.0);
        assert!(target.iter().enumerate().filter(|&(k, &to)| k == to as usize).count() > 2_000);
        assert_eq!(target, expected);
    }

    #[test]
    fn near_vertices_join_across_cells() {
        let positions = [[0.99, 0.0, 0.0], [1.01, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert_eq!(weld(&positions, 0.5), [0, 0, 2, 2]);
        assert_eq!(weld(&positions, 0.01), [0, 1, 2, 2]);
    }
}
