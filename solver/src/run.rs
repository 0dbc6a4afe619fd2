//! The commands of `volmap-sim`.

pub mod check;
pub mod experiments;
pub mod info;
pub mod new;
mod progress;
pub mod schema;
pub mod simulate;

use anyhow::Result;
use std::fmt::Arguments;
use std::io::{self, Write};
use std::path::Path;

/// Announces a bake.
fn baking(mesh: &Path, quiet: bool) {
    if !quiet {
        tell(format_args!("baking     {} (first use)", mesh.display()));
    }
}

/// A line on standard error. Its reader may have closed it, as `head` does: the run goes on.
pub fn tell(line: Arguments) {
    _ = writeln!(io::stderr().lock(), "{line}");
}

/// Starts so many threads; one for each processor without a number.
fn set_threads(threads: Option<u16>) -> Result<()> {
    Ok(volmap_memory::start_threads(threads.map(usize::from))?)
}
