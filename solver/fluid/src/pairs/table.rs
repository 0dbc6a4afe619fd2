//! What a sum over neighbours reads of them, side by side: one quad or number for each particle of a block and around
//! it, and one that is zero for pairs of nobody.

use super::Quad;
use std::ops::Range;

/// As many as 16 bits can tell even numbers, and one more: a [`super::Pair`] has twice the number of a particle in
/// the table, so that whatever it says is in it.
pub(super) const ROOM: usize = (1 << 15) + 1;
/// Particles at most, one that isn't there besides.
pub const MOST: usize = ROOM - 2;

/// Values of a block's particles, then of those around it. Of its room little is touched.
#[derive(Clone, Debug)]
pub struct Table<T> {
    values: Box<[T; ROOM]>,
}

impl<T: Copy + Default + std::fmt::Debug> Default for Table<T> {
    fn default() -> Table<T> {
        let values = vec![T::default(); ROOM].into_boxed_slice();
        Table { values: values.try_into().expect("as many as that") }
    }
}

/// Values that are copied at once: of most ranges that is all, and what is too much the next range overwrites.
const AT_ONCE: usize = 8;

impl<T: Copy + Default> Table<T> {
    /// Takes the values of the particles in these ranges, which must not be more than [`MOST`]; how many they are.
    #[inline(always)]
    pub(crate) fn fill(&mut self, ranges: &[Range<u32>], values: &[T]) -> usize {
        let mut end = 0;
        for range in ranges {
            let (first, count) = (range.start as usize, range.len());
            for begin in (0..count).step_by(AT_ONCE) {
                let from = values[first + begin..].first_chunk::<AT_ONCE>();
                match (from, self.values[end + begin..].first_chunk_mut::<AT_ONCE>()) {
                    (Some(from), Some(to)) => *to = *from,
                    _ => {
                        let rest = begin..count.min(begin + AT_ONCE);
                        self.values[end + rest.start..end + rest.end]
                            .copy_from_slice(&values[first + rest.start..first + rest.end]);
                    }
                }
            }
            end += count;
        }
        self.values[end] = T::default();
        end
    }

    /// The values, of which the first are filled.
    #[inline(always)]
    pub(crate) fn values(&self) -> &[T; ROOM] {
        &self.values
    }
}

/// Farther than any particle, in support radii; its square is still a number.
pub(crate) const FAR: f32 = 1e15;

impl Quads {
    /// As [`Table::fill`], of places in support radii: the one that isn't there is far from all.
    #[inline(always)]
    pub(crate) fn fill_places(&mut self, ranges: &[Range<u32>], places: &[Quad]) -> usize {
        let count = self.fill(ranges, places);
        self.values[count] = [FAR, FAR, FAR, 0.0];
        count
    }
}

/// A table of quads.
pub type Quads = Table<Quad>;
/// A table of numbers.
pub type Numbers = Table<f32>;
