//! The search for neighbours: the particles of a cell share the candidates of its 27 cells, which are laid side by side, and
//! each compares itself with all of them, eight at a time.

use super::Lists;
use crate::blocks::{Block, surroundings};
use crate::cells::Cells;
use crate::pairs::lanes::{LANES, Lanes, Quad};
use crate::pairs::table::{FAR, Quads};
use glam::IVec3;
use std::ops::Range;

/// Room for a block's search.
#[derive(Default)]
pub(super) struct Search {
    /// Lowest cell around the block, and how many there are along each axis.
    corner: IVec3,
    size: IVec3,
    /// Of each of them, its first particle in the table and the number of its particles.
    cells: Vec<[u32; 2]>,
    /// Of cells outside the block: first particle, number of particles, cell.
    around: Vec<[u32; 3]>,
    /// The table's places, coordinate by coordinate, and room for eight more.
    places: [Vec<f32>; 3],
    /// The candidates of a cell, and their places in the table, twice their numbers.
    candidates: [Vec<f32>; 3],
    numbers: Vec<u32>,
    count: usize,
    /// The particle that comes next: its number in the table, and among the candidates.
    next: [usize; 2],
}

impl Search {
    /// Takes what is in a block and around it: into `lists`, which particles a table has, and into `table`, their places, and
    /// one behind them that is far from all, whose number comes back.
    #[inline(always)]
    pub fn begin(
        &mut self,
        cells: &Cells,
        block: &Block,
        places: &[Quad],
        lists: &mut Lists,
        table: &mut Quads,
    ) -> usize {
        let [min, max] = block.occupied;
        (self.corner, self.size) = (min - 1, max - min + 3);
        self.cells.clear();
        self.around.clear();
        lists.table.push(block.particles.start as u32..block.particles.end as u32);
        for (number, cell) in surroundings(block.occupied).enumerate() {
            let particles = cells.particles(cell);
            let [first, count] = [particles.start as u32, particles.len() as u32];
            let is_own = block.particles.contains(&particles.start) && count > 0;
            self.cells.push([if is_own { first - block.particles.start as u32 } else { 0 }, count]);
            if count > 0 && !is_own {
                self.around.push([first, count, number as u32]);
            }
        }
        // Those that follow each other are read together.
        self.around.sort_unstable();
        let mut end = block.particles.len() as u32;
        for &[first, count, cell] in &self.around {
            self.cells[cell as usize][0] = end;
            end += count;
            match &mut lists.table[1..] {
                [.., last] if last.end == first => last.end += count,
                _ => lists.table.push(first..first + count),
            }
        }
        let count = table.fill_places(&lists.table, places);
        self.turn(&table.values()[..count]);
        self.next[0] = 0;
        count
    }

    #[inline(always)]
    fn turn(&mut self, quads: &[Quad]) {
        for (axis, places) in self.places.iter_mut().enumerate() {
            places.resize(places.len().max(quads.len() + LANES), 0.0);
            for (place, quad) in places.iter_mut().zip(quads) {
                *place = quad[axis];
            }
        }
    }

    /// Lays the candidates of a cell side by side: its own `count` particles first.
    #[inline(always)]
    pub fn enter(&mut self, cell: IVec3, count: usize) {
        let at = cell - self.corner;
        let own = (at.z * self.size.y + at.y) * self.size.x + at.x;
        let mut cells = [[0; 2]; 27];
        let mut all = 0;
        for (n, cell) in cells.iter_mut().enumerate() {
            let [x, y, z] = [n % 3, n / 3 % 3, n / 9].map(|n| n as i32 - 1);
            *cell = self.cells[(own + (z * self.size.y + y) * self.size.x + x) as usize];
            all += cell[1] as usize;
        }
        cells.swap(0, 13);
        self.reserve(all);
        self.count = 0;
        for [first, count] in cells {
            self.append(first as usize, count as usize);
        }
        for candidates in &mut self.candidates {
            candidates[self.count..self.count + LANES].fill(FAR);
        }
        debug_assert_eq!(cells[0], [self.next[0] as u32, count as u32]);
        self.next[1] = 0;
    }

    fn reserve(&mut self, count: usize) {
        let room = count + 2 * LANES;
        if self.numbers.len() < room {
            self.numbers.resize(room, 0);
            for candidates in &mut self.candidates {
                candidates.resize(room, 0.0);
            }
        }
    }

    /// Eight at a time; the last ones of no cell are overwritten.
    #[inline(always)]
    fn append(&mut self, first: usize, count: usize) {
        for begin in (0..count).step_by(LANES) {
            let (from, to) = (first + begin, self.count + begin);
            for (candidates, places) in self.candidates.iter_mut().zip(&self.places) {
                candidates[to..to + LANES].copy_from_slice(&places[from..from + LANES]);
            }
            for (lane, number) in self.numbers[to..to + LANES].iter_mut().enumerate() {
                *number = 2 * (from + lane) as u32;
            }
        }
        self.count += count;
    }

    /// Adds the places of those nearer than 1 to the next particle to a list, and leaves room of eight behind them.
    #[inline(always)]
    pub fn find<V: Lanes>(&mut self, near: &mut Near) {
        let [particle, own] = self.next;
        self.next = [particle + 1, own + 1];
        let at = [self.places[0][particle], self.places[1][particle], self.places[2][particle]];
        let at = [V::splat(at[0]), V::splat(at[1]), V::splat(at[2])];
        let groups = self.count.div_ceil(LANES);
        near.reserve(groups * LANES);
        let out = &mut near.places[near.end..];
        // Not itself.
        let (own_group, own_lane) = (own / LANES, own % LANES);
        let mut count = self.test(at, 0..own_group, 0, out);
        count += self.test(at, own_group..own_group + 1, 1 << own_lane, &mut out[count..]);
        count += self.test(at, own_group + 1..groups, 0, &mut out[count..]);
        near.end += count;
    }

    /// The same of some groups of candidates; `but` are those of each group that don't count. How many they are.
    #[inline(always)]
    fn test<V: Lanes>(&self, [x, y, z]: [V; 3], groups: Range<usize>, but: u32, out: &mut [u32]) -> usize {
        let [xs, ys, zs] = &self.candidates;
        let candidates = xs.as_chunks::<LANES>().0[groups.clone()].iter();
        let candidates = candidates.zip(&ys.as_chunks::<LANES>().0[groups.clone()]);
        let candidates = candidates.zip(&zs.as_chunks::<LANES>().0[groups.clone()]);
        let (one, mut count) = (V::splat(1.0), 0);
        for (((xs, ys), zs), numbers) in candidates.zip(&self.numbers.as_chunks().0[groups]) {
            let (dx, dy, dz) = (V::load(xs) - x, V::load(ys) - y, V::load(zs) - z);
            let hits = ((dx * dx + dy * dy) + dz * dz).below(one) & !but;
            let Some(out) = out[count..].first_chunk_mut() else { break };
            *out = V::compress(numbers, hits);
            count += hits.count_ones() as usize;
        }
        count
    }
}

/// Places of neighbours, list after list.
#[derive(Default)]
pub(super) struct Near {
    pub places: Vec<u32>,
    pub end: usize,
}

impl Near {
    #[inline(always)]
    fn reserve(&mut self, count: usize) {
        let room = self.end + count + LANES;
        if self.places.len() < room {
            self.places.resize(room, 0);
        }
    }
}
