//! Many meshes to many assets, again and again: what changed is baked, what didn't isn't.
//!
//! ```text
//! manifest -> assets (globs, effective parameters) -> state (content keys) -> queue -> worker pool
//!          -> make (bake, gates, preview, report) -> summary -> page, junit
//! ```

pub mod asset_report;
pub mod assets;
pub mod check;
pub mod cost;
pub mod engine;
pub mod error;
pub mod estimates;
pub mod figures;
#[cfg(test)]
mod fixture;
pub mod gates;
pub mod item;
pub mod job;
pub mod journal;
pub mod junit;
pub mod log;
pub mod make;
pub mod manifest;
pub mod measure;
pub mod memory;
pub mod merge;
pub mod names;
pub mod page;
pub mod pattern;
pub mod places;
pub mod pool;
pub mod preview;
pub mod process;
pub mod prune;
pub mod publish;
pub mod queue;
pub mod read;
pub mod settings;
pub mod shard;
pub mod state;
pub mod summary;
pub mod threads;
pub mod verify;
pub mod worker;

pub use error::Error;
