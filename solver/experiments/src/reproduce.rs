//! Reproduction: experiments of the papers, and of all boundary methods side by side, scaled to a small machine.
//!
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*; Band et al. 2018, *MLS Pressure Boundaries for
//! Divergence-free and Viscous SPH Fluids*. Their results are in METHODS.md. They are built as those of
//! [`crate::validation`]; a row has the paper's figure where the paper gives one.

pub mod band1;
pub mod boundaries;
pub mod combinations;
pub mod fig11;
pub mod force;
pub mod friction;
pub mod incline;
pub mod methods;
pub mod prism;
pub mod puck;
pub mod rigid;
pub mod sphere;
pub mod sticky;
pub mod table1;
pub mod tubes;
pub mod washing;

use crate::validation::Experiment;

/// All of them.
#[rustfmt::skip]
pub const EXPERIMENTS: &[Experiment] = &[
    incline::EXPERIMENT,
    puck::EXPERIMENT,
    force::EXPERIMENT,
    fig11::EXPERIMENT,
    sticky::EXPERIMENT,
    friction::EXPERIMENT,
    table1::EXPERIMENT,
    sphere::EXPERIMENT,
    band1::EXPERIMENT,
    washing::EXPERIMENT,
    tubes::EXPERIMENT,
    combinations::EXPERIMENT,
];
