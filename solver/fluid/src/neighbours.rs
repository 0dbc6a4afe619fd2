//! Which particles are nearer than the support radius, and what they are to each other: the [pairs](crate::pairs) of all
//! blocks, made once a step.
//!
//! A block's search finds who is near whom; its rows are written from that, and with them the sums that go by
//! the places alone: density and factor.

mod rows;
mod search;

use crate::blocks::{self, Block, TooDense};
use crate::cells::Cells;
use crate::fields::Discretization;
use crate::pairs::kernels::KernelLanes;
use crate::pairs::lanes::{Lanes, Quad, dispatch};
use crate::pairs::table::{Numbers, Quads};
use crate::pairs::{Density, Row, SLICE, Units, WithKernel, WorkOfKernel};
use rayon::prelude::*;
use rows::Writer;
use search::Search;
use std::cell::RefCell;
use std::ops::Range;

/// The neighbours of all particles, block by block.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    lists: Vec<Lists>,
}

/// The pairs of the particles of a block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lists {
    /// First particle of the block.
    pub first: usize,
    count: usize,
    /// The particles that a table has: those of the block, then those around it.
    table: Vec<Range<u32>>,
    /// The particles of each slice by their numbers in the block, which are as many as it has particles where there is none,
    /// and where its rows end.
    slices: Vec<([u16; SLICE], u32)>,
    rows: Vec<Row>,
    units: Units,
    pairs: usize,
    /// As the rows, bends; none where there is no implicit viscosity.
    bends: Option<Vec<Row>>,
}

/// Particles of a block without neighbours.
const ALONE: usize = 256;

/// What a thread works with.
#[derive(Default)]
pub struct Workspace {
    /// What is summed, if it is vectors.
    pub vectors: Quads,
    /// Where it is, if that is asked for.
    pub places: Quads,
    /// What is summed, if it is numbers.
    pub numbers: Numbers,
    /// Sums of a block, with room for one particle that isn't there.
    pub sums: Vec<Quad>,
    /// Sums that are numbers.
    pub fluxes: Vec<f32>,
    /// What explicit viscosity makes.
    pub viscous: Vec<[[f32; 3]; 2]>,
    search: Search,
    writer: Writer,
}

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::default();
}

/// Does what can be done with a block's pairs, in this thread's room.
#[inline]
pub fn work<T>(lists: &Lists, f: impl FnOnce(&mut Workspace) -> T) -> T {
    WORKSPACE.with_borrow_mut(|workspace| {
        workspace.sums.resize(workspace.sums.len().max(lists.count + 1), [0.0; 4]);
        workspace.fluxes.resize(workspace.sums.len(), 0.0);
        workspace.viscous.resize(workspace.sums.len(), [[0.0; 3]; 2]);
        f(workspace)
    })
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
    /// Finds all neighbours of particles that are sorted by `cells`; `places` are theirs in support radii. What the neighbours
    /// amount to comes into `densities`.
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
            WORKSPACE.with_borrow_mut(|workspace| {
                let work = Build { cells, block, places, sought, workspace, lists, out };
                dispatch(WithKernel { kernel: sought.with.kernel, work });
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

    /// Pairs, each counted from both sides.
    pub fn entries(&self) -> usize {
        self.lists.iter().map(|lists| lists.pairs).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.lists.iter().map(Lists::memory_bytes).sum()
    }
}

impl Lists {
    /// Particles of the block.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether the block has none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The particles of the block.
    pub fn particles(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// What a table has: ranges of particles.
    pub fn table(&self) -> &[Range<u32>] {
        &self.table
    }

    /// What the numbers of a pair become V grad W by, 1/m.
    pub fn unit(&self) -> f32 {
        self.units.of_pair
    }

    /// What implicit viscosity asks of pairs, if it was asked for: rows of bends instead of gradients. With the bend
    /// h = x_ij (k |W'| / |x| / (x^2 + 0.01 r^2))^1/2 the Laplacian by Eq. 16 of Bender et al. 2020 (Monaghan 2005) of a field u is
    /// the sum of h (h . (u_j - u_i)).
    pub fn bends(&self) -> Option<&[Row]> {
        self.bends.as_deref()
    }

    /// What products of two bends become a Laplacian by, 1/m^2.
    pub fn unit_of_bends(&self) -> f32 {
        self.units.of_bend
    }

    /// The particles of each slice by their numbers in the block, and its rows.
    #[inline(always)]
    pub(crate) fn slices(&self) -> impl Iterator<Item = (&[u16; SLICE], Range<usize>)> {
        let mut begin = 0;
        self.slices.iter().map(move |(particles, end)| {
            (particles, std::mem::replace(&mut begin, *end as usize)..*end as usize)
        })
    }

    #[inline(always)]
    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    fn memory_bytes(&self) -> usize {
        let bends = self.bends.as_ref().map_or(0, Vec::capacity);
        size_of::<Row>() * (self.rows.capacity() + bends)
            + size_of::<([u16; SLICE], u32)>() * self.slices.capacity()
            + size_of::<Range<u32>>() * self.table.capacity()
    }
}

/// The search and the rows of one block.
struct Build<'a> {
    cells: &'a Cells,
    block: &'a Block,
    places: &'a [Quad],
    sought: Sought,
    workspace: &'a mut Workspace,
    lists: &'a mut Lists,
    out: &'a mut [Density],
}

impl WorkOfKernel for Build<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let Build { cells, block, places, sought, workspace, lists, out } = self;
        let Workspace { vectors: table, search, writer, .. } = workspace;
        lists.begin(block, Units::new::<K>(sought.with), sought.bends);
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

impl Lists {
    fn begin(&mut self, block: &Block, units: Units, bends: bool) {
        self.first = block.particles.start;
        self.count = block.particles.len();
        self.units = units;
        self.pairs = 0;
        self.table.clear();
        self.slices.clear();
        self.rows.clear();
        match bends {
            true => self.bends.get_or_insert_default().clear(),
            false => self.bends = None,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
