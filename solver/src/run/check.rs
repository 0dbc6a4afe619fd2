//! `volmap-sim check`.

use super::info::print;
use super::{baking, set_threads};
use crate::args::SceneArguments;
use crate::signals;
use anyhow::Result;
use volmap_scenes::plan;

/// Checks that a scene can run.
pub fn run_check(arguments: &SceneArguments) -> Result<()> {
    set_threads(None)?;
    let summary = plan::check(&arguments.scene, &signals::watch()?, &mut |mesh| baking(mesh, false))?;
    print(&summary, arguments.json)
}
