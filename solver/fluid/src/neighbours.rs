//! Which particles are nearer than the support radius, and what they are to each other: the [pairs](crate::pairs) of
//! all blocks, made once a step.
//!
//! A block's search finds who is near whom; its rows are written from that, and with them the sums that go by
//! the places alone: density and factor.

mod rows;
mod search;

use crate::blocks::{self, CellBlock, TooDense};
use crate::cells::Cells;
use crate::discretization::Discretization;
use crate::pairs::kernels::KernelLanes;
use crate::pairs::lanes::Lanes;
use crate::pairs::lists::Lists;
pub use crate::pairs::lists::Neighbour;
use crate::pairs::table::Quads;
use crate::pairs::{Density, Quad, Units, WithKernel, WorkOfKernel, dispatch, workspace};
use rayon::prelude::*;
use rows::Writer;
use search::Search;
use std::cell::RefCell;

/// The neighbours of all particles, block by block.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    lists: Vec<Lists>,
}

/// Particles of a block without neighbours.
const ALONE: usize = 256;

/// What a thread searches with.
#[derive(Default)]
struct Room {
    search: Search,
    writer: Writer,
}

thread_local! {
    static ROOM: RefCell<Room> = RefCell::default();
}

/// What is looked for: with which kernel, and whether bends are needed.
#[derive(Clone, Copy, Debug)]
pub struct Sought {
    /// Kernel, support radius and volume.
    pub with: Discretization,
    /// Whether [`Lists::bends()`] are needed.
    pub bends: bool,
}

impl Neighbours {
    /// Finds all neighbours of particles that are sorted by `cells`; `places` are theirs in support radii. What the
    /// neighbours amount to comes into `densities`.
    ///
    /// # Errors
    /// [`TooDense`]
    pub fn find(
        &mut self,
        cells: &Cells,
        places: &[Quad],
        sought: Sought,
        densities: &mut Vec<Density>,
    ) -> Result<(), TooDense> {
        let blocks = blocks::divide(cells, places.len())?;
        self.lists.resize_with(blocks.len(), Lists::default);
        densities.resize(places.len(), Density::default());
        let counts = blocks.iter().map(|block| block.particles.len());
        let out = blocks::split(counts, densities);
        let all = self.lists.par_iter_mut().zip(&blocks).zip(out);
        all.for_each(|((lists, block), out)| {
            ROOM.with_borrow_mut(|room| {
                workspace::with(|workspace| {
                    let table = &mut workspace.vectors;
                    let work = Build { cells, block, places, sought, room, table, lists, out };
                    dispatch(WithKernel { kernel: sought.with.kernel, work });
                });
            });
        });
        Ok(())
    }

    /// Particles that aren't anyone's neighbours, in blocks: for what goes by them alone. There are no sums of them.
    pub(crate) fn none(count: usize) -> Neighbours {
        let block = |first: usize| Lists { first, count: ALONE.min(count - first), ..Lists::default() };
        Neighbours { lists: (0..count).step_by(ALONE).map(block).collect() }
    }

    /// The lists of every block, in order.
    pub fn lists(&self) -> &[Lists] {
        &self.lists
    }

    /// The values of each block's particles.
    pub fn split<'a, T>(&self, values: &'a mut [T]) -> Vec<&'a mut [T]> {
        blocks::split(self.lists.iter().map(Lists::len), values)
    }

    /// Every block, for work on the values of its particles.
    pub fn with<'a, T: Send>(
        &'a self,
        values: &'a mut [T],
    ) -> impl IndexedParallelIterator<Item = (&'a Lists, &'a mut [T])> {
        self.lists.par_iter().zip(self.split(values))
    }

    /// Shows every particle with its neighbours and its value to `f`, on all threads: for forces of a program's own.
    /// The solver's own sums are faster, as they read values from tables.
    pub fn each<T: Send>(&self, values: &mut [T], f: impl Fn(usize, &[Neighbour], &mut T) + Sync) {
        self.with(values).for_each_init(Default::default, |(numbers, near), (lists, values)| {
            lists.each(numbers, near, |within, near| f(lists.first + within, near, &mut values[within]));
        });
    }

    /// Pairs, each counted from both sides.
    pub fn entries(&self) -> usize {
        self.lists.iter().map(|lists| lists.pairs).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.lists.iter().map(Lists::memory_bytes).sum()
    }
}

/// The search and the rows of one block.
struct Build<'a> {
    cells: &'a Cells,
    block: &'a CellBlock,
    places: &'a [Quad],
    sought: Sought,
    room: &'a mut Room,
    table: &'a mut Quads,
    lists: &'a mut Lists,
    out: &'a mut [Density],
}

impl WorkOfKernel for Build<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let Build { cells, block, places, sought, room, table, lists, out } = self;
        let Room { search, writer } = room;
        lists.begin(block.particles.clone(), Units::new::<K>(sought.with), sought.bends);
        let far = search.begin(cells, block, places, lists, table);
        writer.begin();
        for number in block.cells.clone() {
            let particles = cells.particles_of(number..number + 1);
            if particles.is_empty() {
                continue;
            }
            search.enter(cells.cell_of(number));
            for _ in particles {
                search.find::<V>(writer.next_list());
                if writer.is_full() {
                    writer.write::<V, K>(table, far, lists, out);
                }
            }
        }
        writer.write::<V, K>(table, far, lists, out);
    }
}

#[cfg(test)]
pub(crate) mod tests;
