//! `volmap-sim run`.

use super::progress::ProgressLine;
use super::{baking, set_threads, tell};
use crate::args::RunArguments;
use crate::signals;
use anyhow::{Result, bail};
use std::io::{self, Write};
use std::path::Path;
use volmap_formats::text::{duration, number, percent, thousands};
use volmap_scenes::output::RunSummary;
use volmap_scenes::session::{Begin, RunSettings, Session};

/// Simulates a scene.
pub fn run_simulate(arguments: &RunArguments) -> Result<()> {
    set_threads(arguments.threads)?;
    let quiet = arguments.quiet;
    let mut on_bake = |mesh: &Path| baking(mesh, quiet);
    let watch = signals::watch()?;
    let settings = settings(arguments);
    let mut session = Session::open(&arguments.scene, &arguments.output, &settings, &watch, &mut on_bake)?;
    if !quiet {
        print_notes(&session);
    }
    let mut line = ProgressLine::new(quiet);
    let summary = session.run(&watch, &mut |progress| line.show(progress))?;
    line.finish();
    if !quiet {
        print_summary(&summary, &arguments.output)?;
    }
    // A signal in the last step stops nothing.
    if !session.is_done() {
        bail!("stopped; --resume continues from here");
    }
    Ok(())
}

fn settings(arguments: &RunArguments) -> RunSettings {
    let begin = match (arguments.resume, arguments.overwrite) {
        (true, _) => Begin::Resume,
        (_, true) => Begin::Overwrite,
        _ => Begin::New,
    };
    let max_memory = arguments.max_memory.map(|bytes| bytes.0);
    RunSettings { begin, steps: arguments.steps, until: arguments.until, max_memory }
}

fn print_notes(session: &Session) {
    for note in &session.notes {
        tell(format_args!("note       {note}"));
    }
    let boundary_particles = session.simulation().boundary_particles();
    if boundary_particles > 0 {
        tell(format_args!("boundary   {} particles", thousands(boundary_particles as u64)));
    }
}

fn print_summary(summary: &RunSummary, folder: &Path) -> Result<()> {
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "simulated  {} s in {} steps and {}; {} particles",
        number(summary.simulated_seconds),
        thousands(summary.steps),
        duration(summary.wall_seconds),
        thousands(summary.particles)
    )?;
    writeln!(
        out,
        "step       mean {} ms, {:.1} + {:.1} iterations; {} million particle steps per second",
        number(summary.step_ms.mean),
        summary.density_iterations.mean,
        summary.divergence_iterations.mean,
        number(1e-6 * summary.particle_steps_per_second)
    )?;
    writeln!(
        out,
        "density    denser than at rest by {} in the mean over particles and steps, by {} at most; solves left {}",
        percent(summary.density_error.mean),
        percent(summary.density_error_max.most),
        percent(summary.density_residual.mean)
    )?;
    let stages: Vec<String> =
        summary.stages_ms.iter().map(|(name, spread)| format!("{name} {}", number(spread.mean))).collect();
    writeln!(out, "stages     {} ms", stages.join(", "))?;
    if summary.emitted + summary.held + summary.removed + summary.brought_back > 0 {
        writeln!(
            out,
            "counts     {} particles emitted, {} held back, {} left the domain, {} pushed out of bodies",
            thousands(summary.emitted),
            thousands(summary.held),
            thousands(summary.removed),
            thousands(summary.brought_back)
        )?;
    }
    for note in &summary.notes {
        writeln!(out, "note       {note}")?;
    }
    writeln!(out, "folder     {}", folder.display())?;
    Ok(())
}
