//! What can go wrong with a batch.

use std::path::Path;
use volmap_bake::watch::Cancelled;
use volmap_formats::asset::AssetError;

/// Why a batch ended.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A mesh, an asset, a file or a setting can't be used.
    #[error(transparent)]
    Bake(#[from] volmap_bake::Error),
    /// An asset can't be measured.
    #[error(transparent)]
    Report(#[from] volmap_report::Error),
    /// A manifest or a summary can't be used as it is.
    #[error(transparent)]
    Document(#[from] volmap_documents::Error),
}

impl From<AssetError> for Error {
    fn from(error: AssetError) -> Error {
        volmap_bake::Error::from(error).into()
    }
}

impl From<volmap_runtime::Error> for Error {
    fn from(error: volmap_runtime::Error) -> Error {
        volmap_bake::Error::from(error).into()
    }
}

impl From<Cancelled> for Error {
    fn from(error: Cancelled) -> Error {
        volmap_bake::Error::from(error).into()
    }
}

impl Error {
    /// Whether the work ended because it was asked to.
    pub fn is_cancelled(&self) -> bool {
        match self {
            Error::Bake(error) => error.is_cancelled(),
            Error::Report(error) => error.is_cancelled(),
            Error::Document(_) => false,
        }
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
