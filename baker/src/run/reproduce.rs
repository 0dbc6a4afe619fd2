//! `volmap reproduce`.

use crate::args::reproduce::ReproduceArguments;
use crate::progress::Progress;
use anyhow::{Result, bail};
use serde_json::json;
use std::io::{self, Write};
use volmap_bake::input::{self, InputSettings};
use volmap_report::reproduce::{Experiment, Settings, reproduce, table};

/// Runs experiments and prints their figures beside the paper's.
pub fn run_reproduce(arguments: &ReproduceArguments) -> Result<()> {
    if arguments.list {
        let mut out = io::stdout().lock();
        for experiment in Experiment::ALL {
            writeln!(out, "{:10} {}", experiment.name(), experiment.describe())?;
        }
        return Ok(());
    }
    let experiments = arguments.experiments();
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    let mut settings = Settings::default();
    if let Some(path) = &arguments.dragon {
        if !experiments.contains(&Experiment::Dragon) {
            bail!("--dragon: is for the experiment dragon, which isn't asked for");
        }
        settings.dragon.mesh = Some(input::load(path, &InputSettings::default())?);
    }
    let mut progress = Progress::new(arguments.quiet);
    let mut outcomes = Vec::new();
    for experiment in experiments {
        outcomes.push(reproduce(experiment, &settings, &mut |step| progress.reproduce(step))?);
    }
    progress.finish();
    let mut out = io::stdout().lock();
    match arguments.json {
        true => writeln!(out, "{:#}", json!({ "outcomes": outcomes, "version": env!("CARGO_PKG_VERSION") }))?,
        false => write!(out, "{}", table::to_text(&outcomes))?,
    }
    Ok(())
}
