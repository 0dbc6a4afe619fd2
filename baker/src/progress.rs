//! Progress on a terminal, for whatever takes longer than a moment; a line for the plan elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;
use volmap_bake::bake::Step;
use volmap_bake::plan::Plan;
use volmap_bake::work::Work;
use volmap_formats::text::{bytes, thousands};
use volmap_report::report;
use volmap_report::reproduce;

/// How often the bar is drawn; a bake that is faster shows none.
const TICK: Duration = Duration::from_millis(100);

/// What is being done, and how far it is.
type Shown = (&'static str, Option<Work>);

/// Shows what the program is at.
pub struct Progress {
    quiet: bool,
    /// Of the thread that draws, if there is a terminal to draw on.
    drawing: Option<(Sender<Shown>, JoinHandle<()>)>,
}

impl Progress {
    /// A bar on a terminal; nothing elsewhere.
    pub fn new(quiet: bool) -> Progress {
        let visible = !quiet && std::io::stderr().is_terminal();
        let drawing = visible.then(|| {
            let (steps, received) = mpsc::channel();
            (steps, std::thread::spawn(move || draw(&received)))
        });
        Progress { quiet, drawing }
    }

    /// Prints the estimate before anything large is computed.
    pub fn plan(&self, plan: &Plan) {
        if self.quiet {
            return;
        }
        let n = plan.grid.resolution;
        eprintln!(
            "plan       {} x {} x {} cells, about {} in the band, {} of memory, {:.1} s on one thread",
            n.x,
            n.y,
            n.z,
            thousands(plan.estimate.cells),
            bytes(plan.estimate.memory),
            plan.estimate.seconds
        );
    }

    /// Names the step.
    pub fn step(&self, step: Step) {
        self.show((step.name(), step.work().cloned()));
    }

    /// Names the step of a report.
    pub fn report(&self, step: report::ReportStep) {
        self.show(match step {
            report::ReportStep::Opening => ("preparing", None),
            report::ReportStep::Samples(work) => ("integrating at random points", Some(work)),
            report::ReportStep::Surface => ("measuring the surface", None),
            report::ReportStep::Slices(work) => ("integrating at pixels", Some(work)),
            report::ReportStep::Pictures => ("drawing", None),
        });
    }

    /// Names the step of an experiment.
    pub fn reproduce(&self, step: reproduce::ExperimentStep) {
        self.show((step.name, step.work));
    }

    fn show(&self, shown: Shown) {
        if let Some((steps, _)) = &self.drawing {
            // The thread ends after this end of the channel does.
            let _ = steps.send(shown);
        }
    }

    /// Clears the bar.
    pub fn finish(&mut self) {
        if let Some((steps, thread)) = self.drawing.take() {
            drop(steps);
            let _ = thread.join();
        }
    }
}

/// Nothing is drawn any more when an error is told.
impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Draws the steps that arrive until there are no more.
fn draw(steps: &Receiver<Shown>) {
    let mut current: Option<(ProgressBar, Option<Work>)> = None;
    loop {
        match steps.recv_timeout(TICK) {
            Ok((name, work)) => {
                clear(&current);
                current = Some((bar(name, work.as_ref()), work));
            }
            Err(RecvTimeoutError::Timeout) => tick(&current),
            Err(RecvTimeoutError::Disconnected) => return clear(&current),
        }
    }
}

fn clear(current: &Option<(ProgressBar, Option<Work>)>) {
    if let Some((bar, _)) = current {
        bar.finish_and_clear();
    }
}

fn tick(current: &Option<(ProgressBar, Option<Work>)>) {
    if let Some((bar, work)) = current {
        bar.tick();
        work.iter().for_each(|work| bar.set_position(work.done()));
    }
}

fn bar(name: &'static str, work: Option<&Work>) -> ProgressBar {
    let target = ProgressDrawTarget::stderr();
    let (bar, template) = match work {
        Some(work) => (
            ProgressBar::with_draw_target(Some(work.total), target),
            "{msg} {bar:30} {percent:>3} %, {per_sec}, {eta} left",
        ),
        None => (ProgressBar::with_draw_target(None, target), "{spinner} {msg}, {elapsed}"),
    };
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style);
    bar.set_message(name);
    bar
}
