//! The pairs of the particles of a block.

use super::{Row, SLICE, Units};
use std::ops::Range;

/// What one particle is to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// The other one.
    pub particle: usize,
    /// V grad W_ij, 1/m, i the particle whose neighbour it is; to 2e-5 of the largest one.
    pub gradient: [f32; 3],
}

/// The pairs of the particles of a block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lists {
    /// First particle of the block.
    pub first: usize,
    pub(crate) count: usize,
    /// The particles that a table has: those of the block, then those around it.
    pub(crate) table: Vec<Range<u32>>,
    /// The particles of each slice by their numbers in the block, which are as many as it has particles where there
    /// is none, and where its rows end.
    pub(crate) slices: Vec<([u16; SLICE], u32)>,
    pub(crate) rows: Vec<Row>,
    pub(crate) units: Units,
    pub(crate) pairs: usize,
    /// As the rows, bends; none where there is no implicit viscosity.
    pub(crate) bends: Option<Vec<Row>>,
}

impl Lists {
    /// Lists of these particles, still without pairs.
    pub(crate) fn begin(&mut self, particles: Range<usize>, units: Units, bends: bool) {
        self.first = particles.start;
        self.count = particles.len();
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

    /// What each particle of the block has as neighbours, in no particular order; `numbers` and `near` are room.
    pub(crate) fn each(
        &self,
        numbers: &mut Vec<u32>,
        near: &mut Vec<Neighbour>,
        mut f: impl FnMut(usize, &[Neighbour]),
    ) {
        numbers.clear();
        numbers.extend(self.table.iter().cloned().flatten());
        let unit = self.unit();
        for (particles, rows) in self.slices() {
            for (lane, &particle) in particles.iter().enumerate() {
                let within = usize::from(particle);
                if within >= self.count {
                    continue;
                }
                let pairs = self.rows[rows.clone()].iter().map(|row| row.0[lane]);
                near.clear();
                near.extend(pairs.filter_map(|[x, y, z, place]| {
                    // Pairs of nobody have a place behind the last one.
                    let particle = *numbers.get(usize::from(place as u16) / 2)? as usize;
                    Some(Neighbour { particle, gradient: [x, y, z].map(|number| unit * f32::from(number)) })
                }));
                f(within, near);
            }
        }
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
    /// h = x_ij (k |W'| / |x| / (x^2 + 0.01 r^2))^1/2 the Laplacian by Eq. 16 of Bender et al. 2020 (Monaghan 2005)
    /// of a field u is the sum of h (h . (u_j - u_i)).
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

    pub(crate) fn memory_bytes(&self) -> usize {
        let bends = self.bends.as_ref().map_or(0, Vec::capacity);
        size_of::<Row>() * (self.rows.capacity() + bends)
            + size_of::<([u16; SLICE], u32)>() * self.slices.capacity()
            + size_of::<Range<u32>>() * self.table.capacity()
    }
}
