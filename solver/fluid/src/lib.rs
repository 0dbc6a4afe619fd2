//! Incompressible fluids by DFSPH, with volume maps as static and rigid boundaries.
//!
//! ```text
//! particles, bodies -> (cells -> blocks -> neighbours -> boundary -> pressure -> rigid bodies) per step
//! ```
//! Bender and Koschier 2017, *Divergence-Free SPH for Incompressible and Viscous Fluids*, in the pressure form of
//! Band et al. 2018 (Algorithm 1); boundaries by Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*.

pub mod blocks;
pub mod bodies;
pub mod boundary;
pub mod cells;
pub mod channels;
pub mod coupling;
pub mod discretization;
pub mod emitter;
pub mod error;
pub mod fields;
pub mod forces;
pub mod lattice;
pub mod neighbours;
pub mod observe;
pub mod pairs;
pub mod particles;
pub mod plane;
pub mod pressure;
pub mod report;
pub mod response;
pub mod settings;
pub mod setup;
pub mod shapes;
pub mod simulation;
pub mod stages;
pub mod state;
mod strays;
pub mod time_step;

pub use error::Error;
