//! What can be wrong with an asset. As with all errors of this crate, the text is complete in itself (file, reason,
//! cure), and `source()` returns only what the text doesn't say.

use crate::text::quoted;
use std::path::{Path, PathBuf};

/// Why an asset can't be read or written. The text says it all: it is not in `source` again.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    /// The file named has the problem named.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The problem.
        error: Box<AssetError>,
    },
    /// The system refused.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The bytes aren't HDF5 at all.
    #[error("not an HDF5 file; a volume map is one")]
    NotHdf5,
    /// HDF5 that can't be read, or damaged.
    #[error("not readable as HDF5 ({0}); if it was copied, copy it again; else bake it again")]
    Container(String),
    /// HDF5, but not ours.
    #[error("not a volume map: the root attribute `format` is missing or isn't \"volmap\"")]
    NotAnAsset,
    /// Written by a newer program.
    #[error("format version {found} is newer than this program reads (up to {supported}); update volmap")]
    Version {
        /// The file's version.
        found: u64,
        /// The newest version that is read here.
        supported: u64,
    },
    /// A group, attribute or dataset isn't there.
    #[error("`{0}` is missing; bake the asset again")]
    Missing(String),
    /// A value is out of its range.
    #[error("`{what}` {reason}; bake the asset again")]
    Invalid {
        /// Path of the attribute or dataset.
        what: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The content isn't what was written.
    #[error("checksum of `{0}` doesn't match: the file is damaged; copy it again or bake it again")]
    Checksum(String),
}

impl AssetError {
    pub(crate) fn in_file(self, path: &Path) -> AssetError {
        AssetError::InFile { path: path.to_owned(), error: Box::new(self) }
    }

    pub(crate) fn invalid(what: impl Into<String>, reason: impl Into<String>) -> AssetError {
        AssetError::Invalid { what: what.into(), reason: reason.into() }
    }
}

/// Text from a file as it may stand in a message.
pub(super) fn printable(text: &str) -> String {
    quoted(text, 200)
}
