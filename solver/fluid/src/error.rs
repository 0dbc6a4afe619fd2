//! What can go wrong in a simulation.

use volmap_bake::watch::Cancelled;

/// Why a simulation can't begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// What it would begin with can't be used.
    #[error("{place}: {reason}")]
    Setup {
        /// What of it.
        place: String,
        /// What is wrong and the cure.
        reason: String,
    },
    /// A mesh can't be baked.
    #[error(transparent)]
    Bake(#[from] volmap_bake::Error),
    /// A volume map can't be opened.
    #[error(transparent)]
    Map(#[from] volmap_runtime::Error),
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The simulation stopped, because what it computes is no fluid any more.
    #[error("step {step}, t = {time:.5} s: {reason}")]
    Simulation {
        /// Steps done.
        step: u64,
        /// Time simulated, seconds.
        time: f64,
        /// What happened and the cure.
        reason: String,
    },
}

impl Error {
    /// Whether the work ended because it was asked to.
    pub fn is_cancelled(&self) -> bool {
        match self {
            Error::Cancelled(_) => true,
            Error::Bake(error) => error.is_cancelled(),
            _ => false,
        }
    }
}
