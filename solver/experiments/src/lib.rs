//! Experiments with the fluids of [`volmap_fluid`]: cases whose answer is known, and experiments of the papers.
//!
//! ```text
//! Experiment -> run: setups made in Rust, simulated, measured -> Outcome: rows with targets, charts
//!            -> table, JSON, PNG
//! ```
//!
//! # Running experiments
//!
//! [`validation::EXPERIMENTS`] and [`reproduce::EXPERIMENTS`] list them. Each has a long form and a short one of about
//! ten seconds.
//!
//! ```no_run
//! use volmap_bake::watch::Watch;
//! use volmap_experiments::validation::{EXPERIMENTS, Run, table};
//!
//! # fn main() -> Result<(), volmap_fluid::Error> {
//! let watch = Watch::default();
//! let run = Run { short: true, watch: &watch, progress: &|text| eprintln!("{text}") };
//! for experiment in EXPERIMENTS {
//!     let outcome = (experiment.run)(&run)?;
//!     print!("{}", table::to_text(experiment.name, &outcome));
//!     assert_eq!(outcome.unmet().count(), 0, "{} misses a target", experiment.name);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # Adding one
//!
//! An experiment is one file with an `EXPERIMENT`, and one line in a list; README.md shows it. [`validation::flow`]
//! makes water, [`reproduce::methods`] every boundary method, [`volmap_fluid::shapes`] bodies, and
//! [`volmap_fluid::observe`] measures.
//!
//! # Guarantees
//!
//! Figures are the same on any number of threads, but for wall-clock times. Experiments read and write no files. A
//! [`Watch`](volmap_bake::watch::Watch) stops them after a step.

pub mod reproduce;
pub mod validation;
