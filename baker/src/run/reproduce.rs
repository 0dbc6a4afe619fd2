//! `volmap reproduce`.

use crate::args::reproduce::ReproduceArguments;
use crate::options::with_options;
use crate::progress::Progress;
use anyhow::{Error, Result, bail};
use std::io::{self, Write};
use volmap_bake::input::{self, InputSettings};
use volmap_formats::text::duration;
use volmap_memory::start_threads;
use volmap_report::experiments::{choose, list, table, to_json};
use volmap_report::reproduce::{EXPERIMENTS, ReproduceSettings};

/// Runs experiments and prints their figures beside the paper's.
pub fn run_reproduce(arguments: &ReproduceArguments) -> Result<()> {
    if arguments.list {
        return Ok(write!(io::stdout().lock(), "{}", list(EXPERIMENTS))?);
    }
    let chosen = choose(EXPERIMENTS, &arguments.experiments).map_err(Error::msg)?;
    start_threads(arguments.threads)?;
    let mut settings = ReproduceSettings::default();
    if let Some(path) = &arguments.dragon {
        if !chosen.iter().any(|experiment| experiment.name == "dragon") {
            bail!("--dragon: is for the experiment dragon, which isn't asked for");
        }
        settings.dragon.mesh = Some(input::load(path, &InputSettings::default())?);
    }
    let mut progress = Progress::new(arguments.quiet)?;
    let watch = progress.watch();
    let mut finished = Vec::new();
    for experiment in chosen {
        finished.push(experiment.finish(|run| run(&settings, &watch))?);
    }
    progress.finish();
    let mut out = io::stdout().lock();
    if arguments.json {
        return Ok(writeln!(out, "{:#}", to_json(env!("CARGO_PKG_VERSION"), false, &finished))?);
    }
    for one in &finished {
        let (name, time) = (format!("{}: {}", one.name, one.title), duration(one.seconds));
        writeln!(out, "{}  {time}\n", with_options(&table::to_text(&name, &one.outcome)))?;
    }
    Ok(())
}
