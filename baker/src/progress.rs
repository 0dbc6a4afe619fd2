//! Progress on a terminal; a line for the plan elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;
use volmap_baker::bake::Step;
use volmap_baker::maps::Stage;
use volmap_baker::plan::Plan;
use volmap_baker::summary::{bytes, thousands};

/// Shows what the bake is at.
pub struct Progress {
    bar: ProgressBar,
    quiet: bool,
}

impl Progress {
    /// A spinner on a terminal; hidden elsewhere.
    pub fn new(quiet: bool) -> Progress {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        bar.set_style(ProgressStyle::default_spinner());
        bar.enable_steady_tick(Duration::from_millis(100));
        Progress { bar, quiet }
    }

    /// Prints the estimate before anything large is computed.
    pub fn plan(&self, plan: &Plan) {
        if self.quiet {
            return;
        }
        let n = plan.grid.resolution;
        let line = format!(
            "plan       {} x {} x {} cells, about {} in the band, {} of memory, {:.1} s on one thread",
            n.x,
            n.y,
            n.z,
            thousands(plan.estimate.cells),
            bytes(plan.estimate.memory),
            plan.estimate.seconds
        );
        self.bar.suspend(|| eprintln!("{line}"));
    }

    /// Names the step.
    pub fn step(&self, step: Step) {
        self.bar.set_message(match step {
            Step::Mesh => "examining the mesh",
            Step::Field(Stage::Band) => "finding the band",
            Step::Field(Stage::Distance) => "sampling the distance",
            Step::Field(Stage::Volume) => "integrating the volume",
            Step::CheckSign => "comparing the signs",
        });
    }

    /// Clears the spinner.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
