//! What a sum over neighbours reads of them, side by side: one quad for each particle of a block and around it.

use super::lanes::Quad;
use std::ops::Range;

/// Quads, and one more: a quad begins at every even number of 16 bits, times 8 bytes, and ends within the table at every odd
/// one. So whatever a [`super::Pair`] says is in it.
pub(super) const QUADS: usize = (1 << 15) + 1;

/// Quads of a block's particles, then of those around it. Some 500 kB, of which few are touched.
#[derive(Clone, Debug)]
pub struct Table {
    quads: Box<[Quad; QUADS]>,
}

impl Default for Table {
    fn default() -> Table {
        let quads = vec![[0.0; 4]; QUADS].into_boxed_slice();
        Table { quads: quads.try_into().expect("as many as that") }
    }
}

impl Table {
    /// Particles that it has room for, one that is far from all besides.
    pub const ROOM: usize = QUADS - 2;

    /// Takes the quads of particles in these ranges; how many they are.
    #[inline]
    pub(crate) fn fill(&mut self, ranges: &[Range<u32>], field: &[Quad]) -> usize {
        let mut end = 0;
        for range in ranges {
            let from = &field[range.start as usize..range.end as usize];
            self.quads[end..end + from.len()].copy_from_slice(from);
            end += from.len();
        }
        end
    }

    /// The same of numbers, each four times.
    #[inline]
    pub(crate) fn fill_with(&mut self, ranges: &[Range<u32>], numbers: &[f32]) {
        let mut rest = &mut self.quads[..];
        for range in ranges {
            let from = &numbers[range.start as usize..range.end as usize];
            let (to, behind) = rest.split_at_mut(from.len());
            for (to, from) in to.iter_mut().zip(from) {
                *to = [*from; 4];
            }
            rest = behind;
        }
    }

    pub(crate) fn set(&mut self, local: usize, quad: Quad) {
        self.quads[local] = quad;
    }

    /// The quads, of which the first are filled.
    #[inline(always)]
    pub(crate) fn quads(&self) -> &[Quad; QUADS] {
        &self.quads
    }

    /// All numbers; from each `2 * place`, a quad.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> &[f32; 4 * QUADS] {
        self.quads.as_flattened().try_into().expect("as many as that")
    }
}
