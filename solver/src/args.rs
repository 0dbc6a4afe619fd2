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
    /// What is in a scene; opens no map and bakes nothing
    Info(SceneArguments),
    /// Whether a scene can run: opens or bakes its maps, places its particles
    Check(SceneArguments),
    /// The JSON Schema of scenes
    Schema,
}

#[derive(Debug, clap::Args)]
pub struct SceneArguments {
    /// Scene, a .toml or .json file
    pub scene: PathBuf,
    /// As JSON
    #[arg(long)]
    pub json: bool,
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
