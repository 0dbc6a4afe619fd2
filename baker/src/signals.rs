//! Ctrl-C, and the signals that end programs.

use anyhow::{Context, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use volmap_bake::watch::Cancel;

/// Exit code of a command that was stopped, as shells have it after Ctrl-C.
pub const STOPPED: u8 = 130;

/// The first signal asks for the work to stop, which then leaves nothing half-written; the second ends the program at
/// once. To be called once, by commands that work long: others end at the first, as programs do.
pub fn cancel_on_signals() -> Result<Cancel> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first signal finds the flag unset.
        flag::register_conditional_shutdown(signal, STOPPED.into(), stop.clone()).context("Ctrl-C")?;
        flag::register(signal, stop.clone()).context("Ctrl-C")?;
    }
    Ok(stop.into())
}

/// Whether a command ended because it was asked to.
pub fn is_cancelled(error: &anyhow::Error) -> bool {
    let bake = error.downcast_ref::<volmap_bake::Error>().is_some_and(volmap_bake::Error::is_cancelled);
    let report = error.downcast_ref::<volmap_report::Error>().is_some_and(volmap_report::Error::is_cancelled);
    let batch = error.downcast_ref::<volmap_batch::Error>().is_some_and(volmap_batch::Error::is_cancelled);
    bake || report || batch || error.is::<volmap_bake::watch::Cancelled>()
}
