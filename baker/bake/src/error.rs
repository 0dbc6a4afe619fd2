//! What can go wrong in a bake.

use crate::watch::Cancelled;
use std::path::PathBuf;
use volmap_formats::asset::AssetError;
use volmap_formats::mesh::MeshError;

/// Why a bake ended without an asset.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The mesh file can't be used.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The mesh in this file can't be used.
    #[error("{}: {source}", path.display())]
    MeshFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: MeshError,
    },
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The asset can't be written or read.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// The asset can't be opened.
    #[error(transparent)]
    Map(#[from] volmap_runtime::Error),
    /// A file or a folder can't be used as it is.
    #[error("{}: {reason}", path.display())]
    Unusable {
        /// Which.
        path: PathBuf,
        /// What is wrong with it and the cure.
        reason: String,
    },
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A parameter can't be used.
    #[error("{parameter}: {reason}")]
    Setting {
        /// Its name: a key of manifests; the command line's option with `_` for `-`.
        parameter: &'static str,
        /// What is wrong with it and the cure.
        reason: String,
    },
    /// The bake would need more memory than allowed.
    #[error(
        "the bake would need about {} MiB, more than the {} MiB that it may take (`max_memory`); take larger cells \
         (`cell_size`, `resolution`), larger particles, or allow more",
        needed >> 20, allowed >> 20
    )]
    Memory {
        /// Estimate, bytes.
        needed: u64,
        /// Limit, bytes.
        allowed: u64,
    },
    /// A bake isn't possible, and the mesh's length has to do with it.
    #[error("{about}: {reason}")]
    Sized {
        /// The length, and the unit that is more likely.
        about: String,
        /// What isn't possible.
        reason: Box<Error>,
    },
}

impl Error {
    /// Whether the work ended because it was asked to.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Error::Cancelled(_))
    }

    /// A parameter that can't be used. Names of other parameters stand in backquotes in the reason.
    pub fn setting(parameter: &'static str, reason: impl Into<String>) -> Error {
        Error::Setting { parameter, reason: reason.into() }
    }
}
