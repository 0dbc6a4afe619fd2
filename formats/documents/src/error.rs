//! What can be wrong with a document.

use std::path::PathBuf;

/// Why a document can't be used.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system refused to read it.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It can't be used as it is.
    #[error("{place}: {reason}")]
    Content {
        /// File, line and column.
        place: String,
        /// What is wrong and the cure.
        reason: String,
    },
}
