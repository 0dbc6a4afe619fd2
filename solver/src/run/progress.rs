//! One line about the last step: redrawn on a terminal, printed every few seconds elsewhere.

use super::tell;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};
use volmap_formats::text::{duration, thousands};
use volmap_scenes::session::Progress;

/// The line.
pub struct ProgressLine {
    quiet: bool,
    bar: Option<ProgressBar>,
    start: Instant,
    first_time: Option<f64>,
    last: Instant,
}

/// Time between lines that can't be redrawn.
const INTERVAL: Duration = Duration::from_secs(5);

impl ProgressLine {
    /// Nothing is printed if `quiet`.
    pub fn new(quiet: bool) -> ProgressLine {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}").expect("a template");
            ProgressBar::new_spinner().with_style(style)
        });
        let now = Instant::now();
        ProgressLine { quiet, bar, start: now, first_time: None, last: now }
    }

    /// Shows a step.
    pub fn show(&mut self, progress: &Progress) {
        let step = &progress.step.statistics;
        let first = *self.first_time.get_or_insert(step.time - step.dt);
        self.tell_notes(&progress.step.notes);
        if let Some(bar) = &self.bar {
            bar.set_message(self.text(progress, first));
            bar.tick();
        } else if !self.quiet && self.last.elapsed() > INTERVAL {
            tell(format_args!("{}", self.text(progress, first)));
            self.last = Instant::now();
        }
    }

    /// Above the line, which stays the last.
    fn tell_notes(&self, notes: &[String]) {
        for note in notes.iter().filter(|_| !self.quiet) {
            let line = || tell(format_args!("note       {note}"));
            self.bar.as_ref().map_or_else(line, |bar| bar.suspend(line));
        }
    }

    /// Removes the line.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn text(&self, progress: &Progress, first: f64) -> String {
        let step = &progress.step.statistics;
        format!(
            "t {:.4} s, step {}, {} particles, dt {:.2} ms, {} + {} iterations, density error {:.3} % \
             (most {:.1} %), {:.1} ms per step{}",
            step.time,
            step.step,
            thousands(step.particles),
            1e3 * step.dt,
            step.density_iterations,
            step.divergence_iterations,
            100.0 * step.density_error,
            100.0 * step.density_error_max,
            step.step_ms,
            self.left(progress, first)
        )
    }

    fn left(&self, progress: &Progress, first: f64) -> String {
        let step = &progress.step.statistics;
        let mut done = (step.time - first) / (progress.end - first);
        if let Some(last) = progress.last_step {
            done = done.max(step.step as f64 / last as f64);
        }
        let seconds = self.start.elapsed().as_secs_f64() * (1.0 / done - 1.0);
        if seconds.is_finite() { format!(", {} left", duration(seconds)) } else { String::new() }
    }
}
