//! The commands of `volmap-sim`.

pub mod check;
pub mod experiments;
pub mod info;
pub mod new;
mod progress;
pub mod schema;
pub mod simulate;

use anyhow::Result;
use std::path::Path;

/// Announces a bake.
fn baking(mesh: &Path, quiet: bool) {
    if !quiet {
        eprintln!("baking     {} (first use)", mesh.display());
    }
}

/// Starts so many threads; one for each processor without a number.
fn set_threads(threads: Option<u16>) -> Result<()> {
    Ok(volmap_memory::start_threads(threads.map(usize::from))?)
}
