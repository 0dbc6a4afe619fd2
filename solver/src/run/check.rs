//! `volmap-sim check`.

use super::baking;
use super::info::print;
use crate::args::SceneArguments;
use anyhow::Result;
use volmap_scenes::scene;

/// Checks that a scene can run.
pub fn run_check(arguments: &SceneArguments) -> Result<()> {
    print(&scene::check(&arguments.scene, &mut |mesh| baking(mesh, false))?, arguments.json)
}
