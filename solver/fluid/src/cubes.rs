//! Points by cubes of one edge, to find those near a place; for points that aren't the fluid's, whose
//! [cells](crate::cells) are.

use glam::IVec3;
use std::collections::HashMap;
use volmap_runtime::DVec3;

/// Points, each with a value.
#[derive(Clone, Debug)]
pub struct Cubes<T> {
    edge: f64,
    cubes: HashMap<IVec3, Vec<(DVec3, T)>>,
}

impl<T> Cubes<T> {
    /// None yet; `edge` is that of the cubes, metres, which must be more than 0.
    pub fn new(edge: f64) -> Cubes<T> {
        Cubes { edge, cubes: HashMap::new() }
    }

    /// The edge of a cube, metres.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// Adds a point, metres.
    pub fn add(&mut self, point: DVec3, value: T) {
        self.cubes.entry(self.cube(point)).or_default().push((point, value));
    }

    /// The points of the 27 cubes around a place, in the order in which those of a cube came: all that are nearer than
    /// an edge, and some others.
    pub fn around(&self, place: DVec3) -> impl Iterator<Item = &(DVec3, T)> {
        let cube = self.cube(place);
        let steps = (0..27).map(|i| IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
        steps.filter_map(move |step| self.cubes.get(&cube.saturating_add(step))).flatten()
    }

    fn cube(&self, point: DVec3) -> IVec3 {
        (point / self.edge).floor().as_ivec3()
    }
}
