//! `volmap-sim check`.

use super::info::print;
use crate::args::SceneArguments;
use anyhow::Result;
use std::path::Path;
use volmap_scenes::scene;

/// Tells whether a scene can run.
pub fn run_check(arguments: &SceneArguments) -> Result<()> {
    let mut on_bake = |mesh: &Path| eprintln!("baking     {}, on its first use", mesh.display());
    print(&scene::check(&arguments.scene, &mut on_bake)?, arguments.json)
}
