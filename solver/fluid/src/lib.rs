//! Incompressible fluids by DFSPH, with volume maps as static and rigid boundaries.
//!
//! ```text
//! particles, bodies -> (cells -> blocks -> neighbours -> boundary -> pressure, forces -> rigid bodies) per step
//! ```
//! Bender and Koschier 2017, *Divergence-Free SPH for Incompressible and Viscous Fluids*, in the pressure form of
//! Band et al. 2018 (Algorithm 1); boundaries by Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*.
//!
//! A [`Setup`](setup::Setup) has all that a [`Simulation`](simulation::Simulation) begins with. A cube of fluid that
//! falls, in metres, seconds and kilograms:
//!
//! ```
//! use volmap_fluid::bodies::Bodies;
//! use volmap_fluid::lattice::fill_box;
//! use volmap_fluid::particles::Particles;
//! use volmap_fluid::settings::World;
//! use volmap_fluid::setup::Setup;
//! use volmap_fluid::simulation::Simulation;
//! use volmap_runtime::DVec3;
//!
//! # fn main() -> Result<(), volmap_fluid::Error> {
//! let world = World::default();
//! let edge = DVec3::splat(0.2);
//! let places: Vec<DVec3> = fill_box([DVec3::ZERO, edge], 2.0 * world.particle_radius).collect();
//! let mut particles = Particles::default();
//! particles.add(&places, &vec![[0.0; 3]; places.len()]);
//! let bodies = Bodies::new(Vec::new(), world.gravity)?;
//! let mut simulation = Simulation::new(Setup::new(world, particles, bodies))?;
//! let report = simulation.step()?;
//! assert_eq!(simulation.time(), report.dt);
//! assert!(simulation.particles().velocities[0][1] < 0.0);
//! # Ok(())
//! # }
//! ```
//! Bodies are meshes with maps ([`shapes`]); [`forces`] tells how to add a force of one's own, and the folder
//! `examples` has longer pieces.

pub mod blocks;
pub mod bodies;
pub mod boundary;
pub mod cells;
pub mod channels;
pub mod compression;
pub mod coupling;
pub mod cubes;
pub mod discretization;
pub mod emitter;
mod energy;
pub mod error;
pub mod fields;
pub mod forces;
mod fused;
pub mod lattice;
pub mod neighbours;
pub mod observe;
pub mod packing;
pub mod pairs;
pub mod particles;
pub mod plane;
pub mod pressure;
pub mod report;
pub mod response;
pub mod rest;
pub mod room;
pub mod settings;
pub mod setup;
pub mod shapes;
pub mod simulation;
pub mod stages;
pub mod state;
mod strays;
pub mod time_step;

pub use error::Error;
