//! Many meshes to many assets, again and again: what changed is baked, what didn't isn't.
//!
//! ```text
//! manifest -> assets (globs, effective parameters) -> state (content keys) -> schedule -> crew (workers)
//!          -> make (bake, gates, preview, report) -> summary -> page, junit
//! ```

pub mod check;
pub mod cost;
pub mod crew;
pub mod engine;
pub mod figures;
#[cfg(test)]
mod fixture;
pub mod gates;
pub mod job;
pub mod journal;
pub mod junit;
pub mod log;
pub mod make;
pub mod measure;
pub mod merge;
pub mod page;
pub mod places;
pub mod preview;
pub mod process;
pub mod prune;
pub mod read;
pub mod schedule;
pub mod shard;
pub mod state;
pub mod summary;
pub mod verify;
pub mod worker;

// STUBS
pub mod manifest {
    use crate::parameters::{Part, ByteSize};
    #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
    #[serde(default)]
    pub struct Gates { #[serde(deserialize_with="crate::parameters::written::written")] pub max_error: Option<Part>, #[serde(deserialize_with="crate::parameters::written::written")] pub max_bytes: Option<ByteSize>, pub must_be_closed: Option<bool> }
}
pub mod assets {
    use std::path::PathBuf;
    pub struct Expanded { pub assets: Vec<PlannedAsset>, pub notes: Vec<String> }
    pub struct PlannedAsset { pub name: String, pub mesh: PathBuf, pub mesh_name: String, pub tags: Vec<String>, pub parameters: crate::parameters::Parameters, pub gates: super::manifest::Gates, pub timeout: Option<f64>, pub error_points: u32, pub report: bool }
}
