//! Arguments of `volmap report`.

use super::threads;
use clap::Args;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use volmap_bake::parameters::Fraction;
use volmap_report::report::ReportSettings;
use volmap_report::report::shape::ClosedForm;

#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Asset
    #[arg(required_unless_present = "schema")]
    pub asset: Option<PathBuf>,
    /// Mesh that the asset stands for, placed as the asset says [default: the mesh that was baked, if it lies beside
    /// the asset or in this folder]
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Files go to NAME.report.html, .json and .PLANE.png [default: the asset's name without .h5, in this folder]
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
    /// The JSON goes here; `-` is the standard output. Without --output nothing else is written
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Largest error of the volume in the fluid, as a part of the full ball; above it the exit code is 1
    #[arg(long, value_name = "PART", allow_hyphen_values = true)]
    max_error: Option<Fraction>,
    /// The shape that the mesh stands for, in metres: sphere:x,y,z,radius, halfspace:x,y,z,nx,ny,nz or
    /// box:x0,y0,z0,x1,y1,z1; `inverted-` before it for a container
    #[arg(long, value_parser = ClosedForm::from_str, allow_hyphen_values = true)]
    shape: Option<ClosedForm>,
    /// Random points of the band
    #[arg(long, value_name = "N", default_value_t = ReportSettings::default().points, value_parser = points)]
    points: usize,
    /// How many of them are compared with the mesh
    #[arg(long, value_name = "N", default_value_t = ReportSettings::default().mesh_points,
        value_parser = points_or_none)]
    mesh_points: usize,
    /// How many of them by order 100 on the exact distance too, about 20 ms each
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = points_or_none)]
    gl100_mesh_points: usize,
    /// Seed of the points
    #[arg(long, value_name = "N", default_value_t = ReportSettings::default().seed)]
    seed: u64,
    /// Pixels of the longest side of a slice, up to 2048; 0 makes no pictures
    #[arg(long, value_name = "N", default_value_t = ReportSettings::default().pixels, value_parser = pixels)]
    pixels: usize,
    /// Print the JSON Schema of the JSON file and exit
    #[arg(long)]
    pub schema: bool,
    /// Threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl ReportArguments {
    /// What is measured.
    pub fn settings(&self) -> ReportSettings {
        ReportSettings {
            points: self.points,
            mesh_points: self.mesh_points,
            gl100_mesh_points: self.gl100_mesh_points,
            seed: self.seed,
            shape: self.shape,
            max_error: self.max_error.map(|part| part.0),
            pixels: if self.writes_page() { self.pixels } else { 0 },
        }
    }

    /// Whether there will be more than the JSON.
    pub fn writes_page(&self) -> bool {
        self.output.is_some() || self.json.is_none()
    }

    /// A file of the report.
    pub fn file(&self, asset: &Path, ending: &str) -> PathBuf {
        let mut name = match &self.output {
            Some(name) => name.clone().into_os_string(),
            None => asset.file_stem().unwrap_or_default().to_owned(),
        };
        name.push(format!(".report.{ending}"));
        name.into()
    }
}

fn points(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=10_000_000).contains(count));
    count.ok_or_else(|| "give a number from 1 to 10000000".into())
}

fn points_or_none(text: &str) -> Result<usize, String> {
    if text == "0" { Ok(0) } else { points(text).map_err(|error| error.replace("from 1", "from 0")) }
}

fn pixels(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| *count == 0 || (16..=2048).contains(count));
    count.ok_or_else(|| "give a number from 16 to 2048, or 0 for no pictures".into())
}
