//! What can go wrong when a map is opened; nothing can afterwards.

use std::path::PathBuf;
use volmap_formats::asset::AssetError;

/// Why a map can't be opened.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file isn't a sound asset.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// The asset contradicts itself.
    #[error("`{what}` {reason}; bake the asset again")]
    Inconsistent {
        /// Path of the dataset.
        what: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// The file named has the problem named.
    #[error("{}: {source}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The problem.
        source: Box<Error>,
    },
}

impl Error {
    pub(crate) fn inconsistent(what: &'static str, reason: impl Into<String>) -> Error {
        Error::Inconsistent { what, reason: reason.into() }
    }
}
