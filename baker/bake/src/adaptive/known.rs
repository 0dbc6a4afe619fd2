//! What is known at the points of the lattice.

use super::lattice::{Key, LevelCell};
use super::probes;
use super::samples::Samples;
use rustc_hash::FxHashMap;

/// What is known at the points of the lattice.
#[derive(Default)]
pub struct Known {
    /// Phi, metres.
    pub distance: Samples,
    /// V, m^3.
    pub volume: Samples,
    /// The same at the probes of cells of the band.
    pub at_probes: FxHashMap<LevelCell, Exact>,
    /// The last fits at nodes.
    pub fitted: FxHashMap<Key, Fitted>,
}

/// What a fit found at a node.
#[derive(Clone, Copy, Debug)]
pub struct Fitted {
    /// Phi of the map, metres.
    pub distance: f64,
    /// The stored volume, m^3.
    pub volume: f64,
    /// What that is more than the exact one.
    pub added: f64,
}

/// What is known at the probes of a cell, side by side: rounds ask for it again and again.
pub struct Exact {
    /// Phi, metres.
    pub distance: [f32; probes::COUNT],
    /// V, m^3.
    pub volume: [f32; probes::COUNT],
}
