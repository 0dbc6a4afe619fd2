//! The commands of `volmap-sim`.

pub mod check;
pub mod experiments;
pub mod info;
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

/// Sets the number of threads; all processors without one.
fn set_threads(threads: Option<u16>) -> Result<()> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    Ok(())
}
