//! The signed distance on a tree of cells, as fine as integrals over it need: Eq. 12 of Bender et al. 2020 asks for Phi
//! where 0 < Phi < r, and elsewhere only for the side.
//!
//! Each leaf has the cubic Serendipity polynomial through its own 32 samples. Leaves of different size needn't agree at
//! their faces: the error is bounded in each, and nothing but integrals looks at it.

use super::lattice::{FineLattice, Key, LevelCell, indices};
use super::probes;
use super::samples::Samples;
use crate::sdf::SignedDistance;
use crate::volume_map::kernel::Content;
use crate::volume_map::window::monomials_of_nodes;
use crate::watch::{Cancelled, Work};
use glam::UVec3;
use rayon::prelude::*;
use volmap_formats::asset::Exterior;
use volmap_runtime::layout::serendipity::NODES;

/// What the tree must be good for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeSettings {
    /// Support radius r, metres.
    pub radius: f64,
    /// Mean error of Phi at a leaf's probes, metres; more in leaves smaller than r.
    pub tolerance: f64,
    /// What lies beyond the grid.
    pub exterior: Exterior,
}

/// A tree of cells over a grid.
#[derive(Clone, Debug)]
pub struct DistanceTree {
    pub(super) lattice: FineLattice,
    pub(super) exterior: Exterior,
    /// One entry for each cell of the grid, x fastest.
    roots: Vec<Entry>,
    /// Entries of the children of split cells, x fastest.
    blocks: Vec<[Entry; 8]>,
    /// Polynomials of s = 1 - Phi / r.
    pub(super) polynomials: Vec<[f64; NODES]>,
}

/// What a cell is: two bits of kind, the others which one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry(u32);

/// What holds a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Leaf {
    pub level: u32,
    pub content: Content,
    /// In the polynomials, if the content is mixed.
    pub number: u32,
}

impl Entry {
    const ZERO: Entry = Entry(0);
    const ONE: Entry = Entry(1);

    fn mixed(number: usize) -> Entry {
        Entry((number as u32) << 2 | 2)
    }

    fn block(number: usize) -> Entry {
        Entry((number as u32) << 2 | 3)
    }
}

/// Where an entry stands.
#[derive(Clone, Copy)]
enum Slot {
    Root(usize),
    Child(usize, usize),
}

impl DistanceTree {
    /// Splits the cells of the lattice's grid until their polynomials are exact enough or they are of its finest level.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        lattice: FineLattice,
        settings: &TreeSettings,
        phi: &impl SignedDistance,
        samples: &mut Samples,
        work: &Work,
    ) -> Result<DistanceTree, Cancelled> {
        let n = lattice.grid().resolution;
        let mut tree = DistanceTree {
            lattice,
            exterior: settings.exterior,
            roots: vec![Entry::ZERO; n.element_product() as usize],
            blocks: Vec::new(),
            polynomials: Vec::new(),
        };
        let root = |(number, at)| (Slot::Root(number), LevelCell { level: 0, at });
        let mut cells: Vec<_> = indices(n).enumerate().map(root).collect();
        while !cells.is_empty() {
            cells = tree.level(&cells, settings, phi, samples, work)?;
        }
        Ok(tree)
    }

    /// Decides the cells of a level; returns the children of those that were split.
    fn level(
        &mut self,
        cells: &[(Slot, LevelCell)],
        settings: &TreeSettings,
        phi: &impl SignedDistance,
        samples: &mut Samples,
        work: &Work,
    ) -> Result<Vec<(Slot, LevelCell)>, Cancelled> {
        let lattice = self.lattice;
        let centers = cells.par_iter().map(|(_, cell)| lattice.center_key(*cell));
        samples.ask_distance(centers, &lattice, phi, work)?;
        let mut open = Vec::new();
        for &(slot, cell) in cells {
            let (phi, reach) = (samples.at(lattice.center_key(cell)), lattice.reach(cell.level));
            match phi {
                _ if phi - reach >= settings.radius => self.set(slot, Entry::ZERO),
                _ if phi + reach <= 0.0 => self.set(slot, Entry::ONE),
                _ => open.push((slot, cell)),
            }
        }
        let of_cell =
            |(_, cell): &(_, LevelCell)| lattice.nodes(*cell).into_iter().chain(judged_at(*cell, &lattice));
        samples.ask_distance(open.par_iter().flat_map_iter(of_cell), &lattice, phi, work)?;
        let polynomials: Vec<Option<[f64; NODES]>> =
            open.par_iter().map(|(_, cell)| polynomial(*cell, &lattice, settings, samples)).collect();
        let mut split = Vec::new();
        for ((slot, cell), polynomial) in open.into_iter().zip(polynomials) {
            match polynomial {
                Some(polynomial) => self.add_leaf(slot, polynomial),
                None => split.extend(self.split(slot).zip(cell.children())),
            }
        }
        Ok(split)
    }

    fn add_leaf(&mut self, slot: Slot, polynomial: [f64; NODES]) {
        self.set(slot, Entry::mixed(self.polynomials.len()));
        self.polynomials.push(polynomial);
    }

    /// Splits a cell; returns where the entries of its children stand.
    fn split(&mut self, slot: Slot) -> impl Iterator<Item = Slot> + use<> {
        let block = self.blocks.len();
        self.set(slot, Entry::block(block));
        self.blocks.push([Entry::ZERO; 8]);
        (0..8).map(move |n| Slot::Child(block, n))
    }

    fn set(&mut self, slot: Slot, entry: Entry) {
        match slot {
            Slot::Root(number) => self.roots[number] = entry,
            Slot::Child(block, number) => self.blocks[block][number] = entry,
        }
    }

    /// The leaf that holds one of the finest cells.
    #[inline(always)]
    pub(super) fn leaf(&self, at: UVec3) -> Leaf {
        let finest = self.lattice.finest();
        let (n, root) = (self.lattice.grid().resolution, at >> finest);
        let mut entry = self.roots[(root.x + n.x * (root.y + n.y * root.z)) as usize];
        let mut level = 0;
        while entry.0 & 3 == 3 {
            level += 1;
            let bits = (at >> (finest - level)) & 1;
            entry = self.blocks[(entry.0 >> 2) as usize][(bits.x + 2 * bits.y + 4 * bits.z) as usize];
        }
        let content = [Content::Zero, Content::One, Content::Mixed, Content::Mixed][(entry.0 & 3) as usize];
        Leaf { level, content, number: entry.0 >> 2 }
    }

    /// Cells of level 0.
    pub(super) fn resolution(&self) -> UVec3 {
        self.lattice.grid().resolution
    }
}

/// The polynomial of s = 1 - Phi / r through a cell's nodes, if it is exact enough or the cell of the finest level.
fn polynomial(
    cell: LevelCell,
    lattice: &FineLattice,
    settings: &TreeSettings,
    samples: &Samples,
) -> Option<[f64; NODES]> {
    let nodes = lattice.nodes(cell).map(|key| samples.at(key));
    let exact = judged_at(cell, lattice).map(|key| samples.at(key));
    let margin = 0.5 * lattice.cell_size(cell.level).max_element();
    let good = cell.level == lattice.finest() || is_good(&nodes, &exact, margin, settings);
    good.then(|| monomials_of_nodes(&nodes, 1.0 / settings.radius))
}

/// The midpoints of a cell and its children among its probes. The others would only be asked here if it isn't split.
const JUDGED_AT: std::ops::Range<usize> = 18..probes::COUNT;

fn judged_at(cell: LevelCell, lattice: &FineLattice) -> [Key; JUDGED_AT.end - JUDGED_AT.start] {
    let keys = lattice.probes(cell);
    std::array::from_fn(|n| keys[JUDGED_AT.start + n])
}

/// Whether the polynomial is exact enough at the probes at which the extension function asks for Phi, or half a cell
/// (`margin`, metres) beyond.
fn is_good(nodes: &[f64; NODES], exact: &[f64], margin: f64, settings: &TreeSettings) -> bool {
    let range = -margin..settings.radius + margin;
    let (mut sum, mut count) = (0.0, 0.0f64);
    for (found, exact) in
        probes::values(nodes)[JUDGED_AT].iter().zip(exact).filter(|(_, exact)| range.contains(exact))
    {
        sum += (found - exact).abs();
        count += 1.0;
    }
    // Of a small leaf at a kink only part of the ball is wrong by it.
    let part = (2.0 * margin / settings.radius).min(1.0);
    sum / count.max(1.0) * part * part.sqrt() <= settings.tolerance
}
