//! Incompressible fluids by DFSPH, with volume maps as static and rigid boundaries.
//!
//! ```text
//! scene -> particles, bodies -> (cells -> blocks -> neighbours -> boundary -> pressure -> rigid bodies) per step -> output
//! ```
//! Bender and Koschier 2017, *Divergence-Free SPH for Incompressible and Viscous Fluids*, in the pressure form of
//! Band et al. 2018 (Algorithm 1); boundaries by Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*.

pub mod assemble;
pub mod blocks;
pub mod bodies;
pub mod boundary;
pub mod cells;
pub mod coupling;
pub mod error;
pub mod fields;
pub mod neighbours;
mod non_pressure;
pub mod output;
pub mod pairs;
pub mod particles;
pub mod plane;
pub mod pressure;
pub mod reproduce;
pub mod response;
pub mod resume;
pub mod scene;
pub mod session;
pub mod settings;
pub mod simulation;
pub mod stages;
mod strays;
pub mod time_step;
pub mod validation;
pub mod viscosity;

pub use error::Error;
