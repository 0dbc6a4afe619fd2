//! What can go wrong in a simulation.

use std::path::PathBuf;

/// Why a simulation can't begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The scene can't be used as it is.
    #[error("{place}: {reason}")]
    Scene {
        /// File, line and column, or the key.
        place: String,
        /// What is wrong and the cure.
        reason: String,
    },
    /// A mesh can't be read or baked.
    #[error(transparent)]
    Bake(#[from] volmap_baker::Error),
    /// A scene, a mesh of a body or particles can't be written.
    #[error(transparent)]
    Export(#[from] volmap_formats::export::ExportError),
    /// A volume map can't be opened.
    #[error(transparent)]
    Map(#[from] volmap_runtime::Error),
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
    /// A check-point can't be used.
    #[error("{}: {reason}", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong and the cure.
        reason: String,
    },
}
