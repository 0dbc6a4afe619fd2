//! Arguments of `volmap-sim`.

use clap::{Parser, Subcommand};
use std::path::PathBuf;

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
    Check(SceneArguments),
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
    /// Number of threads; results don't depend on it [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, clap::Args)]
pub struct SceneArguments {
    /// Scene file, .toml or .json
    pub scene: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
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
    /// Folder for charts (.png) and results (validation.json or reproduction.json); created if missing
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Exit with code 1 if a target is not met
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
