//! The command line: raw arguments, then validated options.

pub mod batch;
pub mod cache;
pub mod exchange;
pub mod outline;
pub mod parameters;
pub mod report;
pub mod reproduce;
pub mod slice;

use clap::{Args, Parser, Subcommand};
use parameters::{All, ParameterArguments};
use std::path::PathBuf;
use volmap_bake::parameters::ByteSize;
use volmap_bake::recipe::Recipe;
use volmap_formats::mesh::MeshFormat;

/// Bakes triangle meshes into volume maps for SPH boundaries, and looks into them.
#[derive(Debug, Parser)]
#[command(name = "volmap", version, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    #[command(about = format!("Bake a mesh ({}) into an HDF5 volume map", MeshFormat::list()))]
    Bake(Box<BakeArguments>),
    /// Bake closed lines in the plane (OBJ with `l`) into an HDF5 map in two dimensions
    BakeOutline(Box<outline::OutlineArguments>),
    /// Bake many meshes into a folder of assets: only what changed, on all cores or several machines
    Batch(Box<batch::BatchArguments>),
    /// Check whether the assets in a folder are up to date with their meshes: keys, checksums, gates
    Verify(batch::VerifyArguments),
    /// Show an asset: mesh, grid, error and warnings
    Info {
        /// Asset
        asset: PathBuf,
        /// Every parameter and the whole diagnosis
        #[arg(long, conflicts_with = "json")]
        all: bool,
        /// Everything, as JSON
        #[arg(long)]
        json: bool,
    },
    /// Query distance, normal, closest point, volume and region (band, outside, deep_inside) at points
    Query {
        /// Asset
        asset: PathBuf,
        /// CSV file with columns x, y, z in metres; `-` is the standard input
        #[arg(long, value_name = "CSV")]
        points: PathBuf,
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Measure an asset's accuracy; writes an HTML report
    Report(Box<report::ReportArguments>),
    /// Draw a map on a plane
    Slice(slice::SliceArguments),
    /// Write a map for other programs: VTKHDF, VTI, PLY, or SPlisHSPlasH's own
    Export(exchange::ExportArguments),
    /// Make an asset from a map of SPlisHSPlasH
    Import(exchange::ImportArguments),
    /// Reproduce the experiments of Bender et al. 2020 (about 3 minutes)
    Reproduce(reproduce::ReproduceArguments),
    /// Show, list or clear the maps that are kept for simulations and batches
    Cache(cache::CacheArguments),
    /// Print completions for a shell
    Completions {
        /// Shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write one for each command
    Man {
        /// Folder for the pages (volmap.1, volmap-bake.1, ...); made if it isn't there
        #[arg(short, long, value_name = "FOLDER")]
        output: Option<PathBuf>,
    },
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct BakeArguments {
    /// Mesh file; none with --shape
    #[arg(required_unless_present = "shape", conflicts_with = "shape")]
    mesh: Option<PathBuf>,
    /// Where the asset goes [default: the mesh's or the shape's name with .h5, in this folder]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub parameters: ParameterArguments<All>,

    /// Refuse bakes that need more, as 4GiB or 500MB
    #[arg(long, value_name = "BYTES", default_value = "4GiB", help_heading = "Program")]
    max_memory: ByteSize,
    /// Threads [default: all]
    #[arg(long, value_name = "N", value_parser = threads, help_heading = "Program")]
    pub threads: Option<usize>,
    /// Print the summary as JSON (that of `info`)
    #[arg(long, help_heading = "Program")]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long, help_heading = "Program")]
    pub quiet: bool,
}

impl BakeArguments {
    /// The mesh file; of a shape its name.
    pub fn mesh(&self) -> PathBuf {
        let shape = || self.parameters.given.shape.map_or("", |shape| shape.name());
        self.mesh.clone().unwrap_or_else(|| shape().into())
    }

    /// Where the asset goes.
    pub fn output(&self) -> PathBuf {
        let beside = || PathBuf::from(self.mesh().with_extension("h5").file_name().unwrap_or_default());
        self.output.clone().unwrap_or_else(beside)
    }

    /// How the mesh is read, baked and compressed.
    pub fn recipe(&self) -> Recipe {
        let mut recipe = self.parameters.given.recipe();
        recipe.bake.map.max_memory = self.max_memory.0;
        recipe
    }
}

/// Far more than there are processors would only take memory and minutes to start.
fn threads(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=1024).contains(count));
    count.ok_or_else(|| "give a number from 1 to 1024".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn definition_is_sound() {
        Arguments::command().debug_assert();
    }
}
