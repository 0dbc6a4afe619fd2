//! What can go wrong with files of other programs. The text is complete in itself; `source()` repeats nothing of it.

use std::path::{Path, PathBuf};

/// Why a file can't be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file named has the problem named.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The problem.
        error: Box<ExportError>,
    },
    /// The system refused.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// HDF5 that can't be written.
    #[error("HDF5: {0}")]
    Container(String),
    /// Not Discregrid's dump, or damaged.
    #[error("not a Discregrid map (.cdm), or damaged: {0}")]
    NotDiscregrid(String),
}

impl ExportError {
    pub(super) fn in_file(self, path: &Path) -> ExportError {
        ExportError::InFile { path: path.to_owned(), error: Box::new(self) }
    }
}
