//! Many meshes to many assets, again and again: what changed is baked, what didn't isn't.
//!
//! ```text
//! manifest -> assets (globs, effective parameters) -> state (content keys) -> queue -> worker pool
//!          -> make (bake, gates, preview, report) -> summary -> page, junit
//! ```
//!
//! # Tour
//!
//! - [`manifest`] reads a manifest, [`assets::expand`] finds its meshes and what holds for each.
//! - [`engine::run`] runs a batch, [`check::check`] says what it would do, [`verify::verify`] whether a folder is up to
//!   date.
//! - Inside, [`state`] decides what to do with each asset by its content key; [`queue`] hands out jobs, the longest
//!   first, within threads and memory; [`pool`] runs them in worker processes, which are the program itself with the
//!   argument [`process::WORKER`] and call [`worker::run`].
//! - [`summary::Summary`] is the result: [`publish::publish`] writes it as JSON, as an HTML page and for build servers.
//!
//! ```
//! use volmap_batch::assets::expand;
//! use volmap_batch::manifest::from_patterns;
//! use volmap_bake::parameters::Parameters;
//!
//! # let folder = tempfile::tempdir().unwrap();
//! std::fs::write(folder.path().join("duck.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
//! let manifest = from_patterns(&["*.obj".to_owned()], None, &Parameters::default());
//! let found = expand(&manifest, folder.path()).unwrap();
//! assert_eq!((found.assets.len(), found.assets[0].name.as_str()), (1, "duck"));
//! ```
//!
//! # Guarantees
//!
//! An asset appears whole, after all that belongs to it, or not at all: a batch that was killed goes on with what is
//! missing. A crash, a timeout or too much memory fails one asset only. Bytes of assets don't depend on jobs, threads
//! or shards. Files that no batch made are left alone.
//!
//! Not guaranteed: estimates of time and memory, which are right to a factor of 2 or so.

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
pub mod left_out;
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
