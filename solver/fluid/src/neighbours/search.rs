//! The search for neighbours: the particles of a cell share the candidates of its 27 cells, which are laid side by
//! side, and each compares itself with all of them, eight at a time.

use crate::blocks::{CellBlock, surroundings};
use crate::cells::Cells;
use crate::pairs::Quad;
use crate::pairs::lanes::{LANES, Lanes};
use crate::pairs::lists::Lists;
use crate::pairs::table::{FAR, Quads};
use glam::IVec3;
use std::ops::Range;

/// Room for a block's search.
#[derive(Default)]
pub(super) struct Search {
    /// Lowest cell around the block, and how many there are along each axis.
    corner: IVec3,
    size: IVec3,
    /// Of cells outside the block: first particle, number of particles, cell.
    around: Vec<[u32; 3]>,
    /// Of each cell the number in the table of its first particle, and how many it has.
    cells: Vec<[u32; 2]>,
    /// Where each cell begins among the places, and their number.
    starts: Vec<usize>,
    /// Places row by row of cells, along x, coordinate by coordinate; room for eight more.
    places: [Vec<f32>; 3],
    /// What they have in the table: twice their numbers.
    numbers: Vec<u32>,
    /// The same of the candidates of a cell.
    candidates: [Vec<f32>; 3],
    candidate_numbers: Vec<u32>,
    count: usize,
    /// The particle that comes next, among the places and among the candidates.
    next: [usize; 2],
}

impl Search {
    /// Takes what is in a block and around it: into `lists`, which particles a table has, and into `table`, their
    /// places, and one behind them that is far from all, whose number comes back.
    #[inline(always)]
    pub fn begin(
        &mut self,
        cells: &Cells,
        block: &CellBlock,
        places: &[Quad],
        lists: &mut Lists,
        table: &mut Quads,
    ) -> usize {
        self.find_cells(cells, block);
        lists.table.push(block.particles.start as u32..block.particles.end as u32);
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
        self.lay(&table.values()[..count]);
        count
    }

    #[inline(always)]
    fn find_cells(&mut self, cells: &Cells, block: &CellBlock) {
        let [min, max] = block.occupied;
        (self.corner, self.size) = (min - 1, max - min + 3);
        self.cells.clear();
        self.around.clear();
        for (number, cell) in surroundings(block.occupied).enumerate() {
            let particles = cells.particles(cell);
            let [first, count] = [particles.start as u32, particles.len() as u32];
            let is_own = block.particles.contains(&particles.start) && count > 0;
            self.cells.push([if is_own { first - block.particles.start as u32 } else { 0 }, count]);
            if count > 0 && !is_own {
                self.around.push([first, count, number as u32]);
            }
        }
    }

    /// Lays all places row by row.
    #[inline(always)]
    fn lay(&mut self, table: &[Quad]) {
        let Search { cells, starts, places: [xs, ys, zs], numbers, .. } = self;
        let room = table.len() + LANES;
        for all in [&mut *xs, &mut *ys, &mut *zs] {
            all.resize(room.max(all.len()), 0.0);
        }
        numbers.resize(xs.len(), 0);
        starts.clear();
        let mut end = 0;
        for &[first, count] in &*cells {
            starts.push(end);
            let (first, count) = (first as usize, count as usize);
            let (of, to) = (&table[first..first + count], end..end + count);
            let out = xs[to.clone()].iter_mut().zip(&mut ys[to.clone()]);
            let out = out.zip(&mut zs[to.clone()]).zip(&mut numbers[to]);
            for ((((x, y), z), number), (n, quad)) in out.zip(of.iter().enumerate()) {
                [*x, *y, *z] = [quad[0], quad[1], quad[2]];
                *number = 2 * (first + n) as u32;
            }
            end += count;
        }
        starts.push(end);
    }

    /// Lays the candidates of a cell side by side, row by row, its own row first.
    #[inline(always)]
    pub fn enter(&mut self, cell: IVec3) {
        let at = cell - self.corner;
        let own = (at.z * self.size.y + at.y) * self.size.x + at.x;
        let mut rows = [[0; 2]; 9];
        let mut all = 0;
        for (n, row) in rows.iter_mut().enumerate() {
            let [y, z] = [n % 3, n / 3].map(|n| n as i32 - 1);
            let middle = (own + (z * self.size.y + y) * self.size.x) as usize;
            *row = [self.starts[middle - 1], self.starts[middle + 2]];
            all += row[1] - row[0];
        }
        rows.swap(0, 4);
        self.reserve(all);
        self.count = 0;
        for [first, end] in rows {
            self.append(first, end - first);
        }
        for candidates in &mut self.candidates {
            candidates[self.count..self.count + LANES].fill(FAR);
        }
        let first = self.starts[own as usize];
        self.next = [first, first - rows[0][0]];
    }

    fn reserve(&mut self, count: usize) {
        let room = count + 2 * LANES;
        if self.candidate_numbers.len() < room {
            self.candidate_numbers.resize(room, 0);
            for candidates in &mut self.candidates {
                candidates.resize(room, 0.0);
            }
        }
    }

    /// Eight at a time; those behind the last ones are overwritten.
    #[inline(always)]
    fn append(&mut self, first: usize, count: usize) {
        for begin in (0..count).step_by(LANES) {
            let (from, to) = (first + begin, self.count + begin);
            for (candidates, places) in self.candidates.iter_mut().zip(&self.places) {
                candidates[to..to + LANES].copy_from_slice(&places[from..from + LANES]);
            }
            self.candidate_numbers[to..to + LANES].copy_from_slice(&self.numbers[from..from + LANES]);
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
        for (((xs, ys), zs), numbers) in candidates.zip(&self.candidate_numbers.as_chunks().0[groups]) {
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
