//! Arguments of `volmap batch` and `volmap verify`.

use super::parameters::{All, ParameterArguments};
use super::threads;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use volmap_bake::parameters::ByteSize;
use volmap_batch::shard;
use volmap_batch::summary::Shard;

/// Arguments of `volmap batch`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct BatchArguments {
    /// A manifest (.toml, .json), or meshes and patterns, as 'meshes/**/*.obj'
    #[arg(value_name = "MANIFEST|MESH", required_unless_present_any = ["schema", "merge"])]
    pub inputs: Vec<String>,
    /// Folder of the assets; made if it isn't there
    #[arg(short, long, value_name = "FOLDER", required_unless_present_any = ["schema", "merge", "list"])]
    pub out: Option<PathBuf>,
    /// Names of the assets of meshes on the command line: {path}, {stem}, {extension}, {parent} stand for parts of the
    /// mesh's path [default: {path}]
    #[arg(long, value_name = "TEMPLATE")]
    pub name: Option<String>,
    /// Only assets with one of these tags
    #[arg(long, value_name = "TAG", conflicts_with = "shard")]
    pub tag: Vec<String>,
    /// Dry run: what would be baked, with estimated time and memory
    #[arg(long)]
    pub check: bool,
    /// Print name, mesh, tags, and files that the mesh refers to, of every asset, with tabs between, and exit
    #[arg(long, conflicts_with_all = ["check", "shard"])]
    pub list: bool,
    /// Say of every asset why it is baked or not
    #[arg(long)]
    pub explain: bool,
    /// Bake everything again
    #[arg(long)]
    pub rebuild: bool,
    /// Remove assets from earlier batches that the manifest no longer lists
    #[arg(long, conflicts_with_all = ["shard", "tag"])]
    pub prune: bool,
    /// Folder of assets by their content keys, which several machines may share
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,

    /// Do part I of N: I/N, from 1; auto, or auto/N: as an array job's environment says (Slurm, AWS Batch,
    /// Kubernetes, OpenCue)
    #[arg(long, value_name = "I/N", value_parser = shard_of, help_heading = "Several machines")]
    pub shard: Option<Shard>,
    /// Join the summaries of all shards in this folder, and exit
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["inputs", "out", "shard", "check"],
        help_heading = "Several machines")]
    pub merge: Option<PathBuf>,

    /// Jobs that run at once [default: as many as threads]
    #[arg(short, long, value_name = "N", value_parser = threads, help_heading = "Program")]
    pub jobs: Option<usize>,
    /// Threads of all jobs together [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, help_heading = "Program")]
    pub threads: Option<usize>,
    /// Memory of all jobs together, as 4GiB or 500MB [default: three quarters of what is free]
    #[arg(long, value_name = "BYTES", help_heading = "Program")]
    pub max_memory: Option<ByteSize>,
    /// Seconds for a bake, unless the manifest says otherwise
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Program")]
    pub timeout: Option<f64>,
    /// Seconds for a report, unless the manifest says otherwise
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Program")]
    pub report_timeout: Option<f64>,
    /// Form of what is printed: a line an asset, or a JSON object an asset
    #[arg(long, value_enum, default_value_t, value_name = "FORM", help_heading = "Program")]
    pub log: Log,
    /// Print the JSON Schema of manifests and exit
    #[arg(long, help_heading = "Program")]
    pub schema: bool,
    /// Print nothing but what failed
    #[arg(short, long, help_heading = "Program")]
    pub quiet: bool,

    #[command(flatten)]
    pub parameters: ParameterArguments<All>,
}

/// Form of what is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Log {
    #[default]
    Text,
    Json,
}

/// Arguments of `volmap verify`.
#[derive(Debug, Args)]
pub struct VerifyArguments {
    /// Folder of the assets
    pub folder: PathBuf,
    /// Manifest [default: the one that the folder's summary names]
    #[arg(long, value_name = "FILE")]
    pub manifest: Option<PathBuf>,
    /// As JSON
    #[arg(long)]
    pub json: bool,
    /// Threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Print nothing but what is wrong
    #[arg(short, long)]
    pub quiet: bool,
}

fn shard_of(text: &str) -> Result<Shard, String> {
    shard::parse(text, &|name| std::env::var(name))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| *seconds > 0.0 && seconds.is_finite());
    seconds.ok_or_else(|| "give a number of seconds above 0".into())
}
