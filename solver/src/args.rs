//! Arguments of `volmap-sim`.

use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Simulates incompressible fluids with volume maps as boundaries
#[derive(Debug, Parser)]
#[command(name = "volmap-sim", version, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulates a scene into a folder: frames, statistics, pictures, check-points
    Run(RunArguments),
    /// What is in a scene; opens no map and bakes nothing
    Info(SceneArguments),
    /// Whether a scene can run: opens or bakes its maps, places its particles
    Check(SceneArguments),
    /// The JSON Schema of scenes
    Schema,
    /// Experiments whose answer is known, and what comes of them here
    Validate(ExperimentArguments),
    /// Experiments of the papers, and what comes of them here
    Reproduce(ExperimentArguments),
}

#[derive(Debug, clap::Args)]
pub struct RunArguments {
    /// Scene, a .toml or .json file
    pub scene: PathBuf,
    /// Folder of the results; made if it isn't there
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Stop after this many steps in all
    #[arg(long, value_name = "N")]
    pub steps: Option<u64>,
    /// Stop at this time, seconds, instead of the scene's
    #[arg(long, value_name = "T", value_parser = time)]
    pub until: Option<f64>,
    /// Go on from the folder's check-point
    #[arg(long, conflicts_with = "overwrite")]
    pub resume: bool,
    /// Replace the run that is in the folder
    #[arg(long)]
    pub overwrite: bool,
    /// Threads; all processors by default. Results don't depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, clap::Args)]
pub struct SceneArguments {
    /// Scene, a .toml or .json file
    pub scene: PathBuf,
    /// As JSON
    #[arg(long)]
    pub json: bool,
}

fn time(text: &str) -> Result<f64, String> {
    let time: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if time.is_finite() && time >= 0.0 { Ok(time) } else { Err("not a time".to_owned()) }
}

#[derive(Debug, clap::Args)]
pub struct ExperimentArguments {
    /// Which experiments; `all`, and by default
    #[arg(value_name = "EXPERIMENT")]
    pub names: Vec<String>,
    /// Print which there are, and end
    #[arg(long)]
    pub list: bool,
    /// Fewer cases, coarser and shorter: some ten seconds each
    #[arg(long)]
    pub short: bool,
    /// Folder for charts (.png) and all figures (validation.json, reproduction.json); made if it isn't there
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Exit code 1 if a target isn't met
    #[arg(long)]
    pub strict: bool,
    /// Threads; all processors by default. Results don't depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// No progress
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
