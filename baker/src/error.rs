//! What can go wrong in a bake.

use volmap_formats::asset::AssetError;

/// Why a bake ended without an asset.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The asset can't be written or read.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// A setting can't be used.
    #[error("{option}: {reason}")]
    Setting {
        /// The command line's name of the setting.
        option: &'static str,
        /// What is wrong with it and the cure.
        reason: String,
    },
    /// The bake would need more memory than allowed.
    #[error(
        "the bake would need about {} MiB, more than --max-memory {} MiB; take larger cells \
         (--cell-size, --resolution) or allow more",
        needed >> 20, allowed >> 20
    )]
    Memory {
        /// Estimate, bytes.
        needed: u64,
        /// Limit, bytes.
        allowed: u64,
    },
    /// The user stopped it.
    #[error("stopped; nothing was written")]
    Cancelled,
}

impl Error {
    pub(crate) fn setting(option: &'static str, reason: impl Into<String>) -> Error {
        Error::Setting { option, reason: reason.into() }
    }
}
