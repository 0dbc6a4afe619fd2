//! From lists of neighbours to rows of pairs, and the sums that go by the places alone: Eq. 6 of Bender et al. 2020
//! and alpha of Band et al. 2018, Algorithm 1.

use super::search::Near;
use crate::pairs::kernels::{KernelLanes, SMALL};
use crate::pairs::lanes::{Group, LANES, Lanes, places_of};
use crate::pairs::lists::Lists;
use crate::pairs::table::Quads;
use crate::pairs::{Density, Row, SLICE, Units};

/// Particles among which those of a slice are chosen: some that have as many neighbours.
const WINDOW: usize = 64;
/// Neighbours that are more than a fluid has.
const MANY: usize = 63;

/// The lists of some particles that follow each other in the block.
#[derive(Default)]
pub(super) struct Writer {
    near: Near,
    /// Where each list begins, and the last one ends; behind it may be written.
    starts: Vec<usize>,
    /// First particle of the window.
    first: usize,
    /// The lists of a slice.
    turned: Vec<Group>,
}

/// The particles of a slice, and what their neighbours amount to.
struct Slice<V> {
    at: [V; 3],
    value: V,
    gradient: [V; 3],
    squares: V,
}

impl Writer {
    /// A block begins.
    pub fn begin(&mut self) {
        self.first = 0;
        self.near.end = 0;
        self.starts.clear();
    }

    /// For the next particle's neighbours.
    #[inline(always)]
    pub fn next_list(&mut self) -> &mut Near {
        self.starts.push(self.near.end);
        &mut self.near
    }

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.starts.len() == WINDOW
    }

    /// Writes all lists and begins anew. `far` is the number in the table of a particle that is far from all.
    #[inline(always)]
    pub fn write<V: Lanes, K: KernelLanes>(
        &mut self,
        table: &Quads,
        far: usize,
        lists: &mut Lists,
        out: &mut [Density],
    ) {
        self.starts.push(self.near.end);
        let mut order = [0; WINDOW];
        for slice in self.order(&mut order).chunks(SLICE) {
            self.turn(slice, 2 * far as u32);
            let mut particles = [lists.count as u16; SLICE];
            for (particle, number) in particles.iter_mut().zip(slice) {
                *particle = (self.first + number) as u16;
            }
            let mut sums = Slice::<V>::new(table, &particles);
            for places in &self.turned {
                sums.add::<K>(table, places, lists);
            }
            sums.end::<K>(&particles[..slice.len()], lists.units, out);
            lists.slices.push((particles, lists.rows.len() as u32));
        }
        lists.pairs += self.near.end;
        self.first += self.starts.len() - 1;
        self.starts.clear();
        self.near.end = 0;
    }

    /// Lays the lists of a slice side by side: a row has one neighbour of each particle, `far` where there is none.
    #[inline(always)]
    fn turn(&mut self, slice: &[usize], far: u32) {
        let Writer { near, starts, turned, .. } = self;
        turned.clear();
        let most = slice.iter().map(|&number| starts[number + 1] - starts[number]).max();
        turned.resize(most.unwrap_or(0), [far; SLICE]);
        for (lane, &number) in slice.iter().enumerate() {
            let list = &near.places[starts[number]..starts[number + 1]];
            for (row, place) in turned.iter_mut().zip(list) {
                row[lane & (SLICE - 1)] = *place;
            }
        }
    }

    #[inline(always)]
    fn list(&self, number: usize) -> &[u32] {
        &self.near.places[self.starts[number]..self.starts[number + 1]]
    }

    /// The numbers of the window's particles: those with the most neighbours first, then as they come; those of
    /// [`MANY`] and more are alike.
    #[inline(always)]
    fn order<'a>(&self, order: &'a mut [usize; WINDOW]) -> &'a [usize] {
        let count = self.starts.len() - 1;
        let fewness = |number: usize| MANY - self.list(number).len().min(MANY);
        let mut begins = [0; MANY + 2];
        for number in 0..count {
            begins[fewness(number) + 1] += 1;
        }
        for n in 1..begins.len() {
            begins[n] += begins[n - 1];
        }
        for number in 0..count {
            let begin = &mut begins[fewness(number)];
            order[*begin] = number;
            *begin += 1;
        }
        &order[..count]
    }
}

impl<V: Lanes> Slice<V> {
    #[inline(always)]
    fn new(table: &Quads, particles: &[u16; SLICE]) -> Slice<V> {
        let zero = V::splat(0.0);
        let at = V::gather(table, &places_of(particles));
        Slice { at, value: zero, gradient: [zero; 3], squares: zero }
    }

    /// Adds a neighbour of each particle.
    #[inline(always)]
    fn add<K: KernelLanes>(&mut self, table: &Quads, places: &Group, lists: &mut Lists) {
        let [x, y, z] = V::gather(table, places);
        let (x, y, z) = (self.at[0] - x, self.at[1] - y, self.at[2] - z);
        let square = (x * x + y * y) + z * z;
        let (value, slope) = K::both(square);
        let scaled = slope * V::splat(lists.units.pair);
        let pair = [(scaled * x).round(), (scaled * y).round(), (scaled * z).round()];
        self.value = self.value + value;
        for (sum, number) in self.gradient.iter_mut().zip(pair) {
            *sum = *sum + number;
        }
        self.squares = self.squares + slope * slope * square;
        lists.rows.push(Row(V::pack(pair, places)));
        if let Some(bends) = &mut lists.bends {
            bends.push(bend(lists.units, [x, y, z], square, slope));
        }
    }

    /// Density, gradient and squares of each particle.
    #[inline(always)]
    fn end<K: KernelLanes>(&self, particles: &[u16], units: Units, out: &mut [Density]) {
        let own = K::value(V::splat(0.0));
        let density = (V::splat(units.density) * (own + self.value)).array();
        let squares = (V::splat(units.gradient) * V::splat(units.gradient) * self.squares).array();
        let unit = V::splat(units.of_pair);
        let [x, y, z] = self.gradient;
        let (x, y, z) = ((unit * x).array(), (unit * y).array(), (unit * z).array());
        for (n, &particle) in particles.iter().enumerate() {
            out[usize::from(particle)] =
                Density { density: density[n], gradient: [x[n], y[n], z[n]], squares: squares[n] };
        }
    }
}

/// What implicit viscosity asks of a row of pairs.
#[inline(always)]
fn bend<V: Lanes>(units: Units, [x, y, z]: [V; 3], square: V, slope: V) -> Row {
    let size = slope.max(V::splat(0.0) - slope);
    let scale = V::splat(units.bend) * (size / (square + V::splat(SMALL))).sqrt();
    Row(V::pack([(scale * x).round(), (scale * y).round(), (scale * z).round()], &[0; LANES]))
}
