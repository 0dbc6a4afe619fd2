//! What can go wrong with an asset that is looked into.

use std::path::Path;
use volmap_bake::watch::Cancelled;
use volmap_formats::export::ExportError;

/// Why an asset couldn't be measured, drawn or carried over.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A mesh, an asset, a file or a setting can't be used.
    #[error(transparent)]
    Bake(#[from] volmap_bake::Error),
    /// The asset can't be opened.
    #[error(transparent)]
    Map(#[from] volmap_runtime::Error),
    /// A file of another program can't be written or read.
    #[error(transparent)]
    Export(#[from] ExportError),
}

impl From<Cancelled> for Error {
    fn from(error: Cancelled) -> Error {
        volmap_bake::Error::from(error).into()
    }
}

impl Error {
    /// Whether the work ended because it was asked to.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Error::Bake(error) if error.is_cancelled())
    }

    pub(crate) fn setting(parameter: &'static str, reason: impl Into<String>) -> Error {
        volmap_bake::Error::setting(parameter, reason).into()
    }

    pub(crate) fn io(path: impl AsRef<Path>, source: std::io::Error) -> Error {
        volmap_bake::Error::Io { path: path.as_ref().to_owned(), source }.into()
    }

    pub(crate) fn unusable(path: impl AsRef<Path>, reason: impl Into<String>) -> Error {
        volmap_bake::Error::Unusable { path: path.as_ref().to_owned(), reason: reason.into() }.into()
    }
}
