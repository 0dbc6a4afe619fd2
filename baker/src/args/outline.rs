//! Options of `volmap bake-outline`.

use super::threads;
use clap::{ArgGroup, Args};
use std::path::PathBuf;
use std::str::FromStr;
use volmap_bake::area_map::disc::DiscRule;
use volmap_bake::area_map::outline::OutlinePlacement;
use volmap_bake::area_map::{AreaDensity, AreaSettings};
use volmap_bake::density_map::parse_kernel;
use volmap_bake::parameters::number::list;
use volmap_bake::parameters::{CompressionName, Numbers, PrecisionName, RoundingPart, Unit};
use volmap_bake::plan::GridChoice;
use volmap_bake::recipe::precision;
use volmap_formats::asset::Compression;
use volmap_runtime::KernelKind;

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("radius").args(["support_radius", "particle_radius"])))]
#[command(group(ArgGroup::new("cells").args(["resolution", "cell_size"])))]
#[command(allow_negative_numbers = true)]
pub struct OutlineArguments {
    /// OBJ file with closed lines (`l`) in a plane z
    pub outline: PathBuf,
    /// Where the asset goes [default: the outline's name with .h5, in this folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Support radius r of the kernels, metres [default: 1/20 of the outline's diagonal, rounded]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    support_radius: Option<f64>,
    /// Radius of the fluid's particles, metres; r is four of it
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    particle_radius: Option<f64>,
    /// Cells along each axis: N, or NX,NY
    #[arg(long, value_name = "N", value_parser = resolution, help_heading = "Map")]
    resolution: Option<Cells>,
    /// Edge of the square cells, metres [default: r / 2]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    cell_size: Option<f64>,
    /// xmin,ymin,xmax,ymax, metres [default: all within 2 r of the lines]
    #[arg(long, value_name = "BOX", allow_hyphen_values = true, help_heading = "Map")]
    domain: Option<Numbers<4>>,
    /// Length added to the domain on every side, metres
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, help_heading = "Map")]
    padding: f64,
    /// The outline is a container: the solid is outside
    #[arg(long, help_heading = "Map")]
    invert: bool,
    /// Move the lines out of the solid by this, metres
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, help_heading = "Map")]
    thickness: f64,
    /// Rule of the area's integral: discN, or glP of order P (gl30 is the paper's)
    #[arg(long, value_name = "RULE", default_value_t, value_parser = DiscRule::from_str, help_heading = "Map")]
    quadrature: DiscRule,
    /// Bake the density map too (Koschier and Bender 2017): boundary density over rest density, for one SPH kernel
    #[arg(long, help_heading = "Map")]
    density: bool,
    /// SPH kernel of the density map: cubic_spline, or wendland_c2
    #[arg(long, value_name = "KERNEL", value_parser = parse_kernel, default_value_t, requires = "density", help_heading = "Map")]
    kernel: KernelKind,
    /// Rule of the density's integral, as --quadrature
    #[arg(long, value_name = "RULE", default_value_t = AreaDensity::default().rule, requires = "density", help_heading = "Map")]
    density_quadrature: DiscRule,

    /// Unit of the file's lengths: m, cm, mm, in, ft, or metres as a number [default: m]
    #[arg(long, value_name = "UNIT", help_heading = "Outline")]
    unit: Option<Unit>,
    /// Translation: X,Y, metres
    #[arg(long, value_name = "VECTOR", allow_hyphen_values = true, help_heading = "Outline")]
    translate: Option<Numbers<2>>,

    /// Precision of the stored fields
    #[arg(long, value_enum, default_value_t, help_heading = "File")]
    precision: PrecisionName,
    /// Store 16-bit numbers, as `bake` does
    #[arg(long, value_name = "PART", conflicts_with = "precision", help_heading = "File")]
    max_rounding: Option<RoundingPart>,
    /// Compression: zstd, or gzip for readers without plugins
    #[arg(long, value_enum, default_value_t, help_heading = "File")]
    compression: CompressionName,

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
            unit: self.unit.map_or(1.0, |unit| unit.0),
            translation: self.translate.map_or([0.0; 2], |Numbers(t)| t),
        }
    }

    /// How it is baked.
    pub fn settings(&self) -> AreaSettings {
        let grid = match (self.resolution, self.cell_size) {
            (Some(Cells([x, y])), _) => GridChoice::Resolution([x, y, 1]),
            (_, Some(edge)) => GridChoice::CellSize(edge),
            _ => GridChoice::FromRadius,
        };
        AreaSettings {
            support_radius: self.support_radius.or(self.particle_radius.map(|radius| 4.0 * radius)),
            grid,
            domain: self.domain.map(|Numbers([a, b, c, d])| [[a, b], [c, d]]),
            padding: self.padding,
            invert: self.invert,
            thickness: self.thickness,
            rule: self.quadrature,
            density: self.density.then(|| AreaDensity {
                kernel: self.kernel,
                rule: self.density_quadrature,
                ..AreaDensity::default()
            }),
            precision: precision(self.max_rounding.map(|part| part.0), self.precision),
        }
    }

    /// How it is stored.
    pub fn compression(&self) -> Compression {
        self.compression.into()
    }
}
