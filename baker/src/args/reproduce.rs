//! Arguments of `volmap reproduce`.

use super::threads;
use clap::Args;
use std::path::PathBuf;
use volmap_report::experiments::choose;
use volmap_report::reproduce::EXPERIMENTS;

#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// Experiments to run: duck, plane, dragon, density [default: all]
    #[arg(value_name = "EXPERIMENT", value_parser = experiment)]
    pub experiments: Vec<String>,
    /// List the experiments and exit
    #[arg(long)]
    pub list: bool,
    /// The dragon's mesh, which comes with SPlisHSPlasH (data/models/Dragon_50k.obj); metres
    #[arg(long, value_name = "FILE")]
    pub dragon: Option<PathBuf>,
    /// As JSON
    #[arg(long)]
    pub json: bool,
    /// Threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// No progress
    #[arg(short, long)]
    pub quiet: bool,
}

/// A name that there is.
fn experiment(text: &str) -> Result<String, String> {
    let name = text.to_owned();
    choose(EXPERIMENTS, std::slice::from_ref(&name))?;
    Ok(name)
}
