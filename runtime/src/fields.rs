//! The values at the nodes, and how a cell's are read: all that depends on how they are stored.

use crate::cells::Starts;
use crate::element::{ROWS, Rows};
use crate::lanes::Lanes;
use volmap_formats::asset::Array;

/// Signed distance and volume of each node, side by side.
#[derive(Clone, Debug)]
pub(crate) enum Fields {
    F32(Vec<[f32; 2]>),
    F64(Vec<[f64; 2]>),
}

impl Fields {
    /// `None` if the arrays differ in type.
    pub fn interleave(distance: &Array, volume: &Array) -> Option<Fields> {
        match (distance, volume) {
            (Array::F32(d), Array::F32(v)) => {
                Some(Fields::F32(d.iter().zip(v).map(|(&d, &v)| [d, v]).collect()))
            }
            (Array::F64(d), Array::F64(v)) => {
                Some(Fields::F64(d.iter().zip(v).map(|(&d, &v)| [d, v]).collect()))
            }
            _ => None,
        }
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Fields::F32(nodes) => size_of_val(nodes.as_slice()),
            Fields::F64(nodes) => size_of_val(nodes.as_slice()),
        }
    }
}

/// One way to store the values at the nodes.
pub(crate) trait Storage {
    /// Distance and volume of `N` nodes that follow each other.
    fn nodes<const N: usize>(&self, start: u32) -> [[f64; 2]; N];
}

impl Storage for [[f32; 2]] {
    #[inline(always)]
    fn nodes<const N: usize>(&self, start: u32) -> [[f64; 2]; N] {
        let start = start as usize;
        let mut out = [[0.0; 2]; N];
        for (out, value) in out.iter_mut().zip(&self[start..start + N]) {
            *out = [f64::from(value[0]), f64::from(value[1])];
        }
        out
    }
}

impl Storage for [[f64; 2]] {
    #[inline(always)]
    fn nodes<const N: usize>(&self, start: u32) -> [[f64; 2]; N] {
        let start = start as usize;
        let mut out = [[0.0; 2]; N];
        out.copy_from_slice(&self[start..start + N]);
        out
    }
}

/// The 32 nodes of a cell.
#[inline(always)]
pub(crate) fn rows<V: Lanes, S: Storage + ?Sized>(fields: &S, starts: &Starts) -> Rows<V> {
    let mut rows = [V::splat(0.0); ROWS];
    let row = |[a, b]: [[f64; 2]; 2]| V::new([a[0], a[1], b[0], b[1]]);
    for at in 0..4 {
        rows[at] = row(fields.nodes(starts.0[at]));
        rows[4 + at] = row(fields.nodes(starts.0[4 + at]));
        let [a, b, c, d] = fields.nodes(starts.0[8 + at]);
        rows[8 + 2 * at] = row([a, b]);
        rows[9 + 2 * at] = row([c, d]);
    }
    rows
}
