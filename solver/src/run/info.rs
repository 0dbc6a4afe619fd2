//! `volmap-sim info`.

use crate::args::SceneArguments;
use anyhow::Result;
use std::io::{self, Write};
use volmap_scenes::scene::{self, SceneSummary};

/// Shows the contents of a scene.
pub fn run_info(arguments: &SceneArguments) -> Result<()> {
    print(&scene::info(&arguments.scene)?, arguments.json)
}

/// Prints a summary on standard output.
pub fn print(summary: &SceneSummary, json: bool) -> Result<()> {
    let mut out = io::stdout().lock();
    match json {
        true => writeln!(out, "{}", serde_json::to_string_pretty(summary)?)?,
        false => writeln!(out, "{summary}")?,
    }
    Ok(())
}
