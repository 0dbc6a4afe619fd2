//! `volmap-sim check`.

use super::info::print;
use super::{baking, set_threads};
use crate::args::CheckArguments;
use crate::signals;
use anyhow::Result;
use std::path::Path;
use volmap_scenes::plan;

/// Checks that a scene can run.
pub fn run_check(arguments: &CheckArguments) -> Result<()> {
    set_threads(None)?;
    let CheckArguments { scene, max_memory } = arguments;
    let max_memory = max_memory.map(|bytes| bytes.0);
    let on_bake = &mut |mesh: &Path| baking(mesh, false);
    let summary = plan::check(&scene.scene, max_memory, &signals::watch()?, on_bake)?;
    print(&summary, scene.json)
}
