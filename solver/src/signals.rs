//! Ctrl-C, and the signals that end programs.

use anyhow::{Context, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use volmap_bake::watch::Watch;

/// Exit code of a command that was stopped before it had a result, as shells have it after Ctrl-C.
pub const STOPPED: u8 = 130;

/// The first signal asks the work to stop: a run then ends after its step, with a checkpoint. The second ends the
/// program at once. To be called once, by commands that may take long.
pub fn watch() -> Result<Watch> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first signal finds the flag unset.
        flag::register_conditional_shutdown(signal, STOPPED.into(), stop.clone()).context("Ctrl-C")?;
        flag::register(signal, stop.clone()).context("Ctrl-C")?;
    }
    Ok(Watch::default().stopped_by(&stop.into()))
}
