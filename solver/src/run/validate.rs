//! `volmap-sim validate`.

use crate::args::ValidateArguments;
use anyhow::{Context, Result, bail};
use serde_json::json;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;
use volmap_solver::validation::{EXPERIMENTS, Experiment, Outcome, Run, table};

/// Runs experiments, prints their figures beside what they should be, and writes the charts.
pub fn run_validate(arguments: &ValidateArguments) -> Result<()> {
    if arguments.list {
        return list();
    }
    let chosen = chosen(&arguments.names)?;
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
            write(folder, &outcomes, arguments.short)?;
        }
    }
    let unmet: usize = outcomes.iter().map(|(_, outcome)| outcome.unmet().count()).sum();
    if arguments.strict && unmet > 0 {
        bail!("{unmet} targets are not met");
    }
    Ok(())
}

fn list() -> Result<()> {
    let mut out = io::stdout().lock();
    for Experiment { name, title, about, .. } in EXPERIMENTS {
        writeln!(out, "{name:12} {title}\n{:12} {about}", "")?;
    }
    Ok(())
}

/// Each once, in the order of all.
fn chosen(names: &[String]) -> Result<Vec<&'static Experiment>> {
    if let Some(unknown) = names.iter().find(|name| Experiment::named(name).is_none()) {
        let known: Vec<&str> = EXPERIMENTS.iter().map(|experiment| experiment.name).collect();
        bail!("`{unknown}` is no experiment; there are {}", known.join(", "));
    }
    let wanted = |one: &&Experiment| names.is_empty() || names.iter().any(|name| name == one.name);
    Ok(EXPERIMENTS.iter().filter(wanted).collect())
}

fn write(folder: &Path, outcomes: &[(&Experiment, Outcome)], short: bool) -> Result<()> {
    for (_, outcome) in outcomes {
        for chart in &outcome.charts {
            let path = folder.join(&chart.file);
            fs::write(&path, chart.chart.to_png()).with_context(|| path.display().to_string())?;
        }
    }
    let entry = |(experiment, outcome): &(&Experiment, Outcome)| json!({ "name": experiment.name, "title": experiment.title, "outcome": outcome });
    let all: Vec<_> = outcomes.iter().map(entry).collect();
    let text = format!(
        "{:#}\n",
        json!({ "version": env!("CARGO_PKG_VERSION"), "short": short, "experiments": all })
    );
    let path = folder.join("validation.json");
    fs::write(&path, text).with_context(|| path.display().to_string())
}
