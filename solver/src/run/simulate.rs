//! `volmap-sim run`.

use crate::args::RunArguments;
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use volmap_formats::text::{duration, number, percent, thousands};
use volmap_scenes::output::statistics::Summary;
use volmap_scenes::session::{Progress, RunSettings, Session};

/// Simulates a scene.
pub fn run_simulate(arguments: &RunArguments) -> Result<()> {
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    let settings = RunSettings {
        resume: arguments.resume,
        overwrite: arguments.overwrite,
        steps: arguments.steps,
        until: arguments.until,
    };
    let mut on_bake = |mesh: &Path| {
        if !arguments.quiet {
            eprintln!("baking     {}, on its first use", mesh.display());
        }
    };
    let mut session = Session::open(&arguments.scene, &arguments.output, &settings, &mut on_bake)?;
    for note in session.notes.iter().filter(|_| !arguments.quiet) {
        eprintln!("note       {note}");
    }
    let boundary_particles = session.simulation().boundary_particles();
    if boundary_particles > 0 && !arguments.quiet {
        eprintln!("boundary   {} particles", thousands(boundary_particles as u64));
    }
    let stop = stop_on_signal()?;
    let mut line = Line::new(arguments.quiet);
    let summary = session.run(&mut |progress| {
        line.show(progress);
        !stop.load(Ordering::Relaxed)
    })?;
    line.finish();
    if !arguments.quiet {
        print(&summary, &arguments.output);
    }
    // A signal in the last step stops nothing.
    if !session.is_done() {
        anyhow::bail!("stopped; --resume goes on from here");
    }
    Ok(())
}

/// Ctrl-C ends a run after its step, with a check-point.
fn stop_on_signal() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)).context("Ctrl-C")?;
    Ok(stop)
}

/// One line about the step: redrawn on a terminal, now and then elsewhere.
struct Line {
    quiet: bool,
    bar: Option<ProgressBar>,
    start: Instant,
    first_time: Option<f64>,
    last: Instant,
}

/// How often a line is printed where it can't be redrawn.
const INTERVAL: Duration = Duration::from_secs(5);

impl Line {
    fn new(quiet: bool) -> Line {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}").expect("a template");
            ProgressBar::new_spinner().with_style(style)
        });
        let now = Instant::now();
        Line { quiet, bar, start: now, first_time: None, last: now }
    }

    fn show(&mut self, progress: &Progress) {
        let step = progress.statistics;
        let first = *self.first_time.get_or_insert(step.time - step.dt);
        let message = || {
            format!(
                "t {:.4} s, step {}, {} particles, dt {:.2} ms, {} + {} iterations, density error {:.3} %, {:.1} ms a step{}",
                step.time,
                step.step,
                thousands(step.particles),
                1e3 * step.dt,
                step.density_iterations,
                step.divergence_iterations,
                100.0 * step.density_error,
                step.step_ms,
                self.left(progress, first)
            )
        };
        if let Some(bar) = &self.bar {
            bar.set_message(message());
            bar.tick();
        } else if !self.quiet && self.last.elapsed() > INTERVAL {
            eprintln!("{}", message());
            self.last = Instant::now();
        }
    }

    fn left(&self, progress: &Progress, first: f64) -> String {
        let step = progress.statistics;
        let mut done = (step.time - first) / (progress.end - first);
        if let Some(last) = progress.last_step {
            done = done.max(step.step as f64 / last as f64);
        }
        let seconds = self.start.elapsed().as_secs_f64() * (1.0 / done - 1.0);
        if seconds.is_finite() { format!(", {} left", duration(seconds)) } else { String::new() }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn print(summary: &Summary, folder: &Path) {
    println!(
        "simulated  {} s in {} steps, {}, {} particles",
        number(summary.simulated_seconds),
        thousands(summary.steps),
        duration(summary.wall_seconds),
        thousands(summary.particles)
    );
    println!(
        "step       {} ms, {:.1} + {:.1} iterations, density error {} (means); {} million particle steps a second",
        number(summary.step_ms.mean),
        summary.density_iterations.mean,
        summary.divergence_iterations.mean,
        percent(summary.density_error.mean),
        number(1e-6 * summary.particle_steps_per_second)
    );
    let stages: Vec<String> =
        summary.stages_ms.iter().map(|(name, spread)| format!("{name} {}", number(spread.mean))).collect();
    println!("stages     {} ms", stages.join(", "));
    if summary.emitted + summary.removed + summary.brought_back > 0 {
        println!(
            "counts     {} emitted, {} left the domain, {} times found in a body and brought back",
            thousands(summary.emitted),
            thousands(summary.removed),
            thousands(summary.brought_back)
        );
    }
    println!("folder     {}", folder.display());
}
