//! Validation: experiments whose answer is known.
//!
//! ```text
//! Experiment -> run: scenes made here, simulated, measured -> Outcome: rows with targets, charts -> table, JSON, PNG
//! ```
//! Some of them are in Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 5. Their results
//! are in VALIDATION.md.

pub mod dam_break;
pub mod floats;
pub mod flow;
pub mod grid;
pub mod hydrostatic;
pub mod incline;
pub mod kernels;
pub mod momentum;
mod released;
pub mod sphere;

use volmap_bake::watch::Watch;
use volmap_fluid::Error;
use volmap_fluid::simulation::{Simulation, StepReport};
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
    kernels::EXPERIMENT,
];

/// How an experiment is run.
pub struct Run<'a> {
    /// Fewer, coarser and shorter cases, which take some ten seconds.
    pub short: bool,
    /// Stops the experiment, which then ends with [`Error::Cancelled`].
    pub watch: &'a Watch,
    /// Called with a line about each case as it begins.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

impl Run<'_> {
    /// The value for the short or the long form.
    pub fn pick<T>(&self, short: T, long: T) -> T {
        if self.short { short } else { long }
    }

    /// Simulates until a time (seconds), and shows every step to `look`.
    ///
    /// # Errors
    /// As [`Simulation::step`]; [`Error::Cancelled`].
    pub fn until(
        &self,
        simulation: &mut Simulation,
        time: f64,
        look: &mut dyn FnMut(&Simulation, &StepReport),
    ) -> Result<(), Error> {
        while simulation.time() < time - 1e-9 {
            self.watch.check()?;
            let report = simulation.step()?;
            look(simulation, &report);
        }
        Ok(())
    }
}
