//! The protocol between a batch and its workers, a line of JSON each: jobs one way, replies the other.

use super::gates::FailedGate;
use super::manifest::Gates;
use super::summary::Figures;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use volmap_bake::content_key::Identity;
use volmap_bake::parameters::Parameters;

/// The step with which the report of an asset begins.
pub const REPORT_STEP: &str = "measuring for the report";

/// Something for a worker to do.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// What to do.
    pub task: Task,
    /// Threads that it may use.
    pub threads: usize,
}

/// What a worker can do.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Task {
    /// Estimate the cost of an asset.
    Estimate(Box<BakeInput>),
    /// Make an asset and all that belongs to it.
    Make(Box<MakeTask>),
}

/// A mesh, and the parameters of its bake.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BakeInput {
    /// The mesh file.
    pub mesh: PathBuf,
    /// Effective parameters.
    pub parameters: Parameters,
    /// Points at which the volume's error is measured.
    pub error_points: u32,
    /// Whether a report is wanted.
    pub report: bool,
}

/// An asset to be made.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MakeTask {
    /// The mesh, and the parameters of its bake.
    pub input: BakeInput,
    /// The content key, and what it is made of.
    pub identity: Identity,
    /// Quality gates that it must pass.
    pub gates: Gates,
    /// Bytes that the bake's estimate may reach.
    pub max_memory: u64,
    /// Files that may hold the same asset.
    pub candidates: Vec<PathBuf>,
    /// Where its files go.
    pub files: OutputFiles,
}

/// Where an asset, its picture and its report go; folders are made when they are needed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct OutputFiles {
    /// If it is good.
    pub good: AssetFiles,
    /// If a gate refuses it.
    pub rejected: AssetFiles,
    /// The asset's place in the cache, if there is one.
    pub cached: Option<PathBuf>,
}

/// Files of an asset.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AssetFiles {
    /// The asset.
    pub asset: PathBuf,
    /// Its picture.
    pub preview: PathBuf,
    /// The page of its report, if there shall be one; its JSON lies beside.
    pub report: Option<PathBuf>,
}

impl AssetFiles {
    /// Removes those that are there, if it can.
    pub fn forget(&self) {
        self.all().iter().for_each(|file| _ = std::fs::remove_file(file));
    }

    /// All files.
    pub fn all(&self) -> Vec<PathBuf> {
        let report = self.report.iter().flat_map(|page| [page.clone(), page.with_extension("json")]);
        [self.asset.clone(), self.preview.clone()].into_iter().chain(report).collect()
    }
}

/// A worker's answer to a job.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Reply {
    /// A step of the job starts; more replies follow.
    Step(String),
    /// The cost.
    Estimated(Estimate),
    /// The asset lies where it should.
    Made(Box<MakeResult>),
    /// The job failed.
    Failed {
        /// Why.
        error: String,
        /// Because there is no room for files.
        disk_full: bool,
    },
}

/// What is known of an asset before it is made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Its cost.
    pub cost: Cost,
    /// The mesh's length in words, for who wonders at the cost.
    pub length: String,
    /// What a careful person would look at before the bake.
    pub warnings: Vec<String>,
}

/// Estimated cost of an asset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Seconds on one thread.
    pub seconds: f64,
    /// Memory at its peak, bytes.
    pub memory: u64,
    /// Size of the file, bytes.
    pub file: u64,
}

/// The result of a [`MakeTask`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MakeResult {
    /// Not baked, but taken from this candidate.
    pub from: Option<PathBuf>,
    /// Gates that refused it.
    pub failed_gates: Vec<FailedGate>,
    /// What it is like.
    pub figures: Figures,
    /// Size of its file.
    pub bytes: u64,
    /// BLAKE3 of its file.
    pub file_blake3: String,
    /// Wall time, seconds.
    pub seconds: f64,
    /// Most memory of the worker during the job, bytes, where the system tells.
    pub peak_memory: Option<u64>,
    /// What went wrong without harm to the asset.
    pub notes: Vec<String>,
}
