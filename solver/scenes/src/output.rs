//! What a simulation leaves: frames, statistics, pictures, checkpoints.
//!
//! ```text
//! Frame -> particles/frame_000123.vtu, .ply, .bgeo   particles.pvd   frames.csv   poses.csv, poses.json
//!       -> pictures/frame_000123.png                 animation.png
//! StepStatistics -> stats.csv, stats.json            bodies/00_duck.ply            checkpoint
//! ```
//! [`folder::Output`] writes all of them. Each file but the tables appears whole or not at all. Tables grow by whole
//! rows, and a run that resumes from a checkpoint cuts them after the last row that the checkpoint knows of; what it
//! removes or misses, it says. One run at a time writes into a folder: [`lock`].

pub mod animation;
pub mod bodies;
pub mod checkpoint;
pub mod folder;
pub mod frame;
pub mod lock;
mod notes;
pub mod particles;
pub mod picture;
pub mod poses;
pub mod statistics;
pub mod table;

pub use checkpoint::{Checkpoint, CheckpointWriter};
pub use folder::{FolderSettings, Output};
pub use frame::{BodyFrame, Frame};
pub use statistics::{EmitterSummary, RunSummary, StepStatistics};

use crate::error::Error;
use std::path::Path;
use volmap_formats::asset;

/// Makes a file of these bytes, whole or not at all.
fn publish(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    asset::publish(path, bytes).map_err(|error| volmap_bake::Error::from(error).into())
}

/// What the system says of a file.
pub(crate) fn io_error(path: &Path) -> impl Fn(std::io::Error) -> Error + '_ {
    |source| Error::Io { path: path.to_owned(), source }
}
