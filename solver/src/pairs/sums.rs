//! The sums over the neighbours of a block's particles. Each takes a [`Table`] of what is summed, and writes a quad for each
//! particle, of which three numbers count; `out` has one more.

use super::lanes::{Lanes, Quad, Work, dispatch};
use super::table::Table;
use super::{Row, SLICE, Symmetric};
use crate::neighbours::Lists;

/// The sum of q V grad W_ij, number by number, for the quads q of the table; in numbers of pairs, see
/// [`Lists::unit`].
pub fn gradients(lists: &Lists, table: &Table, out: &mut [Quad]) {
    dispatch(Gradients { lists, table, out });
}

/// The sum of h (h . (u_j - u_i)), for the vectors u of the table and the bends h; in numbers of bends, see
/// [`Lists::unit_of_bends`].
pub fn bends(lists: &Lists, bends: &[Row], table: &Table, out: &mut [Quad]) {
    dispatch(OfBends::<false> { lists, bends, table, out: [out, &mut []] });
}

/// The same, and the sum of W (u_j - u_i), see [`Lists::unit_of_means`].
pub fn bends_and_means(lists: &Lists, bends: &[Row], table: &Table, out: [&mut [Quad]; 2]) {
    dispatch(OfBends::<true> { lists, bends, table, out });
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

pub(super) struct Gradients<'a> {
    pub lists: &'a Lists,
    pub table: &'a Table,
    pub out: &'a mut [Quad],
}

impl Work for Gradients<'_> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        for (particles, rows) in self.lists.slices() {
            let sums = V::sum_of_rows(&self.lists.rows()[rows], self.table);
            for (&particle, sum) in particles.iter().zip(sums) {
                self.out[usize::from(particle)] = sum;
            }
        }
    }
}

pub(super) struct OfBends<'a, const MEAN: bool> {
    pub lists: &'a Lists,
    pub bends: &'a [Row],
    pub table: &'a Table,
    pub out: [&'a mut [Quad]; 2],
}

impl<const MEAN: bool> Work for OfBends<'_, MEAN> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        let [out, means] = self.out;
        for (particles, rows) in self.lists.slices() {
            let own = particles.map(|particle| self.table.quads()[usize::from(particle)]);
            let (pairs, bends) = (&self.lists.rows()[rows.clone()], &self.bends[rows]);
            let [sums, of_values] = V::sum_of_bends::<MEAN>(pairs, bends, self.table, own);
            for (lane, &particle) in particles.iter().enumerate() {
                out[usize::from(particle)] = sums[lane];
                if MEAN {
                    means[usize::from(particle)] = of_values[lane];
                }
            }
        }
    }
}
