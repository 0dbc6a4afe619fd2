//! `volmap-sim schema`.

use anyhow::Result;
use std::io::{self, Write};
use volmap_scenes::scene::Scene;

/// Prints the JSON Schema of scenes.
pub fn run_schema() -> Result<()> {
    Ok(writeln!(io::stdout().lock(), "{:#}", Scene::schema())?)
}
