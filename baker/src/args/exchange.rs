//! Arguments of `export` and `import`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;
use volmap_bake::iso_surface::lattice::LatticeChoice;
use volmap_bake::parameters::Resolution;
use volmap_formats::asset::Exterior;
use volmap_report::export::{ExportField, ExportSettings};
use volmap_report::import::ImportSettings;

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct ExportArguments {
    /// Asset
    pub asset: PathBuf,
    /// File to write; its extension says what: .vtkhdf (the map, for ParaView), .vti (its values at equally spaced
    /// points), .ply (a surface), .cdm (the map, for SPlisHSPlasH), .cdf (its distance, for Discregrid)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// VTI: one field [default: both]
    #[arg(long, value_enum)]
    field: Option<FieldName>,
    /// VTI, PLY: steps along each axis of the domain: N, or NX,NY,NZ [default: VTI the cells, PLY thirds of them]
    #[arg(long, value_name = "N", conflicts_with = "cell_size")]
    resolution: Option<Resolution>,
    /// VTI, PLY: length of the steps, metres
    #[arg(long, value_name = "LENGTH")]
    cell_size: Option<f64>,
    /// PLY: signed distance of the surface, metres [default: 0]
    #[arg(long, value_name = "LENGTH")]
    iso: Option<f64>,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct ImportArguments {
    /// Map of SPlisHSPlasH (.cdm)
    pub map: PathBuf,
    /// Where the asset goes
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Support radius r of the kernels that it was made for, metres: four times the particle radius
    #[arg(long, value_name = "LENGTH")]
    support_radius: f64,
    /// What is outside its domain [default: what its border is]
    #[arg(long, value_enum)]
    exterior: Option<ExteriorName>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum FieldName {
    Distance,
    Volume,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ExteriorName {
    Fluid,
    /// As around a container
    Solid,
}

impl ExportArguments {
    /// What is exported.
    pub fn settings(&self) -> ExportSettings {
        let field = |name| match name {
            FieldName::Distance => ExportField::Distance,
            FieldName::Volume => ExportField::Volume,
        };
        let steps = self.resolution.map(|Resolution(steps)| LatticeChoice::Resolution(steps));
        ExportSettings {
            field: self.field.map(field),
            lattice: steps.or(self.cell_size.map(LatticeChoice::CellSize)),
            iso: self.iso,
        }
    }
}

impl ImportArguments {
    /// What the file doesn't say.
    pub fn settings(&self) -> ImportSettings {
        let exterior = |name| match name {
            ExteriorName::Fluid => Exterior::Fluid,
            ExteriorName::Solid => Exterior::Solid,
        };
        ImportSettings { support_radius: self.support_radius, exterior: self.exterior.map(exterior) }
    }
}
