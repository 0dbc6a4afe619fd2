//! The values at the nodes, and how a cell's are read: all that depends on how they are stored.

use crate::element::Rows;
use crate::lanes::Lanes;
use crate::layout::Starts;
use volmap_formats::asset::Array;

/// Signed distance and volume of each node, side by side.
#[derive(Clone, Debug)]
pub(crate) enum Pairs {
    F32(Vec<[f32; 2]>),
    F64(Vec<[f64; 2]>),
    Rounded(Multiples),
}

/// The same of an adaptive map: rounded values are held as f32, for at constrained nodes they are no multiples.
#[derive(Clone, Debug)]
pub(crate) enum RealPairs {
    F32(Vec<[f32; 2]>),
    F64(Vec<[f64; 2]>),
}

impl RealPairs {
    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        match self {
            RealPairs::F32(nodes) => size_of_val(nodes.as_slice()),
            RealPairs::F64(nodes) => size_of_val(nodes.as_slice()),
        }
    }
}

/// Whole numbers of the two steps.
#[derive(Clone, Debug)]
pub(crate) struct Multiples {
    nodes: Vec<[i16; 2]>,
    steps: [f64; 2],
}

impl Pairs {
    /// `None` if the arrays differ in type.
    pub fn interleave(distance: &Array, volume: &Array) -> Option<Pairs> {
        match (distance, volume) {
            (Array::F32(d), Array::F32(v)) => {
                Some(Pairs::F32(d.iter().zip(v).map(|(&d, &v)| [d, v]).collect()))
            }
            (Array::F64(d), Array::F64(v)) => {
                Some(Pairs::F64(d.iter().zip(v).map(|(&d, &v)| [d, v]).collect()))
            }
            (Array::Rounded(d), Array::Rounded(v)) => Some(Pairs::Rounded(Multiples {
                nodes: d.multiples.iter().zip(&v.multiples).map(|(&d, &v)| [d, v]).collect(),
                steps: [d.step, v.step],
            })),
            _ => None,
        }
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Pairs::F32(nodes) => size_of_val(nodes.as_slice()),
            Pairs::F64(nodes) => size_of_val(nodes.as_slice()),
            Pairs::Rounded(multiples) => size_of_val(multiples.nodes.as_slice()),
        }
    }
}

/// One number a node, of a field that is asked for by itself.
#[derive(Clone, Debug)]
pub(crate) enum Singles {
    F32(Vec<f32>),
    F64(Vec<f64>),
    Rounded(Steps),
}

/// Whole numbers of a step.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    nodes: Vec<i16>,
    step: f64,
}

impl Singles {
    /// `None` if the array isn't a field's.
    pub fn new(array: &Array) -> Option<Singles> {
        match array {
            Array::F32(v) => Some(Singles::F32(v.clone())),
            Array::F64(v) => Some(Singles::F64(v.clone())),
            Array::Rounded(v) => Some(Singles::Rounded(Steps { nodes: v.multiples.clone(), step: v.step })),
            Array::U32(_) => None,
        }
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Singles::F32(nodes) => size_of_val(nodes.as_slice()),
            Singles::F64(nodes) => size_of_val(nodes.as_slice()),
            Singles::Rounded(steps) => size_of_val(steps.nodes.as_slice()),
        }
    }
}

/// One way to store the values at the nodes. A single field stands where the volume does, with zeros for the distance.
pub(crate) trait Storage {
    /// Distance and volume of two nodes that follow each other.
    fn two<V: Lanes>(&self, start: u32) -> V;
    /// Of four.
    fn four<V: Lanes>(&self, start: u32) -> [V; 2];
}

impl Storage for [[f32; 2]] {
    #[inline(always)]
    fn two<V: Lanes>(&self, start: u32) -> V {
        let [a, b] = slice(self, start);
        V::widen([a[0], a[1], b[0], b[1]])
    }

    #[inline(always)]
    fn four<V: Lanes>(&self, start: u32) -> [V; 2] {
        let [a, b, c, d] = slice(self, start);
        [V::widen([a[0], a[1], b[0], b[1]]), V::widen([c[0], c[1], d[0], d[1]])]
    }
}

impl Storage for [[f64; 2]] {
    #[inline(always)]
    fn two<V: Lanes>(&self, start: u32) -> V {
        let [a, b] = slice(self, start);
        V::new([a[0], a[1], b[0], b[1]])
    }

    #[inline(always)]
    fn four<V: Lanes>(&self, start: u32) -> [V; 2] {
        let [a, b, c, d] = slice(self, start);
        [V::new([a[0], a[1], b[0], b[1]]), V::new([c[0], c[1], d[0], d[1]])]
    }
}

impl Storage for Multiples {
    #[inline(always)]
    fn two<V: Lanes>(&self, start: u32) -> V {
        let [a, b] = slice(&self.nodes, start);
        self.scaled(*a, *b)
    }

    #[inline(always)]
    fn four<V: Lanes>(&self, start: u32) -> [V; 2] {
        let [a, b, c, d] = slice(&self.nodes, start);
        [self.scaled(*a, *b), self.scaled(*c, *d)]
    }
}

impl Multiples {
    #[inline(always)]
    fn scaled<V: Lanes>(&self, a: [i16; 2], b: [i16; 2]) -> V {
        let [distance, volume] = self.steps;
        let numbers = V::new([a[0].into(), a[1].into(), b[0].into(), b[1].into()]);
        numbers * V::new([distance, volume, distance, volume])
    }
}

impl Storage for [f32] {
    #[inline(always)]
    fn two<V: Lanes>(&self, start: u32) -> V {
        let &[a, b] = slice(self, start);
        V::widen([0.0, a, 0.0, b])
    }

    #[inline(always)]
    fn four<V: Lanes>(&self, start: u32) -> [V; 2] {
        let &[a, b, c, d] = slice(self, start);
        [V::widen([0.0, a, 0.0, b]), V::widen([0.0, c, 0.0, d])]
    }
}

impl Storage for [f64] {
    #[inline(always)]
    fn two<V: Lanes>(&self, start: u32) -> V {
        let &[a, b] = slice(self, start);
        V::new([0.0, a, 0.0, b])
    }

    #[inline(always)]
    fn four<V: Lanes>(&self, start: u32) -> [V; 2] {
        let &[a, b, c, d] = slice(self, start);
        [V::new([0.0, a, 0.0, b]), V::new([0.0, c, 0.0, d])]
    }
}

impl Storage for Steps {
    #[inline(always)]
    fn two<V: Lanes>(&self, start: u32) -> V {
        let &[a, b] = slice(&self.nodes, start);
        V::new([0.0, a.into(), 0.0, b.into()]) * V::splat(self.step)
    }

    #[inline(always)]
    fn four<V: Lanes>(&self, start: u32) -> [V; 2] {
        let &[a, b, c, d] = slice(&self.nodes, start);
        let step = V::splat(self.step);
        [V::new([0.0, a.into(), 0.0, b.into()]) * step, V::new([0.0, c.into(), 0.0, d.into()]) * step]
    }
}

/// In range for every cell: that is what is checked when the map is opened.
#[inline(always)]
fn slice<T, const N: usize>(nodes: &[T], start: u32) -> &[T; N] {
    let start = start as usize;
    nodes[start..start + N].first_chunk().expect("as long as the slice")
}

/// The nodes of one of a cell's four cubes.
#[inline(always)]
pub(crate) fn rows<V: Lanes, S: Storage + ?Sized>(fields: &S, Starts(at): &Starts, cube: usize) -> Rows<V> {
    if cube < 2 {
        let at = &at[4 * cube..4 * cube + 4];
        [fields.two(at[0]), fields.two(at[1]), fields.two(at[2]), fields.two(at[3])]
    } else {
        let at = &at[4 + 2 * cube..6 + 2 * cube];
        let ([a, b], [c, d]) = (fields.four(at[0]), fields.four(at[1]));
        [a, b, c, d]
    }
}
