//! Arguments of `volmap-sim`.

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use volmap_bake::parameters::ByteSize;

/// Simulate incompressible fluids with volume maps as boundaries
#[derive(Debug, Parser)]
#[command(name = "volmap-sim", version, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a scene; writes frames, statistics, pictures and checkpoints into a folder
    Run(RunArguments),
    /// Show the contents of a scene; opens no map and bakes nothing
    Info(SceneArguments),
    /// Check that a scene can run: opens or bakes its maps and places its particles
    Check(CheckArguments),
    /// Write a scene to start from, with comments
    New(NewArguments),
    /// Print the JSON Schema of scene files
    Schema,
    /// Run validation cases and compare with targets
    Validate(ExperimentArguments),
    /// Reproduce experiments of the papers and compare with their figures
    Reproduce(ExperimentArguments),
}

#[derive(Debug, clap::Args)]
pub struct RunArguments {
    /// Scene file, .toml or .json
    pub scene: PathBuf,
    /// Folder for the results; created if missing
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Stop after this many steps, counted from the beginning of the scene
    #[arg(long, value_name = "N")]
    pub steps: Option<u64>,
    /// Stop at this simulated time, in seconds [default: stop.time of the scene]
    #[arg(long, value_name = "T", value_parser = time)]
    pub until: Option<f64>,
    /// Continue from the checkpoint in the folder
    #[arg(long, conflicts_with = "overwrite")]
    pub resume: bool,
    /// Replace the run in the folder
    #[arg(long)]
    pub overwrite: bool,
    /// Refuse runs that need more, as 4GiB or 500MB; bakes that need more, too [default: no limit; bakes 4GiB]
    #[arg(long, value_name = "BYTES")]
    pub max_memory: Option<ByteSize>,
    /// Number of threads; results don't depend on it [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, clap::Args)]
pub struct NewArguments {
    /// Where the scene goes; a file that is there stays
    #[arg(default_value = "scene.toml")]
    pub file: PathBuf,
    /// What is in the scene
    #[arg(long, value_enum, default_value_t)]
    pub template: Template,
}

/// Scenes to start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Template {
    /// Water in a tank, and a ball that floats in it
    #[default]
    Tank,
    /// A jet of water on a box that stands on a plane
    Jet,
}

#[derive(Debug, clap::Args)]
pub struct SceneArguments {
    /// Scene file, .toml or .json
    pub scene: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Refuse a scene whose run would need more, as `run` does [default: no limit; bakes 4GiB]
    #[arg(long, value_name = "BYTES")]
    pub max_memory: Option<ByteSize>,
}

fn time(text: &str) -> Result<f64, String> {
    let time: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if time.is_finite() && time >= 0.0 { Ok(time) } else { Err("negative or not finite".to_owned()) }
}

#[derive(Debug, clap::Args)]
pub struct ExperimentArguments {
    /// Experiments to run [default: all]
    #[arg(value_name = "EXPERIMENT")]
    pub names: Vec<String>,
    /// List the experiments and exit
    #[arg(long)]
    pub list: bool,
    /// Run fewer, coarser and shorter cases: about ten seconds per experiment
    #[arg(long)]
    pub short: bool,
    /// Folder for charts (.png) and results (validation.json or reproduction.json, which keeps those of earlier runs);
    /// created if missing
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Exit with code 1 if a target is not met; `validate` always does
    #[arg(long)]
    pub strict: bool,
    /// Number of threads; results don't depend on it [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print no progress
    #[arg(short, long)]
    pub quiet: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn definition_is_sound() {
        Arguments::command().debug_assert();
    }
}
