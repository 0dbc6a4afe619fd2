//! The command line: raw arguments, then validated options.

pub mod batch;
pub mod exchange;
pub mod outline;
pub mod report;
pub mod reproduce;
pub mod slice;

use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::str::FromStr;
use volmap_baker::bake::BakeSettings;
use volmap_baker::density_map::DensitySettings;
use volmap_baker::density_map::smoothing::Smoothing;
use volmap_baker::input::InputSettings;
use volmap_baker::plan::{GridChoice, Precision, Settings};
use volmap_baker::sdf::SignMethod;
use volmap_baker::tolerance::TOLERANCES;
use volmap_baker::volume_map::quadrature::Rule;
use volmap_formats::asset::Compression;
use volmap_formats::mesh::{Placement, Rotation, UpAxis};

/// Bakes triangle meshes into volume maps for SPH boundaries, and looks into them.
#[derive(Debug, Parser)]
#[command(name = "volmap", version, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Bake a mesh (OBJ, STL, PLY, OFF, glTF, 3MF, VTK, VTU) into an HDF5 volume map
    Bake(Box<BakeArguments>),
    /// Bake closed lines in the plane (OBJ with `l`) into an HDF5 map in two dimensions
    BakeOutline(Box<outline::OutlineArguments>),
    /// Bake many meshes into a folder of assets: only what changed, on all cores or several machines
    Batch(Box<batch::BatchArguments>),
    /// Check a folder of assets against its manifest, without baking: keys, checksums, gates
    Verify(batch::VerifyArguments),
    /// Make assets for a batch, as it says on the standard input
    #[command(hide = true)]
    BatchWorker,
    /// Show what stands in an asset
    Info {
        /// Asset
        asset: PathBuf,
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Ask a map for distance, normal, closest point and volume at points
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
    /// Measure how exact an asset is: a page with errors, their causes, and pictures
    Report(Box<report::ReportArguments>),
    /// Draw a map on a plane
    Slice(slice::SliceArguments),
    /// Write a map for other programs: VTKHDF, VTI, PLY, or SPlisHSPlasH's own
    Export(exchange::ExportArguments),
    /// Make an asset of a map of SPlisHSPlasH
    Import(exchange::ImportArguments),
    /// Repeat the experiments of Bender et al. 2020 and compare the figures; some three minutes
    Reproduce(reproduce::ReproduceArguments),
    /// Print completions for a shell
    Completions {
        /// Shell
        shell: clap_complete::Shell,
    },
    /// Print the manual, or write a page for each command
    Man {
        /// Folder for the pages (volmap.1, volmap-bake.1, ...); made if it isn't there
        #[arg(short, long, value_name = "FOLDER")]
        output: Option<PathBuf>,
    },
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("radius").args(["support_radius", "particle_radius"])))]
#[command(group(ArgGroup::new("cells").args(["resolution", "cell_size", "tolerance"])))]
#[command(allow_negative_numbers = true)]
pub struct BakeArguments {
    /// Mesh file
    pub mesh: PathBuf,
    /// Where the asset goes [default: the mesh's name with .h5, in this folder]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Support radius r of the kernels, metres [default: 1/20 of the mesh's diagonal, rounded]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    support_radius: Option<f64>,
    /// Radius of the fluid's particles, metres; r is four of it
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    particle_radius: Option<f64>,
    /// Cells along each axis: N, or NX,NY,NZ
    #[arg(long, value_name = "N", value_parser = resolution, help_heading = "Map")]
    resolution: Option<Vector<u32>>,
    /// Edge of the cubic cells, metres [default: r / 2]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    cell_size: Option<f64>,
    /// Largest error of the volume, as a part of the full ball (1% or 0.01): finds the
    /// largest cells of those it tries that keep it at 1,000 points of the fluid
    #[arg(long, value_name = "PART", value_parser = tolerance, help_heading = "Map")]
    tolerance: Option<f64>,
    /// xmin,ymin,zmin,xmax,ymax,zmax, metres [default: all within 2 r of the surface]
    #[arg(long, value_name = "BOX", value_parser = numbers::<6>, allow_hyphen_values = true, help_heading = "Map")]
    domain: Option<Numbers<6>>,
    /// Length added to the domain on every side, metres
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, help_heading = "Map")]
    padding: f64,
    /// The mesh is a container: the solid is outside
    #[arg(long, help_heading = "Map")]
    invert: bool,
    /// Move the surface out of the solid by this, metres
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, help_heading = "Map")]
    thickness: f64,
    /// Rule of the volume's integral: chordN, ballN, or glP of order P (gl30 is the paper's)
    #[arg(long, value_name = "RULE", default_value_t, value_parser = Rule::from_str, help_heading = "Map")]
    quadrature: Rule,
    /// Bake the density map too (Koschier and Bender 2017): boundary density over rest density, for one SPH kernel
    #[arg(long, help_heading = "Map")]
    density: bool,
    /// SPH kernel of the density map: cubic (cubic spline), or wendland (Wendland C2)
    #[arg(long, value_name = "KERNEL", default_value = "cubic", requires = "density", help_heading = "Map")]
    kernel: Smoothing,
    /// Rule of the density's integral, as --quadrature (gl50 is the paper's)
    #[arg(long, value_name = "RULE", default_value_t = DensitySettings::default().rule, requires = "density", help_heading = "Map")]
    density_quadrature: Rule,

    /// How inside and outside are told apart
    #[arg(long, value_enum, default_value_t, help_heading = "Mesh")]
    sign: Sign,
    /// Compare both signs at every node and report where they differ
    #[arg(long, help_heading = "Mesh")]
    check_sign: bool,
    /// Don't turn triangles that run the wrong way round
    #[arg(long, help_heading = "Mesh")]
    keep_orientation: bool,
    /// Unit of the file's lengths: m, cm, mm, in, ft, or metres as a number [default: the file's, or m]
    #[arg(long, value_name = "UNIT", value_parser = unit, help_heading = "Mesh")]
    unit: Option<f64>,
    /// Axis of the file that becomes +y
    #[arg(long, value_enum, default_value_t, value_name = "AXIS", help_heading = "Mesh")]
    up: Up,
    /// Scale: S, or SX,SY,SZ
    #[arg(long, value_name = "S", value_parser = scale, allow_hyphen_values = true, help_heading = "Mesh")]
    scale: Option<Numbers<3>>,
    /// Rotation after scaling: AX,AY,AZ,DEGREES
    #[arg(long, value_name = "ROTATION", value_parser = numbers::<4>, allow_hyphen_values = true, help_heading = "Mesh")]
    rotate: Option<Numbers<4>>,
    /// Translation after rotating: X,Y,Z, metres
    #[arg(long, value_name = "VECTOR", value_parser = numbers::<3>, allow_hyphen_values = true, help_heading = "Mesh")]
    translate: Option<Numbers<3>>,
    /// Make vertices this close one, in the file's unit
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, help_heading = "Mesh")]
    weld: f64,

    /// Precision of the stored fields
    #[arg(long, value_enum, default_value_t, help_heading = "File")]
    precision: PrecisionName,
    /// Store 16-bit numbers: at the nodes no distance changes by more than this part of r, no volume by more than this
    /// part of the ball, no density by more than this part of rest density (0.01%, or 1e-4); between them by up to 5.75 times as much. Half as large, loaded too
    #[arg(long, value_name = "PART", value_parser = part, conflicts_with = "precision", help_heading = "File")]
    max_rounding: Option<f64>,
    /// Compression: zstd, or gzip for readers without plugins
    #[arg(long, value_enum, default_value_t, help_heading = "File")]
    compression: CompressionName,

    /// Refuse bakes that need more, as 4GiB or 500MB
    #[arg(long, value_name = "BYTES", default_value = "4GiB", value_parser = byte_size, help_heading = "Program")]
    max_memory: u64,
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

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Sign {
    #[default]
    Auto,
    Pseudonormal,
    Winding,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Up {
    X,
    #[default]
    Y,
    Z,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PrecisionName {
    #[default]
    F32,
    F64,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum CompressionName {
    #[default]
    Zstd,
    Gzip,
}

/// Several numbers of one argument; a type of its own, as clap takes arrays for lists of arguments.
#[derive(Clone, Copy, Debug)]
struct Vector<T>([T; 3]);

#[derive(Clone, Copy, Debug)]
struct Numbers<const N: usize>([f64; N]);

impl BakeArguments {
    /// Where the asset goes.
    pub fn output(&self) -> PathBuf {
        let beside = || PathBuf::from(self.mesh.with_extension("h5").file_name().unwrap_or_default());
        self.output.clone().unwrap_or_else(beside)
    }

    /// How the mesh is read.
    pub fn input(&self) -> InputSettings {
        let rotation = self.rotate.map_or(Placement::default().rotation, |Numbers([x, y, z, degrees])| {
            Rotation { axis: [x, y, z], degrees }
        });
        let up_axis = match self.up {
            Up::X => UpAxis::X,
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        };
        InputSettings {
            unit: self.unit,
            placement: Placement {
                unit: 1.0,
                up_axis,
                scale: self.scale.map_or([1.0; 3], |Numbers(s)| s),
                rotation,
                translation: self.translate.map_or([0.0; 3], |Numbers(t)| t),
            },
            weld_tolerance: self.weld,
        }
    }

    /// How it is baked.
    pub fn settings(&self) -> BakeSettings {
        let grid = match (self.resolution, self.cell_size, self.tolerance) {
            (Some(Vector(cells)), ..) => GridChoice::Resolution(cells),
            (_, Some(edge), _) => GridChoice::CellSize(edge),
            (.., Some(part)) => GridChoice::Tolerance(part),
            _ => GridChoice::FromRadius,
        };
        let corners = |Numbers([a, b, c, d, e, f]): Numbers<6>| [[a, b, c], [d, e, f]];
        BakeSettings {
            map: Settings {
                support_radius: self.support_radius.or(self.particle_radius.map(|radius| 4.0 * radius)),
                grid,
                domain: self.domain.map(corners),
                padding: self.padding,
                invert: self.invert,
                thickness: self.thickness,
                rule: self.quadrature,
                density: self.density.then(|| DensitySettings {
                    kernel: self.kernel,
                    rule: self.density_quadrature,
                    ..DensitySettings::default()
                }),
                precision: precision(self.max_rounding, self.precision),
                max_memory: self.max_memory,
            },
            sign: match self.sign {
                Sign::Auto => SignMethod::Auto,
                Sign::Pseudonormal => SignMethod::Pseudonormal,
                Sign::Winding => SignMethod::Winding,
            },
            keep_orientation: self.keep_orientation,
            check_sign: self.check_sign,
        }
    }

    /// How the asset is compressed.
    pub fn compression(&self) -> Compression {
        match self.compression {
            // Numbers of 16 bits gain 5 % from a higher level, others less than 1 %.
            CompressionName::Zstd if self.max_rounding.is_some() => Compression::Zstd(5),
            other => other.into(),
        }
    }
}

/// Rounded to a part, or by name.
fn precision(max_rounding: Option<f64>, name: PrecisionName) -> Precision {
    match (max_rounding, name) {
        (Some(part), _) => Precision::Rounded(part),
        (None, PrecisionName::F32) => Precision::F32,
        (None, PrecisionName::F64) => Precision::F64,
    }
}

impl From<CompressionName> for Compression {
    fn from(name: CompressionName) -> Compression {
        match name {
            CompressionName::Zstd => Compression::default(),
            CompressionName::Gzip => Compression::Gzip(6),
        }
    }
}

fn list<T: FromStr>(text: &str) -> Option<Vec<T>> {
    text.split(',').map(|part| part.trim().parse().ok()).collect()
}

fn numbers<const N: usize>(text: &str) -> Result<Numbers<N>, String> {
    let numbers = list::<f64>(text).and_then(|list| <[f64; N]>::try_from(list).ok());
    let numbers = numbers.filter(|list| list.iter().all(|x| x.is_finite()));
    numbers.map(Numbers).ok_or_else(|| format!("give {N} finite numbers with commas between"))
}

fn scale(text: &str) -> Result<Numbers<3>, String> {
    match list::<f64>(text).as_deref() {
        Some([s]) if s.is_finite() => Ok(Numbers([*s; 3])),
        _ => numbers::<3>(text).map_err(|_| "give S, or SX,SY,SZ".into()),
    }
}

fn resolution(text: &str) -> Result<Vector<u32>, String> {
    match list::<u32>(text).as_deref() {
        Some([n]) => Ok(Vector([*n; 3])),
        Some([x, y, z]) => Ok(Vector([*x, *y, *z])),
        _ => Err("give N, or NX,NY,NZ".into()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    let [least, most] = TOLERANCES;
    let part = fraction(text).filter(|part| (least..=most).contains(part));
    part.ok_or_else(|| {
        format!("give {}% to {}%, or the same as a number, as 0.01", 100.0 * least, 100.0 * most)
    })
}

/// Far more than there are processors would only take memory and minutes to start.
fn threads(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=1024).contains(count));
    count.ok_or_else(|| "give a number from 1 to 1024".to_owned())
}

/// A part of a whole, as a number or in per cent.
fn fraction(text: &str) -> Option<f64> {
    let (number, whole) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 100.0));
    number.trim().parse::<f64>().ok().map(|x| x / whole)
}

fn part(text: &str) -> Result<f64, String> {
    fraction(text)
        .filter(|part| *part > 0.0 && *part < 0.5)
        .ok_or_else(|| "give a part as 0.01%, or 1e-4, below 50%".into())
}

fn unit(text: &str) -> Result<f64, String> {
    let known = [("m", 1.0), ("dm", 0.1), ("cm", 0.01), ("mm", 1e-3), ("um", 1e-6), ("km", 1e3)];
    let imperial = [("in", 0.0254), ("ft", 0.3048)];
    let named = known.iter().chain(&imperial).find(|(name, _)| *name == text).map(|(_, metres)| *metres);
    let number = || text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite());
    named.or_else(number).ok_or_else(|| "give m, cm, mm, um, km, in, ft, or metres as a number".into())
}

fn byte_size(text: &str) -> Result<u64, String> {
    let units = [("KiB", 10), ("MiB", 20), ("GiB", 30), ("TiB", 40)];
    let decimal = [("kB", 1e3), ("KB", 1e3), ("MB", 1e6), ("GB", 1e9), ("TB", 1e12), ("B", 1.0)];
    let binary = units.map(|(name, shift)| (name, (1u64 << shift) as f64));
    let unit = binary.iter().chain(&decimal).find_map(|(name, size)| Some((text.strip_suffix(name)?, *size)));
    let (number, size) = unit.unwrap_or((text, 1.0));
    let bytes = number.trim().parse::<f64>().ok().filter(|n| *n > 0.0).map(|n| (n * size) as u64);
    bytes.ok_or_else(|| "give a size as 4GiB or 500MB".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn definition_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn sizes_and_units() {
        assert_eq!(byte_size("4GiB"), Ok(4 << 30));
        assert_eq!(byte_size("500MB"), Ok(500_000_000));
        assert!(byte_size("-1GB").is_err() && byte_size("much").is_err());
        assert_eq!(unit("mm"), Ok(1e-3));
        assert_eq!(part("0.01%"), part("1e-4"));
        assert!(["0", "-1%", "50%", "much", "nan", "1"].iter().all(|text| part(text).is_err()));
        assert!(unit("furlong").is_err() && unit("0").is_err());
        assert_eq!((tolerance("1%"), tolerance("0.01")), (Ok(0.01), Ok(0.01)));
        assert!(tolerance("0").is_err() && tolerance("200%").is_err() && tolerance("NaN").is_err());
        assert_eq!(resolution("20").unwrap().0, [20; 3]);
        assert!(resolution("20,30").is_err() && resolution("-1").is_err());
    }
}
