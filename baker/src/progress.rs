//! Progress on a terminal, for whatever takes longer than a moment; a line for the plan elsewhere.

mod batch;

use crate::signals::cancel_on_signals;
use anyhow::Result;
pub use batch::BatchProgress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;
use volmap_bake::plan::Plan;
use volmap_bake::watch::{Cancel, Step, Watch};
use volmap_formats::text::{bytes, thousands};

/// How often the bar is drawn; a bake that is faster shows none.
const TICK: Duration = Duration::from_millis(100);

/// What the thread that draws is told.
enum Told {
    Step(Step),
    /// Nothing comes any more.
    End,
}

/// Shows what the program is at, and stops it when it is told to.
pub struct Progress {
    quiet: bool,
    cancel: Cancel,
    /// Of the thread that draws, if there is a terminal to draw on.
    drawing: Option<(Sender<Told>, JoinHandle<()>)>,
}

/// Whether bars are shown.
fn is_visible(quiet: bool) -> bool {
    !quiet && std::io::stderr().is_terminal()
}

/// A style; templates are those of the program.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Progress {
    /// A bar on a terminal; nothing elsewhere. Signals stop the work from now on.
    pub fn new(quiet: bool) -> Result<Progress> {
        let cancel = cancel_on_signals()?;
        let drawing = is_visible(quiet).then(|| {
            let (steps, received) = mpsc::channel();
            (steps, std::thread::spawn(move || draw(&received)))
        });
        Ok(Progress { quiet, cancel, drawing })
    }

    /// What the work is given.
    pub fn watch(&self) -> Watch {
        let watch = match &self.drawing {
            Some((steps, _)) => {
                let steps = steps.clone();
                // After the end nobody hears it.
                Watch::new(move |step| _ = steps.send(Told::Step(step.clone())))
            }
            None => Watch::default(),
        };
        watch.stopped_by(&self.cancel)
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

    /// Clears the bar.
    pub fn finish(&mut self) {
        if let Some((steps, thread)) = self.drawing.take() {
            let _ = steps.send(Told::End);
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
fn draw(steps: &Receiver<Told>) {
    let mut current: Option<(ProgressBar, Step)> = None;
    loop {
        match steps.recv_timeout(TICK) {
            Ok(Told::Step(step)) => {
                clear(&current);
                current = Some((bar(&step), step));
            }
            Err(RecvTimeoutError::Timeout) => tick(&current),
            Ok(Told::End) | Err(RecvTimeoutError::Disconnected) => return clear(&current),
        }
    }
}

fn clear(current: &Option<(ProgressBar, Step)>) {
    if let Some((bar, _)) = current {
        bar.finish_and_clear();
    }
}

fn tick(current: &Option<(ProgressBar, Step)>) {
    if let Some((bar, step)) = current {
        bar.tick();
        step.work.iter().for_each(|work| bar.set_position(work.done()));
    }
}

fn bar(step: &Step) -> ProgressBar {
    let (length, template) = match &step.work {
        Some(work) => (Some(work.total()), "{msg} {bar:30} {percent:>3} %, {per_sec}, {eta} left"),
        None => (None, "{spinner} {msg}, {elapsed}"),
    };
    let bar = ProgressBar::with_draw_target(length, ProgressDrawTarget::stderr());
    bar.set_style(style(template));
    bar.set_message(step.name);
    bar
}
