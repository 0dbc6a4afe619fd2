//! What can go wrong with a scene or its run.

use std::path::PathBuf;
use volmap_bake::watch::Cancelled;

/// Why a scene can't be run, or a run can't go on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or folder can't be read or written.
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
    Bake(#[from] volmap_bake::Error),
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A volume map can't be opened.
    #[error(transparent)]
    Map(#[from] volmap_runtime::Error),
    /// A mesh of a body or particles can't be written.
    #[error(transparent)]
    Export(#[from] volmap_formats::export::ExportError),
    /// The simulation can't begin or go on.
    #[error(transparent)]
    Simulation(#[from] volmap_fluid::Error),
    /// The folder holds a run, and [`RunSettings::begin`](crate::session::RunSettings::begin) is
    /// [`New`](crate::session::Begin::New).
    #[error("{}: has a run already", folder.display())]
    RunExists {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder holds no checkpoint to resume from.
    #[error("{}: has no checkpoint to resume from", folder.display())]
    NoCheckpoint {
        /// The folder.
        folder: PathBuf,
    },
    /// Another run is at work in the folder.
    #[error(
        "{}: another run is at work in this folder; wait for it, stop it, or take another folder", folder.display()
    )]
    RunActive {
        /// The folder.
        folder: PathBuf,
    },
    /// A checkpoint can't be used.
    #[error("{}: {reason}", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong and the cure.
        reason: String,
    },
}

impl Error {
    /// Whether the work ended because it was asked to.
    pub fn is_cancelled(&self) -> bool {
        match self {
            Error::Cancelled(_) => true,
            Error::Bake(error) => error.is_cancelled(),
            Error::Simulation(error) => error.is_cancelled(),
            _ => false,
        }
    }
}
