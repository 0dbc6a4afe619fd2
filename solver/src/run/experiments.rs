//! `volmap-sim validate` and `volmap-sim reproduce`.

use crate::args::ExperimentArguments;
use anyhow::{Context, Result, bail};
use serde_json::json;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;
use volmap_experiments::validation::{Experiment, Outcome, Run, table};

/// Experiments, and the file of their figures.
pub type Set = (&'static [Experiment], &'static str);

/// Runs experiments, prints their figures beside what they should be, and writes the charts.
pub fn run_experiments((experiments, file): Set, arguments: &ExperimentArguments) -> Result<()> {
    if arguments.list {
        return list(experiments);
    }
    let chosen = chosen(experiments, &arguments.names)?;
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
    let mut outcomes = Vec::new();
    for experiment in chosen {
        progress(&format!("{}: {}", experiment.name, experiment.title));
        let start = Instant::now();
        let outcome = (experiment.run)(&run)?;
        let text = table::to_text(experiment.name, &outcome);
        let mut out = io::stdout().lock();
        writeln!(out, "{text}  {:.1} s\n", start.elapsed().as_secs_f64())?;
        out.flush()?;
        outcomes.push((experiment, outcome));
        if let Some(folder) = &arguments.output {
            // After each one: all of them take long.
            write(&folder.join(file), &outcomes, arguments.short)?;
        }
    }
    let unmet: usize = outcomes.iter().map(|(_, outcome)| outcome.unmet().count()).sum();
    if arguments.strict && unmet > 0 {
        bail!("{unmet} targets are not met");
    }
    Ok(())
}

fn list(experiments: &[Experiment]) -> Result<()> {
    let mut out = io::stdout().lock();
    for Experiment { name, title, about, .. } in experiments {
        writeln!(out, "{name:12} {title}: {about}")?;
    }
    Ok(())
}

/// Each once, in the order of all.
fn chosen(experiments: &'static [Experiment], names: &[String]) -> Result<Vec<&'static Experiment>> {
    let known = |name: &str| name == ALL || experiments.iter().any(|one| one.name == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        let all: Vec<&str> = experiments.iter().map(|one| one.name).collect();
        bail!("`{unknown}` is no experiment; there are {}", all.join(", "));
    }
    let wanted =
        |one: &&Experiment| names.is_empty() || names.iter().any(|name| name == one.name || name == ALL);
    Ok(experiments.iter().filter(wanted).collect())
}

const ALL: &str = "all";

fn write(figures: &Path, outcomes: &[(&Experiment, Outcome)], short: bool) -> Result<()> {
    for (_, outcome) in outcomes {
        for chart in &outcome.charts {
            let path = figures.with_file_name(&chart.file);
            fs::write(&path, chart.chart.to_png()).with_context(|| path.display().to_string())?;
        }
    }
    let entry = |(experiment, outcome): &(&Experiment, Outcome)| json!({ "name": experiment.name, "title": experiment.title, "outcome": outcome });
    let all: Vec<_> = outcomes.iter().map(entry).collect();
    let text = format!(
        "{:#}\n",
        json!({ "version": env!("CARGO_PKG_VERSION"), "short": short, "experiments": all })
    );
    fs::write(figures, text).with_context(|| figures.display().to_string())
}
