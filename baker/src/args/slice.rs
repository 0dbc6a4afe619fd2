//! Arguments of `volmap slice`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::str::FromStr;
use volmap_figures::picture::Plane;
use volmap_report::slice::{SliceField, SliceSettings};

#[derive(Debug, Args)]
pub struct SliceArguments {
    /// Asset
    pub asset: PathBuf,
    /// Where: x=, y= or z= and metres, as z=0.2
    #[arg(long, value_parser = Plane::from_str)]
    plane: Plane,
    /// What
    #[arg(long, value_enum, default_value_t)]
    field: FieldName,
    /// Mesh whose surface is drawn too; it is placed as the asset says
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Pixels of the longer side, 16 to 4096
    #[arg(long, value_name = "N", default_value_t = 600, value_parser = clap::value_parser!(u16).range(16..=4096))]
    pixels: u16,
    /// Values of the field that get a curve, with commas between
    #[arg(long, value_name = "VALUES", value_delimiter = ',', value_parser = finite, allow_hyphen_values = true)]
    contours: Vec<f64>,
    /// Picture, a PNG file
    #[arg(short, long, value_name = "FILE", value_parser = png_file)]
    pub output: PathBuf,
    /// The numbers of the pixels too: x, y, z, value, region
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum FieldName {
    #[default]
    Volume,
    /// If the asset has it
    Density,
    Distance,
    NormalX,
    NormalY,
    NormalZ,
    /// Against the mesh
    NormalAngle,
}

impl SliceArguments {
    /// What is drawn.
    pub fn settings(&self) -> SliceSettings {
        let field = match self.field {
            FieldName::Volume => SliceField::Volume,
            FieldName::Density => SliceField::Density,
            FieldName::Distance => SliceField::Distance,
            FieldName::NormalX => SliceField::Normal(0),
            FieldName::NormalY => SliceField::Normal(1),
            FieldName::NormalZ => SliceField::Normal(2),
            FieldName::NormalAngle => SliceField::NormalAngle,
        };
        SliceSettings {
            plane: self.plane,
            field,
            pixels: self.pixels.into(),
            contours: self.contours.clone(),
        }
    }
}

fn finite(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "give finite numbers".into())
}

fn png_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    is_png.then_some(path).ok_or_else(|| "pictures are PNG files; give a name that ends in .png".into())
}
