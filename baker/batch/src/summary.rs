//! What came of a batch, for people and for programs: `summary.json`.

use super::left_out::LeftOut;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use volmap_bake::content_key::Identity;

/// Version of `summary.json`.
pub const SUMMARY_VERSION: u32 = 2;

/// What came of a batch, or of a shard of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// Version of this file's format.
    pub version: u32,
    /// Version of the program.
    pub program_version: String,
    /// The manifest, relative to the folder of this file where that can be; none if meshes were named
    /// on the command line.
    pub manifest: Option<String>,
    /// Which part of the batch this is; none: all of it.
    pub shard: Option<Shard>,
    /// Only assets with one of these tags are in it; none: all.
    pub tags: Vec<String>,
    /// The batch was stopped before its end.
    pub interrupted: bool,
    /// How many assets came out how.
    pub counts: Counts,
    /// Wall time, seconds.
    pub seconds: f64,
    /// Jobs that ran at once.
    pub jobs: usize,
    /// Threads of all jobs together.
    pub threads: usize,
    /// What else there is to say: patterns without a mesh, assets that the manifest no longer lists.
    pub notes: Vec<String>,
    /// Files that patterns meet and that aren't read, by their formats.
    pub left_out: Vec<LeftOut>,
    /// Folders that couldn't be looked into: there may be more meshes.
    pub unreadable: Vec<String>,
    /// Names of assets that earlier batches made in this folder and that the manifest no longer lists.
    pub leftovers: Vec<String>,
    /// BLAKE3 of all that the manifest says of its assets: parts of one batch have the same.
    pub plan: String,
    /// The assets, in the order of the manifest.
    pub assets: Vec<AssetReport>,
}

/// A part of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    /// From 1.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

/// How many assets came out how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// See [`Outcome::Built`].
    pub built: usize,
    /// See [`Outcome::Reused`].
    pub reused: usize,
    /// See [`Outcome::Unchanged`].
    pub unchanged: usize,
    /// See [`Outcome::Doubtful`].
    pub doubtful: usize,
    /// See [`Outcome::Rejected`].
    pub rejected: usize,
    /// See [`Outcome::Failed`].
    pub failed: usize,
    /// See [`Outcome::NotTried`].
    pub not_tried: usize,
}

/// What came of an asset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Baked now.
    Built,
    /// Not baked: an asset of the same content key was in the cache, or in the output folder under another name.
    Reused,
    /// The asset in the output folder is the one that is wanted.
    Unchanged,
    /// Baked, now or before, but the map has no solid, or its signs are in doubt: the gates that hold by default. It
    /// lies in the folder `rejected`; an older asset of its name stays as it was.
    Doubtful,
    /// Baked, now or before, but a quality gate refused it. It lies in the folder `rejected`; an older asset of its
    /// name stays as it was.
    Rejected,
    /// No asset: the error says why. An older asset stays as it was.
    Failed,
    /// The batch ended before its turn.
    NotTried,
}

/// One asset of a batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AssetReport {
    /// Place in the manifest's order, from 0.
    pub position: usize,
    /// Its name: the output's path in the output folder, without `.h5`.
    pub name: String,
    /// The mesh file, as the manifest's folder and entry give it.
    pub mesh: String,
    /// The asset's file, relative to the folder of this file.
    pub output: String,
    /// The manifest's tags.
    pub tags: Vec<String>,
    /// What came of it.
    pub outcome: Outcome,
    /// Why it was built, or wasn't.
    pub reason: String,
    /// Why it failed.
    pub error: Option<String>,
    /// Gates that it doesn't pass, in words.
    pub failed_gates: Vec<String>,
    /// What its bytes follow from; none if the mesh couldn't be read.
    pub identity: Option<Identity>,
    /// Estimated cost: seconds on one thread; none if it wasn't estimated.
    pub estimated_seconds: Option<f64>,
    /// Wall time of the bake and all that belongs to it, seconds; for unchanged assets that of when it was built, if
    /// known.
    pub seconds: Option<f64>,
    /// Threads of the bake.
    pub threads: Option<usize>,
    /// Most memory that the worker had in use, bytes.
    pub peak_memory: Option<u64>,
    /// Size of the asset's file, bytes.
    pub bytes: Option<u64>,
    /// BLAKE3 of the asset's file.
    pub file_blake3: Option<String>,
    /// What the asset is like.
    pub figures: Option<Figures>,
    /// Picture of the solid (PNG), relative to the folder of this file.
    pub preview: Option<String>,
    /// Page with errors and their causes, relative to the folder of this file.
    pub report: Option<String>,
}

/// What an asset is like.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Figures {
    /// Triangles of the mesh.
    pub triangles: u64,
    /// Whether the mesh is closed.
    pub closed: bool,
    /// Support radius, metres.
    pub support_radius: f64,
    /// Longest edge of the cells, metres.
    pub cell_size: f64,
    /// Stored cells.
    pub band_cells: u64,
    /// Stored nodes.
    pub nodes: u64,
    /// Largest error of the volume that was measured in the fluid, as a part of the full ball; none if none was.
    pub volume_error_max: Option<f64>,
    /// Root mean square of the same errors.
    pub volume_error_rms: Option<f64>,
    /// Points at which it was measured.
    pub volume_error_points: u64,
    /// Whether a node lies in the solid.
    pub has_solid: bool,
    /// Part of the nodes at which the sign is in doubt; 0 where it is exact.
    pub sign_doubt: f64,
    /// Warnings of the bake.
    pub warnings: Vec<String>,
}

impl AssetReport {
    /// Whether what is said of the file is said of this one: an asset that lies where the other did, good or rejected.
    pub fn output_is(&self, path: &std::path::Path) -> bool {
        path.ends_with(&self.output)
    }
}

impl Summary {
    /// Whether every asset is there and good, and no folder was left out.
    pub fn is_good(&self) -> bool {
        self.counts.all_good() && self.unreadable.is_empty()
    }
}

impl Counts {
    /// Counts outcomes.
    pub fn of(assets: &[AssetReport]) -> Counts {
        let count = |outcome| assets.iter().filter(|asset| asset.outcome == outcome).count();
        Counts {
            built: count(Outcome::Built),
            reused: count(Outcome::Reused),
            unchanged: count(Outcome::Unchanged),
            doubtful: count(Outcome::Doubtful),
            rejected: count(Outcome::Rejected),
            failed: count(Outcome::Failed),
            not_tried: count(Outcome::NotTried),
        }
    }

    /// Every outcome and its number.
    pub fn by_outcome(&self) -> [(Outcome, usize); 7] {
        [
            (Outcome::Built, self.built),
            (Outcome::Reused, self.reused),
            (Outcome::Unchanged, self.unchanged),
            (Outcome::Doubtful, self.doubtful),
            (Outcome::Rejected, self.rejected),
            (Outcome::Failed, self.failed),
            (Outcome::NotTried, self.not_tried),
        ]
    }

    /// Whether every asset that is known is there and good.
    pub fn all_good(&self) -> bool {
        self.doubtful + self.rejected + self.failed + self.not_tried == 0
    }
}

impl Outcome {
    /// Whether the asset is there and good.
    pub fn is_good(self) -> bool {
        matches!(self, Outcome::Built | Outcome::Reused | Outcome::Unchanged)
    }

    /// Whether it was tried, and isn't good.
    pub fn is_bad(self) -> bool {
        matches!(self, Outcome::Doubtful | Outcome::Rejected | Outcome::Failed)
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Built => "built",
            Outcome::Reused => "reused",
            Outcome::Unchanged => "unchanged",
            Outcome::Doubtful => "doubtful",
            Outcome::Rejected => "rejected",
            Outcome::Failed => "failed",
            Outcome::NotTried => "not tried",
        }
    }
}
