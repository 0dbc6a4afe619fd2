//! The parameters of a bake that change its asset: one definition for the command line, for manifests and for the
//! messages to workers. [`crate::recipe`] makes settings of them.
//!
//! The comments of the fields are the help of `volmap bake` and the descriptions in a manifest's schema.

pub mod check;
pub mod choice;
pub mod number;
pub mod part;
pub mod size;
pub mod written;

pub use check::Mistake;
pub use choice::{CompressionName, PrecisionName, Sign, Up};
pub use number::{Numbers, Resolution, Scale, Unit};
pub use part::{Part, RoundingPart, Tolerance};
pub use size::ByteSize;

use crate::density_map::parse_kernel;
use crate::volume_map::quadrature::Rule;
use clap::{ArgGroup, Args};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use volmap_runtime::KernelKind;
use written::{Written, displayed, written};

/// Every parameter that changes an asset; what isn't given has its default.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "give a table with options of `volmap bake`")]
#[command(group(ArgGroup::new("radius").args(["support_radius", "particle_radius"])))]
#[command(group(ArgGroup::new("cells").args(["resolution", "cell_size", "tolerance"])))]
#[command(allow_negative_numbers = true)]
pub struct Parameters {
    /// Support radius r of the kernels, metres [default: 1/20 of the mesh's diagonal, rounded]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    pub support_radius: Option<f64>,
    /// Radius of the fluid's particles, metres; r is four of it
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    pub particle_radius: Option<f64>,
    /// Cells along each axis: N, or NX,NY,NZ
    #[arg(long, value_name = "N", help_heading = "Map")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub resolution: Option<Resolution>,
    /// Edge of the cubic cells, metres [default: r / 2]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    pub cell_size: Option<f64>,
    /// Largest error of the volume, as a part of the full ball (1% or 0.01): finds the
    /// largest cells of those it tries that keep it at 1,000 points of the fluid
    #[arg(long, value_name = "PART", help_heading = "Map")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub tolerance: Option<Tolerance>,
    /// xmin,ymin,zmin,xmax,ymax,zmax, metres [default: all within 2 r of the surface]
    #[arg(long, value_name = "BOX", allow_hyphen_values = true, help_heading = "Map")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub domain: Option<Numbers<6>>,
    /// Length added to the domain on every side, metres [default: 0]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    pub padding: Option<f64>,
    /// The mesh is a container: the solid is outside
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true, hide_possible_values = true, help_heading = "Map")]
    pub invert: Option<bool>,
    /// Move the surface out of the solid by this, metres [default: 0]
    #[arg(long, value_name = "LENGTH", help_heading = "Map")]
    pub thickness: Option<f64>,
    /// Rule of the volume's integral: chordN, ballN, or glP of order P (gl30 is the paper's) [default: chord8]
    #[arg(long, value_name = "RULE", help_heading = "Map")]
    #[serde(serialize_with = "displayed", deserialize_with = "written")]
    #[schemars(with = "Option<String>")]
    pub quadrature: Option<Rule>,
    /// Bake the density map too (Koschier and Bender 2017): boundary density over rest density, for one SPH kernel
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true, hide_possible_values = true, help_heading = "Map")]
    pub density: Option<bool>,
    /// SPH kernel of the density map: cubic_spline, or wendland_c2 [default: cubic_spline]
    #[arg(long, value_name = "KERNEL", value_parser = parse_kernel, requires = "density", help_heading = "Map")]
    #[serde(serialize_with = "displayed", deserialize_with = "written")]
    #[schemars(with = "Option<String>")]
    pub kernel: Option<KernelKind>,
    /// Rule of the density's integral, as --quadrature (gl50 is the paper's) [default: gl50]
    #[arg(long, value_name = "RULE", requires = "density", help_heading = "Map")]
    #[serde(serialize_with = "displayed", deserialize_with = "written")]
    #[schemars(with = "Option<String>")]
    pub density_quadrature: Option<Rule>,

    /// How inside and outside are told apart [default: auto]
    #[arg(long, value_enum, help_heading = "Mesh")]
    pub sign: Option<Sign>,
    /// Compare both signs at every node and report where they differ
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true, hide_possible_values = true, help_heading = "Mesh")]
    pub check_sign: Option<bool>,
    /// Don't turn triangles that run the wrong way round
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true, hide_possible_values = true, help_heading = "Mesh")]
    pub keep_orientation: Option<bool>,
    /// Unit of the file's lengths: m, cm, mm, in, ft, or metres as a number [default: the file's, or m]
    #[arg(long, value_name = "UNIT", help_heading = "Mesh")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub unit: Option<Unit>,
    /// Axis of the file that becomes +y [default: y]
    #[arg(long, value_enum, value_name = "AXIS", help_heading = "Mesh")]
    pub up: Option<Up>,
    /// Scale: S, or SX,SY,SZ
    #[arg(long, value_name = "S", allow_hyphen_values = true, help_heading = "Mesh")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub scale: Option<Scale>,
    /// Rotation after scaling: AX,AY,AZ,DEGREES
    #[arg(long, value_name = "ROTATION", allow_hyphen_values = true, help_heading = "Mesh")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub rotate: Option<Numbers<4>>,
    /// Translation after rotating: X,Y,Z, metres
    #[arg(long, value_name = "VECTOR", allow_hyphen_values = true, help_heading = "Mesh")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub translate: Option<Numbers<3>>,
    /// Make vertices this close one, in the file's unit [default: 0]
    #[arg(long, value_name = "LENGTH", help_heading = "Mesh")]
    pub weld: Option<f64>,

    /// Precision of the stored fields [default: f32]
    #[arg(long, value_enum, help_heading = "File")]
    pub precision: Option<PrecisionName>,
    /// Store 16-bit numbers: at the nodes no distance changes by more than this part of r, no volume by more than this
    /// part of the ball, no density by more than this part of rest density (0.01%, or 1e-4); between them by up to 5.75 times as much. Half as large, loaded too
    #[arg(long, value_name = "PART", conflicts_with = "precision", help_heading = "File")]
    #[serde(deserialize_with = "written")]
    #[schemars(with = "Option<Written>")]
    pub max_rounding: Option<RoundingPart>,
    /// Compression: zstd, or gzip for readers without plugins [default: zstd]
    #[arg(long, value_enum, help_heading = "File")]
    pub compression: Option<CompressionName>,
}

impl Parameters {
    /// What is given here, else what `base` gives. Of parameters that exclude each other, one given here drops the
    /// base's others.
    pub fn over(&self, base: &Parameters) -> Parameters {
        let (radius, cells, precision) = (self.gives_radius(), self.gives_cells(), self.gives_precision());
        Parameters {
            support_radius: self.support_radius.or(base.support_radius.filter(|_| !radius)),
            particle_radius: self.particle_radius.or(base.particle_radius.filter(|_| !radius)),
            resolution: self.resolution.or(base.resolution.filter(|_| !cells)),
            cell_size: self.cell_size.or(base.cell_size.filter(|_| !cells)),
            tolerance: self.tolerance.or(base.tolerance.filter(|_| !cells)),
            domain: self.domain.or(base.domain),
            padding: self.padding.or(base.padding),
            invert: self.invert.or(base.invert),
            thickness: self.thickness.or(base.thickness),
            quadrature: self.quadrature.or(base.quadrature),
            density: self.density.or(base.density),
            kernel: self.kernel.or(base.kernel),
            density_quadrature: self.density_quadrature.or(base.density_quadrature),
            sign: self.sign.or(base.sign),
            check_sign: self.check_sign.or(base.check_sign),
            keep_orientation: self.keep_orientation.or(base.keep_orientation),
            unit: self.unit.or(base.unit),
            up: self.up.or(base.up),
            scale: self.scale.or(base.scale),
            rotate: self.rotate.or(base.rotate),
            translate: self.translate.or(base.translate),
            weld: self.weld.or(base.weld),
            precision: self.precision.or(base.precision.filter(|_| !precision)),
            max_rounding: self.max_rounding.or(base.max_rounding.filter(|_| !precision)),
            compression: self.compression.or(base.compression),
        }
    }

    fn gives_radius(&self) -> bool {
        self.support_radius.is_some() || self.particle_radius.is_some()
    }

    fn gives_cells(&self) -> bool {
        self.resolution.is_some() || self.cell_size.is_some() || self.tolerance.is_some()
    }

    fn gives_precision(&self) -> bool {
        self.precision.is_some() || self.max_rounding.is_some()
    }
}
