//! Progress of a batch on a terminal: a bar for all, a line for each worker.

use super::{is_visible, style};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget};
use std::io::Write;
use std::time::Duration;
use volmap_batch::engine::Event;

/// Shows how far a batch is.
pub struct BatchProgress {
    /// On a terminal only.
    bars: Option<Bars>,
}

struct Bars {
    all: MultiProgress,
    /// In thousandths of a second of estimated work.
    overall: ProgressBar,
    slots: Vec<ProgressBar>,
    assets: usize,
    done: usize,
}

impl BatchProgress {
    /// Bars on a terminal; nothing elsewhere.
    pub fn new(quiet: bool) -> BatchProgress {
        BatchProgress { bars: is_visible(quiet).then(Bars::new) }
    }

    /// Prints a line above the bars.
    pub fn print(&self, line: &str) {
        let print = || {
            // Whoever read may have had enough; the batch goes on.
            let _ = writeln!(std::io::stdout().lock(), "{line}");
        };
        match &self.bars {
            Some(bars) => bars.all.suspend(print),
            None => print(),
        }
    }

    /// Shows what happens.
    pub fn event(&mut self, event: &Event) {
        if let Some(bars) = &mut self.bars {
            bars.event(event);
        }
    }

    /// Takes the bars away.
    pub fn finish(&mut self) {
        if let Some(bars) = self.bars.take() {
            let _ = bars.all.clear();
        }
    }
}

/// Nothing is drawn any more when an error is told.
impl Drop for BatchProgress {
    fn drop(&mut self) {
        self.finish();
    }
}

impl Bars {
    fn new() -> Bars {
        let all = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
        let overall = all.add(ProgressBar::new(0));
        overall.set_style(style("{msg} {wide_bar} {elapsed}, {eta} left"));
        overall.set_message("comparing");
        overall.enable_steady_tick(Duration::from_millis(200));
        Bars { all, overall, slots: Vec::new(), assets: 0, done: 0 }
    }

    fn event(&mut self, event: &Event) {
        match event {
            Event::Checked { assets, .. } => {
                self.assets = *assets;
                self.overall.set_message("estimating");
            }
            Event::Estimated(seconds) => {
                self.overall.set_length((1e3 * seconds) as u64);
                self.overall.reset_eta();
                self.count(0, 0.0);
            }
            Event::Started { slot, name } => self.slot(*slot).set_message((*name).to_owned()),
            Event::Step { slot, name, step } => self.slot(*slot).set_message(format!("{name}: {step}")),
            Event::Finished { slot, report } => {
                // Others are settled before the work begins.
                let seconds = slot.and(report.estimated_seconds);
                self.count(1, seconds.unwrap_or(0.0));
                if let Some(slot) = slot {
                    self.slot(*slot).set_message("");
                }
            }
        }
    }

    fn count(&mut self, done: usize, seconds: f64) {
        self.done += done;
        self.overall.inc((1e3 * seconds) as u64);
        self.overall.set_message(format!("{} of {}", self.done, self.assets));
    }

    fn slot(&mut self, slot: usize) -> &ProgressBar {
        while self.slots.len() <= slot {
            let bar = self.all.add(ProgressBar::new_spinner());
            bar.set_style(style("  {msg}"));
            self.slots.push(bar);
        }
        &self.slots[slot]
    }
}
