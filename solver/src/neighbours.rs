//! Which particles are nearer than the support radius: lists in groups of eight, made once a step.
//!
//! A cell's particles share the candidates of its 27 cells, which are laid side by side first.

use crate::cells::Cells;
use crate::pairs::lanes::{Group, LANES, Lanes, Quad, Work, dispatch};
use glam::IVec3;
use rayon::prelude::*;
use std::ops::Range;
use volmap_runtime::DVec3;

/// Particles that are worked on together; the unit of parallel work.
pub const CHUNK: usize = 256;

/// The neighbours of all particles, chunk by chunk.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    chunks: Vec<Lists>,
}

/// The neighbours of the particles of a chunk.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    /// First particle of the chunk.
    pub first: usize,
    /// First group of each particle, and the number of groups.
    starts: Vec<u32>,
    /// Neighbours, the particle itself among them, which adds to densities only; the last group is filled up with the one behind the last particle,
    /// which in all tables is far from all.
    groups: Vec<Group>,
    /// The slope of the kernel at each of them: written with the density, read by all other sums.
    slopes: Vec<[f32; LANES]>,
    candidates: Candidates,
}

/// The particles of 27 cells: places in support radii, and four times their indices, as in a [`Group`].
#[derive(Clone, Debug, Default)]
struct Candidates {
    places: Vec<[[f32; LANES]; 3]>,
    indices: Vec<u32>,
    /// Those that are near one particle, and room for the last eight.
    near: Vec<u32>,
}

impl Neighbours {
    /// Finds all neighbours. `positions` are sorted by `cells`; `places` are the same in support radii from some
    /// origin, with one more, far away from all, at the end.
    pub fn find(&mut self, cells: &Cells, positions: &[DVec3], places: &[Quad]) {
        self.chunks.resize_with(positions.len().div_ceil(CHUNK), Lists::default);
        self.chunks.par_iter_mut().enumerate().for_each(|(chunk, lists)| {
            let first = chunk * CHUNK;
            let particles = first..positions.len().min(first + CHUNK);
            dispatch(Search { cells, positions, places, particles, lists });
        });
    }

    /// The lists of every chunk, to write slopes into.
    pub(crate) fn chunks_mut(&mut self) -> &mut [Lists] {
        &mut self.chunks
    }

    /// The lists of every chunk, in order.
    pub fn chunks(&self) -> &[Lists] {
        &self.chunks
    }

    /// Pairs, each counted from both sides; the particles themselves and the filling are counted, too.
    pub fn entries(&self) -> usize {
        self.chunks.iter().map(|lists| lists.groups.len() * LANES).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let of = |lists: &Lists| {
            4 * lists.starts.capacity()
                + 4 * LANES * (lists.groups.capacity() + lists.slopes.capacity())
                + lists.candidates.memory_bytes()
        };
        self.chunks.iter().map(of).sum()
    }
}

impl Lists {
    /// Particles of the chunk.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether the chunk has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The groups of neighbours of the chunk's particle number `within`, and the kernel's slopes there.
    #[inline(always)]
    pub(crate) fn pairs(&self, within: usize) -> impl Iterator<Item = (&Group, &[f32; LANES])> {
        let groups = self.starts[within] as usize..self.starts[within + 1] as usize;
        self.groups[groups.clone()].iter().zip(&self.slopes[groups])
    }

    /// The same, to write the slopes.
    #[inline(always)]
    pub(crate) fn pairs_mut(&mut self, within: usize) -> impl Iterator<Item = (&Group, &mut [f32; LANES])> {
        let groups = self.starts[within] as usize..self.starts[within + 1] as usize;
        self.groups[groups.clone()].iter().zip(&mut self.slopes[groups])
    }
}

impl Candidates {
    /// Gathers the particles of the cells around one.
    #[inline(always)]
    fn gather<V: Lanes>(&mut self, cells: &Cells, cell: IVec3, places: &[Quad]) {
        self.indices.clear();
        for z in -1..=1 {
            for y in -1..=1 {
                for x in -1..=1 {
                    self.indices
                        .extend(cells.particles(cell + IVec3::new(x, y, z)).map(|index| 4 * index as u32));
                }
            }
        }
        let filling = 4 * (places.len() as u32 - 1);
        self.indices.resize(self.indices.len().next_multiple_of(LANES), filling);
        self.places.clear();
        for group in self.indices.as_chunks().0 {
            let [[x, y, z, _]] = V::gather([places], group);
            self.places.push([x.array(), y.array(), z.array()]);
        }
        self.near.resize(self.indices.len() + LANES, 0);
    }

    /// Puts those nearer than 1 first into `near`; how many they are.
    #[inline(always)]
    fn find<V: Lanes>(&mut self, at: Quad) -> usize {
        let Candidates { places, indices, near } = self;
        let (x, y, z, one) = (V::splat(at[0]), V::splat(at[1]), V::splat(at[2]), V::splat(1.0));
        let mut count = 0;
        for ([xs, ys, zs], indices) in places.iter().zip(indices.as_chunks::<LANES>().0) {
            let (dx, dy, dz) = (V::load(xs) - x, V::load(ys) - y, V::load(zs) - z);
            let hits = ((dx * dx + dy * dy) + dz * dz).below(one);
            if let Some(out) = near[count..].first_chunk_mut() {
                *out = V::compress(indices, hits);
            }
            count += hits.count_ones() as usize;
        }
        count
    }

    fn memory_bytes(&self) -> usize {
        4 * (self.indices.capacity() + self.near.capacity() + 3 * LANES * self.places.capacity())
    }
}

/// The search of one chunk.
struct Search<'a> {
    cells: &'a Cells,
    positions: &'a [DVec3],
    places: &'a [Quad],
    particles: Range<usize>,
    lists: &'a mut Lists,
}

impl Work for Search<'_> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        let Lists { first, starts, groups, slopes, candidates } = self.lists;
        *first = self.particles.start;
        starts.clear();
        groups.clear();
        let filling = 4 * (self.places.len() as u32 - 1);
        let mut cell = IVec3::MIN;
        for particle in self.particles {
            let here = self.cells.cell(self.positions[particle]);
            if here != cell {
                cell = here;
                candidates.gather::<V>(self.cells, cell, self.places);
            }
            starts.push(groups.len() as u32);
            let count = candidates.find::<V>(self.places[particle]);
            let near = &mut candidates.near[..count.next_multiple_of(LANES)];
            near[count..].fill(filling);
            groups.extend(near.as_chunks().0);
        }
        starts.push(groups.len() as u32);
        slopes.resize(groups.len(), [0.0; LANES]);
    }
}

#[cfg(test)]
pub(crate) mod tests;
