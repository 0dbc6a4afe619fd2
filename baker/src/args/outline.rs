//! Options of `volmap bake-outline`.

use super::parameters::{ParameterArguments, Rows};
use super::threads;
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;
use volmap_bake::area_map::disc::DiscRule;
use volmap_bake::area_map::outline::OutlinePlacement;
use volmap_bake::area_map::{AreaDensity, AreaSettings};
use volmap_bake::parameters::number::list;
use volmap_bake::parameters::{Numbers, Parameter};
use volmap_bake::plan::GridChoice;
use volmap_formats::asset::Compression;

/// The parameters that mean the same in two dimensions; others have values of another form here.
#[derive(Clone, Debug)]
struct Shared;

impl Rows for Shared {
    const MESH: &'static str = "Outline";

    fn has(row: &Parameter) -> bool {
        let names = [
            "support_radius",
            "particle_radius",
            "cell_size",
            "padding",
            "invert",
            "thickness",
            "density",
            "kernel",
            "unit",
            "precision",
            "max_rounding",
            "compression",
        ];
        names.contains(&row.name)
    }
}

#[derive(Debug, Args)]
pub struct OutlineArguments {
    /// OBJ file with closed lines (`l`) in a plane z
    pub outline: PathBuf,
    /// Where the asset goes [default: the outline's name with .h5, in this folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    #[command(flatten)]
    shared: ParameterArguments<Shared>,
    /// Number of cells along each axis: N, or NX,NY
    #[arg(long, value_name = "N", value_parser = resolution, conflicts_with = "cell_size", help_heading = "Map")]
    resolution: Option<Cells>,
    /// Box of the map: xmin,ymin,xmax,ymax, metres [default: all within two support radii of the lines]
    #[arg(long, value_name = "BOX", allow_hyphen_values = true, help_heading = "Map")]
    domain: Option<Numbers<4>>,
    /// Quadrature of the area: discN, or glP of order P (gl30 is the paper's)
    #[arg(long, value_name = "RULE", default_value_t, value_parser = DiscRule::from_str, help_heading = "Map")]
    quadrature: DiscRule,
    /// Quadrature of the density, written as the area's
    #[arg(
        long,
        value_name = "RULE",
        default_value_t = AreaDensity::default().rule,
        requires = "density",
        help_heading = "Map"
    )]
    density_quadrature: DiscRule,
    /// Move the outline: X,Y, metres
    #[arg(long, value_name = "VECTOR", allow_hyphen_values = true, help_heading = "Outline")]
    translate: Option<Numbers<2>>,

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

/// Along x and y.
#[derive(Clone, Copy, Debug)]
struct Cells([u32; 2]);

fn resolution(text: &str) -> Result<Cells, String> {
    match list::<u32>(text).as_deref() {
        Some([n]) => Ok(Cells([*n; 2])),
        Some([x, y]) => Ok(Cells([*x, *y])),
        _ => Err("give N, or NX,NY".into()),
    }
}

impl OutlineArguments {
    /// Where the asset goes.
    pub fn output(&self) -> PathBuf {
        let beside = || PathBuf::from(self.outline.with_extension("h5").file_name().unwrap_or_default());
        self.output.clone().unwrap_or_else(beside)
    }

    /// Where the outline stands.
    pub fn placement(&self) -> OutlinePlacement {
        OutlinePlacement {
            unit: self.shared.given.unit.map_or(1.0, |unit| unit.0),
            translation: self.translate.map_or([0.0; 2], |Numbers(t)| t),
        }
    }

    /// How it is baked.
    pub fn settings(&self) -> AreaSettings {
        let map = self.shared.given.recipe().bake.map;
        AreaSettings {
            support_radius: map.support_radius,
            grid: match self.resolution {
                Some(Cells([x, y])) => GridChoice::Resolution([x, y, 1]),
                None => map.grid,
            },
            domain: self.domain.map(|Numbers([a, b, c, d])| [[a, b], [c, d]]),
            padding: map.padding,
            invert: map.invert,
            thickness: map.thickness,
            rule: self.quadrature,
            density: map.density.map(|density| AreaDensity {
                kernel: density.kernel,
                rule: self.density_quadrature,
                ..AreaDensity::default()
            }),
            precision: map.precision,
        }
    }

    /// How it is stored.
    pub fn compression(&self) -> Compression {
        self.shared.given.recipe().compression
    }
}
