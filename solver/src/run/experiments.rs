//! `volmap-sim validate` and `volmap-sim reproduce`.

use super::{set_threads, tell};
use crate::args::ExperimentArguments;
use crate::signals;
use anyhow::{Context, Error, Result, bail};
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use volmap_experiments::validation::{Experiment, Run};
use volmap_formats::text::duration;
use volmap_report::experiments::{Finished, choose, list, table, to_json};

/// The experiments of a command.
pub struct ExperimentSet {
    /// All of them, in the order in which they run.
    pub experiments: &'static [Experiment],
    /// File name of their results.
    pub results: &'static str,
}

/// Runs experiments, prints their results beside the targets, and writes charts and results.
pub fn run_experiments(set: &ExperimentSet, arguments: &ExperimentArguments) -> Result<()> {
    if arguments.list {
        return Ok(write!(io::stdout().lock(), "{}", list(set.experiments))?);
    }
    let chosen = choose(set.experiments, &arguments.names).map_err(Error::msg)?;
    set_threads(arguments.threads)?;
    if let Some(folder) = &arguments.output {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let progress = |text: &str| {
        if !arguments.quiet {
            tell(format_args!("{text}"));
        }
    };
    let watch = signals::watch()?;
    let run = Run { short: arguments.short, watch: &watch, progress: &progress };
    let mut finished: Vec<Finished> = Vec::new();
    for experiment in chosen {
        progress(&format!("{}: {}", experiment.name, experiment.title));
        let one = experiment.finish(|simulate| simulate(&run))?;
        let mut out = io::stdout().lock();
        writeln!(out, "{}  {}\n", table::to_text(one.name, &one.outcome), duration(one.seconds))?;
        out.flush()?;
        finished.push(one);
        if let Some(folder) = &arguments.output {
            // After each one: all of them take long.
            write_results(&folder.join(set.results), &finished, arguments.short)?;
        }
    }
    let unmet: usize = finished.iter().map(|one| one.outcome.unmet().count()).sum();
    if arguments.strict && unmet > 0 {
        bail!("{unmet} targets are not met");
    }
    Ok(())
}

fn write_results(path: &Path, finished: &[Finished], short: bool) -> Result<()> {
    for chart in finished.iter().flat_map(|one| &one.outcome.charts) {
        let path = path.with_file_name(&chart.file);
        fs::write(&path, chart.chart.to_png()).with_context(|| path.display().to_string())?;
    }
    let text = format!("{:#}\n", to_json(env!("CARGO_PKG_VERSION"), short, finished));
    fs::write(path, text).with_context(|| path.display().to_string())
}
