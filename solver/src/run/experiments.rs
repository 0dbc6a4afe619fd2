//! `volmap-sim validate` and `volmap-sim reproduce`.

use crate::args::ExperimentArguments;
use anyhow::{Context, Error, Result, bail};
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use volmap_experiments::validation::{Experiment, Run};
use volmap_formats::text::duration;
use volmap_report::experiments::{Finished, choose, list, table, to_json};

/// Runs experiments, prints their figures beside what they should be, and writes the charts and `file`, the figures.
pub fn run_experiments(
    experiments: &'static [Experiment],
    file: &str,
    arguments: &ExperimentArguments,
) -> Result<()> {
    if arguments.list {
        return Ok(write!(io::stdout().lock(), "{}", list(experiments))?);
    }
    let chosen = choose(experiments, &arguments.names).map_err(Error::msg)?;
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    if let Some(folder) = &arguments.output {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let progress = |text: &str| {
        if !arguments.quiet {
            eprintln!("{text}");
        }
    };
    let run = Run { short: arguments.short, folder: arguments.output.clone(), progress: &progress };
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
            write(&folder.join(file), &finished, arguments.short)?;
        }
    }
    let unmet: usize = finished.iter().map(|one| one.outcome.unmet().count()).sum();
    if arguments.strict && unmet > 0 {
        bail!("{unmet} targets are not met");
    }
    Ok(())
}

fn write(figures: &Path, finished: &[Finished], short: bool) -> Result<()> {
    for chart in finished.iter().flat_map(|one| &one.outcome.charts) {
        let path = figures.with_file_name(&chart.file);
        fs::write(&path, chart.chart.to_png()).with_context(|| path.display().to_string())?;
    }
    let text = format!("{:#}\n", to_json(env!("CARGO_PKG_VERSION"), short, finished));
    fs::write(figures, text).with_context(|| figures.display().to_string())
}
