//! How a batch is run.

use super::places::Places;
use super::prune::Leftovers;
use super::summary::Shard;
use std::path::PathBuf;

/// How a batch is run.
#[derive(Clone, Debug)]
pub struct BatchSettings {
    /// The output folder and the cache.
    pub places: Places,
    /// The program whose `batch-worker` makes assets: `volmap`.
    pub worker: PathBuf,
    /// Jobs that run at once.
    pub jobs: usize,
    /// Threads of all jobs together.
    pub threads: usize,
    /// Memory of all jobs together, bytes.
    pub max_memory: u64,
    /// Seconds for a bake whose manifest says nothing.
    pub timeout: Option<f64>,
    /// Seconds for a report whose manifest says nothing.
    pub report_timeout: Option<f64>,
    /// Make everything anew.
    pub rebuild: bool,
    /// Which part to do.
    pub shard: Option<Shard>,
    /// Only assets with one of these tags are looked at; none: all.
    pub tags: Vec<String>,
    /// What is done with assets that the manifest no longer lists.
    pub leftovers: Leftovers,
}
