//! Scene files of fluids and bodies, and runs of them into folders.
//!
//! ```text
//! scene file -> scene -> assemble -> plan: a simulation -> session -> output: frames, pictures, checkpoints
//! ```
//!
//! # A scene
//!
//! A [`scene::Scene`] is a scene file's content. It is read by [`scene::load`] or [`scene::parse`], or made in Rust:
//!
//! ```
//! use volmap_scenes::scene::{self, Block, Scene, Syntax};
//!
//! # fn main() -> Result<(), volmap_scenes::Error> {
//! let text = "version = 1\nparticle_radius = 0.05\nblocks = [{ min = [0, 0, 0], max = [1, 1, 1] }]";
//! let read = scene::parse(text, Syntax::Toml, "a scene")?;
//!
//! let block = Block { min: [0.0; 3], max: [1.0; 3], velocity: [0.0; 3], packing: Default::default() };
//! let made = Scene { particle_radius: 0.05, blocks: vec![block], ..Scene::default() };
//! assert_eq!(read, made);
//!
//! let error = scene::parse("version = 1\nradius = 0.05", Syntax::Toml, "a scene").unwrap_err();
//! assert!(error.to_string().starts_with("a scene:2:1: unknown key `radius`"));
//! # Ok(())
//! # }
//! ```
//!
//! # A simulation
//!
//! [`scene::prepare()`] checks the scene, opens or bakes its maps and places its particles;
//! [`assemble::assemble`] makes of it what a simulation begins with. Nothing is written but baked maps.
//!
//! ```
//! # use volmap_scenes::scene::{self, Block, Scene};
//! use volmap_bake::watch::Watch;
//! use volmap_fluid::simulation::Simulation;
//! use volmap_scenes::assemble::assemble;
//!
//! # fn main() -> Result<(), volmap_scenes::Error> {
//! # let block = Block { min: [0.0; 3], max: [0.5; 3], velocity: [0.0; 3], packing: Default::default() };
//! # let scene = Scene { particle_radius: 0.05, blocks: vec![block], ..Scene::default() };
//! let watch = Watch::default();
//! let prepared = scene::prepare(&scene, &watch, &mut |mesh| println!("baking {}", mesh.display()))?;
//! let mut simulation = Simulation::new(assemble(&scene, prepared)?)?;
//! let report = simulation.step()?;
//! assert_eq!(simulation.particles().len(), 125);
//! assert!(report.dt > 0.0);
//! # Ok(())
//! # }
//! ```
//!
//! # A run
//!
//! A [`session::Session`] simulates into a folder: frames, pictures, statistics and checkpoints. The package's
//! `examples/` has a program that runs a scene file and looks at each frame. A [`Watch`](volmap_bake::watch::Watch)
//! stops it from another thread: it ends after the step, with a checkpoint.
//!
//! # Guarantees
//!
//! - Results are the same bytes on any number of threads. Only wall-clock times differ.
//! - A resumed run gives the same bytes as one that was never stopped, wherever it was stopped or killed.
//! - Each file but the tables appears whole or not at all. A folder with a run is never replaced unless
//!   [`session::Begin::Overwrite`] is set, and two sessions are never in one folder: the second is refused.
//! - Scene files and checkpoints may hold anything: what can't be used is an [`Error`] that names its place, never a
//!   panic.
//!
//! Not guaranteed: the same bytes on processors of other architectures; locks on file systems that have none.

pub mod assemble;
pub mod error;
pub mod output;
mod packing;
pub mod plan;
pub mod resume;
pub mod scene;
pub mod session;

pub use error::Error;
