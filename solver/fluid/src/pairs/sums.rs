//! The sums over the neighbours of a block's particles. Each takes a [table](super::table) of what is summed.

use super::lanes::{Lanes, Vectorized};
use super::lists::Lists;
use super::table::{Numbers, Quads};
use super::{Quad, Row, SLICE, Symmetric, dispatch};

/// -(P_i grad D_i + the sum of P_j V grad W_ij), for the pressures P of the table, those of the block's particles and
/// their gradients of the density.
pub fn accelerations(
    lists: &Lists,
    table: &Numbers,
    pressures: &[f32],
    gradients: &[Quad],
    work: Room<Quad>,
) {
    dispatch(Accelerations { lists, table, pressures, gradients, work });
}

/// u_i . grad D_i - the sum of u_j . V grad W_ij, for the vectors u of the table, those of the block's particles and
/// their gradients of the density.
pub fn fluxes(lists: &Lists, table: &Quads, own: &[Quad], gradients: &[Quad], work: Room<f32>) {
    dispatch(Fluxes { lists, table, own, gradients, work });
}

/// Where sums go: room for one more than particles are, in which they come slice by slice, and the results.
pub struct Room<'a, T> {
    pub sums: &'a mut [T],
    pub out: &'a mut [T],
}

/// The sum of h (h . (u_j - u_i)), for the vectors u of the table and the bends h; in numbers of bends, see
/// [`Lists::unit_of_bends`]. `out` has one more than particles are.
pub fn bends(lists: &Lists, bends: &[Row], table: &Quads, out: &mut [Quad]) {
    dispatch(OfBends { lists, bends, table, out });
}

/// Of each particle the sum of h h^T; in numbers of bends.
pub fn squares_of_bends(lists: &Lists, bends: &[Row], out: &mut [Symmetric]) {
    for (particles, rows) in lists.slices() {
        let mut sums = [[0.0; SLICE]; 6];
        for row in &bends[rows] {
            for (lane, pair) in row.0.iter().enumerate() {
                let [x, y, z, _] = pair.map(f32::from);
                for (sum, product) in sums.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                    sum[lane] += product;
                }
            }
        }
        for (lane, &particle) in particles.iter().enumerate() {
            if let Some(out) = out.get_mut(usize::from(particle)) {
                *out = sums.map(|sum| sum[lane]);
            }
        }
    }
}

/// What comes of a slice, to its particles.
#[inline(always)]
fn put<T>(particles: &[u16; SLICE], sums: [T; SLICE], out: &mut [T]) {
    for (&particle, sum) in particles.iter().zip(sums) {
        out[usize::from(particle)] = sum;
    }
}

pub(super) struct Accelerations<'a> {
    pub lists: &'a Lists,
    pub table: &'a Numbers,
    pub pressures: &'a [f32],
    pub gradients: &'a [Quad],
    pub work: Room<'a, Quad>,
}

impl Vectorized for Accelerations<'_> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        let Room { sums, out } = self.work;
        for (particles, rows) in self.lists.slices() {
            let of_slice = V::sum_of_scaled_rows(&self.lists.rows()[rows], self.table);
            put(particles, of_slice, sums);
        }
        let unit = self.lists.unit();
        let own = self.pressures.iter().zip(self.gradients);
        for ((out, sum), (pressure, gradient)) in out.iter_mut().zip(sums).zip(own) {
            // All four at once; the last is none.
            let all: Quad = std::array::from_fn(|n| -(pressure * gradient[n] + unit * sum[n]));
            *out = [all[0], all[1], all[2], 0.0];
        }
    }
}

pub(super) struct Fluxes<'a> {
    pub lists: &'a Lists,
    pub table: &'a Quads,
    pub own: &'a [Quad],
    pub gradients: &'a [Quad],
    pub work: Room<'a, f32>,
}

impl Vectorized for Fluxes<'_> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        let Room { sums, out } = self.work;
        for (particles, rows) in self.lists.slices() {
            let of_slice = V::across(V::sum_of_rows(&self.lists.rows()[rows], self.table));
            put(particles, of_slice, sums);
        }
        let unit = self.lists.unit();
        let own = self.own.chunks(SLICE).zip(self.gradients.chunks(SLICE));
        for ((out, sums), (own, gradients)) in out.chunks_mut(SLICE).zip(sums.chunks(SLICE)).zip(own) {
            let mut products = [[0.0; 4]; SLICE];
            for (product, (own, gradient)) in products.iter_mut().zip(own.iter().zip(gradients)) {
                *product = std::array::from_fn(|n| own[n] * gradient[n]);
            }
            for (out, (own, sum)) in out.iter_mut().zip(V::across(products).iter().zip(sums)) {
                *out = own - unit * sum;
            }
        }
    }
}

pub(super) struct OfBends<'a> {
    pub lists: &'a Lists,
    pub bends: &'a [Row],
    pub table: &'a Quads,
    pub out: &'a mut [Quad],
}

impl Vectorized for OfBends<'_> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        for (particles, rows) in self.lists.slices() {
            let own = particles.map(|particle| self.table.values()[usize::from(particle)]);
            let (pairs, bends) = (&self.lists.rows()[rows.clone()], &self.bends[rows]);
            let sums = V::sum_of_bends(pairs, bends, self.table, own);
            put(particles, sums, self.out);
        }
    }
}
