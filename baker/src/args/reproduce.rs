//! Arguments of `volmap reproduce`.

use super::threads;
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;
use volmap_report::reproduce::Experiment;

#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// Experiments to run: duck, plane, dragon, density [default: all]
    #[arg(value_name = "EXPERIMENT", value_parser = Experiment::from_str)]
    experiments: Vec<Experiment>,
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

impl ReproduceArguments {
    /// Which experiments, each once, in the paper's order.
    pub fn experiments(&self) -> Vec<Experiment> {
        let wanted = |one: &Experiment| self.experiments.is_empty() || self.experiments.contains(one);
        Experiment::ALL.into_iter().filter(wanted).collect()
    }
}
