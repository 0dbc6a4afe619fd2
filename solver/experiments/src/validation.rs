//! Validation: experiments whose answer is known.
//!
//! ```text
//! Experiment -> run: scenes made here, simulated, measured -> Outcome: rows with targets, charts -> table, JSON, PNG
//! ```
//! Some of them are in Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 5. Their results are in
//! VALIDATION.md.

pub mod dam_break;
pub mod floats;
pub mod flow;
pub mod grid;
pub mod hydrostatic;
pub mod incline;
pub mod momentum;
pub mod sphere;

use std::path::PathBuf;
use volmap_fluid::Error;
use volmap_report::experiments;
pub use volmap_report::experiments::{ChartFile, Outcome, Row, chart, curve, table};

/// Something that is simulated and measured.
pub type Experiment = experiments::Experiment<fn(&Run) -> Result<Outcome, Error>>;

/// All of them.
pub const EXPERIMENTS: &[Experiment] = &[
    hydrostatic::EXPERIMENT,
    momentum::EXPERIMENT,
    dam_break::EXPERIMENT,
    floats::EXPERIMENT,
    sphere::EXPERIMENT,
    incline::EXPERIMENT,
    grid::EXPERIMENT,
];

/// How an experiment is done.
pub struct Run<'a> {
    /// In some ten seconds: fewer cases, coarser, shorter.
    pub short: bool,
    /// Where files may be left that are no charts; charts are in the outcome.
    pub folder: Option<PathBuf>,
    /// Hears what is being done, in a line, often.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

impl Run<'_> {
    /// The short or the long one of two.
    pub fn pick<T>(&self, short: T, long: T) -> T {
        if self.short { short } else { long }
    }
}
