//! What can go wrong when a map is opened; nothing can afterwards.

use std::path::PathBuf;
use volmap_formats::asset::AssetError;

/// Why a map can't be opened. The text says it all: it is not in `source` again.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file isn't a sound asset.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// The asset can't be a map: its nodes aren't those of its cells.
    #[error("`{what}` {reason}; bake the asset again")]
    Inconsistent {
        /// Path of the dataset.
        what: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// The file named has the problem named.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The problem.
        error: Box<Error>,
    },
}

impl Error {
    pub(crate) fn inconsistent(what: &'static str, reason: impl Into<String>) -> Error {
        Error::Inconsistent { what, reason: reason.into() }
    }
}
