//! Values at points of the fine lattice, each computed once.

use super::lattice::{FineLattice, Key};
use crate::sdf::{Neighbours, SignedDistance};
use crate::watch::{Cancelled, Work};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Points that a thread works on in turn.
const CHUNK: usize = 64;

/// Values by point.
#[derive(Clone, Debug, Default)]
pub struct Samples(FxHashMap<Key, f64>);

impl Samples {
    /// The value at a point, which was asked for before.
    pub fn at(&self, key: Key) -> f64 {
        self.0[&key]
    }

    /// The value at a point, if it is known.
    pub fn get(&self, key: Key) -> Option<f64> {
        self.0.get(&key).copied()
    }

    /// Takes the value of a point, unless it has one.
    pub fn insert_new(&mut self, key: Key, value: f64) {
        self.0.entry(key).or_insert(value);
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Those of the points that have no value yet, each once, in the order of their keys.
    pub fn missing(&self, keys: impl ParallelIterator<Item = Key>) -> Vec<Key> {
        let mut keys: Vec<Key> = keys.filter(|key| !self.0.contains_key(key)).collect();
        keys.par_sort_unstable();
        keys.dedup();
        keys
    }

    /// Takes the values of points.
    pub fn insert(&mut self, keys: &[Key], values: Vec<f64>) {
        self.0.reserve(keys.len());
        self.0.extend(keys.iter().copied().zip(values));
    }

    /// Makes the signed distance known at all these points.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn ask_distance(
        &mut self,
        keys: impl ParallelIterator<Item = Key>,
        lattice: &FineLattice,
        phi: &impl SignedDistance,
        work: &Work,
    ) -> Result<(), Cancelled> {
        let keys = self.missing(keys);
        let values: Vec<Vec<f64>> = keys
            .par_chunks(CHUNK)
            .map_init(Neighbours::default, |near, keys| {
                work.check()?;
                Ok(distances(keys, lattice, phi, near))
            })
            .collect::<Result<_, Cancelled>>()?;
        self.insert(&keys, values.concat());
        Ok(())
    }
}

fn distances(
    keys: &[Key],
    lattice: &FineLattice,
    phi: &impl SignedDistance,
    near: &mut Neighbours,
) -> Vec<f64> {
    let mut values = Vec::with_capacity(keys.len());
    for keys in keys.chunks(Neighbours::MAX) {
        let mut points = [glam::DVec3::ZERO; Neighbours::MAX];
        points.iter_mut().zip(keys).for_each(|(point, &key)| *point = lattice.position(key));
        let points = &points[..keys.len()];
        phi.prepare(points, near, true);
        values.extend(points.iter().zip(&mut near.known).map(|(point, known)| phi.near(*point, known)));
    }
    values
}
