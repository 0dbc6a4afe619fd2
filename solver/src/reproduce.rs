//! Experiments of the papers, and of the methods beside each other, scaled to a small machine.
//!
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*; Band et al. 2018, *MLS Pressure Boundaries for
//! Divergence-free and Viscous SPH Fluids*. METHODS.md of this crate tells what comes of them. They are made as those of
//! [`crate::validation`]; a row has the paper's figure where it gives one.

pub mod boundaries;
pub mod fig11;
pub mod friction;
pub mod incline;
pub mod puck;
pub mod rigid;
pub mod sticky;
pub mod table1;

use crate::validation::Experiment;

/// All of them.
pub const EXPERIMENTS: &[Experiment] = &[
    incline::EXPERIMENT,
    puck::EXPERIMENT,
    fig11::EXPERIMENT,
    sticky::EXPERIMENT,
    friction::EXPERIMENT,
    table1::EXPERIMENT,
];
