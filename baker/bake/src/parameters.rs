//! The parameters of a bake, in one table. From a row follow the command line's option, the key in manifests and
//! scenes, its schema and its checks, the settings, the content key, and what the asset says of it. A new parameter is
//! one row, and the code that uses its setting.
//!
//! - here: the table, and what is done with all of its rows;
//! - [`row`]: what a row holds; [`range`] and [`check`]: what is refused;
//! - [`value`]: the types of values, in [`choice`], [`number`], [`part`] and [`size`].

mod attribute;
pub mod check;
pub mod choice;
pub mod number;
pub mod part;
pub mod range;
pub mod row;
pub mod size;
pub mod value;
mod written;

pub(crate) use attribute::{flag, real};
pub use check::Mistake;
pub use choice::{CompressionName, PrecisionName, Up};
pub use number::{Angle, Numbers, Resolution, Scale, Unit};
pub use part::{Fraction, RadiusPart, RoundingPart, Tolerance};
pub use range::Range;
pub use row::{Baked, Group, Parameter, Section};
pub use size::ByteSize;
pub use value::{DensityKernel, ParameterValue};

use crate::density_map::DensitySettings;
use crate::error::Error;
use crate::input::InputSettings;
use crate::plan::{GridChoice, Precision};
use crate::primitive::Primitive;
use crate::recipe::Recipe;
use crate::sdf::SignMethod;
use crate::settings::{FileSize, Tolerances};
use crate::volume_map::quadrature::Rule;
use attribute::{reals, text};
use row::parameters;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Debug;
use volmap_formats::asset::{Attributes, Compression, Value};
use volmap_formats::mesh::{Rotation, UpAxis};

parameters! {
    /// Support radius r of the SPH kernels
    support_radius: f64 {
        apply: |recipe, radius| recipe.bake.map.support_radius = Some(radius),
        unit: "metres",
        default: "1/20 of the diagonal, rounded",
        placeholder: "LENGTH",
        example: "0.1",
        range: Range::PositiveLength,
        group: Some(Group::Radius),
        key: |recipe| Some(or_auto(recipe.bake.map.support_radius)),
        describe: |baked| {
            let plan = &baked.summary.plan;
            let mut out =
                vec![("support_radius", plan.support_radius.into()), ("band_width", plan.band_width.into())];
            if baked.settings.map.grid == GridChoice::FromRadius {
                out.push(("grid", "from support radius".into()));
            }
            out
        },
    }

    /// Radius of the fluid's particles, a quarter of the support radius
    particle_radius: f64 {
        apply: |recipe, radius| recipe.bake.map.support_radius = Some(4.0 * radius),
        unit: "metres",
        placeholder: "LENGTH",
        example: "0.02",
        range: Range::PositiveLength,
        group: Some(Group::Radius),
        describe: |baked| vec![("particle_radius", (baked.summary.plan.support_radius / 4.0).into())],
    }

    /// Number of cells along each axis: N, or NX,NY,NZ
    resolution: Resolution {
        apply: |recipe, cells| recipe.bake.map.grid = GridChoice::Resolution(cells.0),
        placeholder: "N",
        example: "40,30,20",
        group: Some(Group::Cells),
        key: |recipe| Some(match recipe.bake.map.grid {
            GridChoice::Resolution(cells) => format!("{cells:?}"),
            _ => "auto".into(),
        }),
        describe: |baked| match baked.settings.map.grid {
            GridChoice::Resolution([x, y, z]) => vec![("grid", format!("resolution {x},{y},{z}").into())],
            _ => Vec::new(),
        },
    }

    /// Edge length of the cubic cells
    cell_size: f64 {
        apply: |recipe, edge| recipe.bake.map.grid = GridChoice::CellSize(edge),
        unit: "metres",
        default: "half the support radius",
        placeholder: "LENGTH",
        example: "0.03",
        range: Range::PositiveLength,
        group: Some(Group::Cells),
        key: |recipe| Some(match recipe.bake.map.grid {
            GridChoice::CellSize(edge) => format!("{edge:?}"),
            _ => "auto".into(),
        }),
        describe: |baked| match baked.settings.map.grid {
            GridChoice::CellSize(edge) => vec![("grid", format!("cell size {edge}").into())],
            _ => Vec::new(),
        },
    }

    /// Cells of several sizes, as large as this error of the volume allows, a fraction of the full ball: 1% or 0.01. With
    /// a density, the coarsest grid of equal cells that does
    tolerance: Tolerance {
        apply: |recipe, part| {
            recipe.bake.map.grid = GridChoice::Tolerance(Tolerances::of_volume(part.0));
            recipe.bake.map.precision = Precision::of_tolerance(part.0);
        },
        placeholder: "FRACTION",
        example: "2%",
        group: Some(Group::Cells),
        key: |recipe| Some(match recipe.bake.map.grid {
            GridChoice::Tolerance(tolerances) => format!("{:?}", tolerances.volume),
            _ => "auto".into(),
        }),
        describe: |baked| match baked.settings.map.grid {
            GridChoice::Tolerance(Tolerances { volume, .. }) => {
                vec![("grid", format!("tolerance {volume}").into()), ("tolerance", volume.into())]
            }
            _ => Vec::new(),
        },
    }

    /// Smaller cells where the distance is wrong by more than this fraction of the support radius
    distance_tolerance: RadiusPart {
        apply: |recipe, part| recipe.bake.map.grid.tolerances_mut().distance = part.0,
        default: "ten times `tolerance`",
        placeholder: "FRACTION",
        example: "5%",
        excludes: &OTHER_CELLS,
        key: |recipe| Some(match recipe.bake.map.grid {
            GridChoice::Tolerance(tolerances) => format!("{:?}", tolerances.distance),
            _ => "none".into(),
        }),
        describe: |baked| match baked.settings.map.grid {
            GridChoice::Tolerance(Tolerances { distance, .. }) => vec![("distance_tolerance", distance.into())],
            _ => Vec::new(),
        },
    }

    /// Smaller cells, down to a quarter of the support radius, where the normal is wrong by more than this angle: 3deg
    normal_tolerance: Angle {
        apply: |recipe, angle| recipe.bake.map.grid.tolerances_mut().normal = Some(angle.0.to_radians()),
        placeholder: "ANGLE",
        example: "30deg",
        excludes: &OTHER_CELLS,
        key: |recipe| Some(match recipe.bake.map.grid {
            GridChoice::Tolerance(tolerances) => format!("{:?}", tolerances.normal),
            _ => "none".into(),
        }),
        describe: |baked| match baked.settings.map.grid {
            GridChoice::Tolerance(Tolerances { normal: Some(angle), .. }) => {
                vec![("normal_tolerance", angle.to_degrees().into())]
            }
            _ => Vec::new(),
        },
    }

    /// Cells of several sizes, for the least error that a file of this size can have: 500kB. Numbers have 16 bits then,
    /// unless `precision` or `max_rounding` says otherwise
    max_bytes: ByteSize {
        apply: |recipe, size| {
            recipe.bake.map.grid = GridChoice::Bytes(FileSize { bytes: size.0, ..FileSize::default() });
            recipe.bake.map.precision = Precision::SHORTEST;
        },
        placeholder: "SIZE",
        example: "500kB",
        group: Some(Group::Cells),
        key: |recipe| Some(match recipe.bake.map.grid {
            GridChoice::Bytes(size) => size.bytes.to_string(),
            _ => "none".into(),
        }),
        describe: |baked| {
            let size = baked.summary.sized.as_ref().map(|sized| Value::from(sized.limit));
            size.map(|bytes| ("max_bytes", bytes)).into_iter().collect()
        },
    }

    /// Store the volume of cells of several sizes as it is, for readers that don't know its difference from a flat wall's
    plain_volume: bool {
        apply: |recipe, plain| recipe.bake.map.plain_volume = plain,
        placeholder: "BOOL",
        example: "true",
        excludes: &UNIFORM,
        key: |recipe| Some(recipe.bake.map.plain_volume.to_string()),
        describe: |baked| match baked.summary.adapted {
            Some(_) => vec![("plain_volume", baked.settings.map.plain_volume.into())],
            None => Vec::new(),
        },
    }

    /// Box of the map: xmin,ymin,zmin,xmax,ymax,zmax
    domain: Numbers<6> {
        apply: |recipe, corners| {
            let [a, b, c, d, e, f] = corners.0;
            recipe.bake.map.domain = Some([[a, b, c], [d, e, f]]);
        },
        unit: "metres",
        default: "all within two support radii of the surface",
        placeholder: "BOX",
        example: "0,0,0,1,2,3",
        range: Range::Box,
        key: |recipe| Some(or_auto(recipe.bake.map.domain)),
        describe: |baked| {
            let grid = baked.summary.plan.grid;
            let corners = [grid.origin, grid.max_corner()];
            let corners = corners.iter().flat_map(|corner| corner.to_array()).collect();
            vec![
                ("domain", Value::Real(corners)),
                ("domain_given", baked.settings.map.domain.is_some().into()),
            ]
        },
    }

    /// Enlarge the domain by this on every side
    padding: f64 {
        apply: |recipe, length| recipe.bake.map.padding = length,
        unit: "metres",
        default: "0",
        placeholder: "LENGTH",
        example: "0.5",
        range: Range::LengthFromZero,
        key: |recipe| Some(format!("{:?}", recipe.bake.map.padding)),
        describe: |baked| vec![("padding", baked.settings.map.padding.into())],
    }

    /// Swap inside and outside: for containers, whose fluid is inside; `thickness` is that of the walls then
    invert: bool {
        apply: |recipe, invert| recipe.bake.map.invert = invert,
        placeholder: "BOOL",
        example: "true",
        key: |recipe| Some(recipe.bake.map.invert.to_string()),
        describe: |baked| vec![("invert", baked.settings.map.invert.into())],
    }

    /// Thicken the solid by this much, or thin it if this is negative; a container's hollow becomes smaller by it,
    /// where SPlisHSPlasH's mapThickness makes one with mapInvert larger
    thickness: f64 {
        apply: |recipe, length| recipe.bake.map.thickness = length,
        unit: "metres",
        default: "0",
        placeholder: "LENGTH",
        example: "-0.1",
        range: Range::Length,
        key: |recipe| Some(format!("{:?}", recipe.bake.map.thickness)),
        describe: |baked| vec![("thickness", baked.settings.map.thickness.into())],
    }

    /// Quadrature of the volume: chordN, ballN, or glP of order P (gl30 is the paper's)
    quadrature: Rule {
        apply: |recipe, rule| recipe.bake.map.rule = rule,
        default: "chord8",
        placeholder: "RULE",
        example: "gl30",
        key: |recipe| Some(recipe.bake.map.rule.to_string()),
        describe: |baked| vec![("quadrature", baked.settings.map.rule.to_string().into())],
    }

    /// Bake the density map too (Koschier and Bender 2017): boundary density over rest density, for one SPH kernel
    density: bool {
        apply: |recipe, density| recipe.bake.map.density = density.then(DensitySettings::default),
        placeholder: "BOOL",
        example: "true",
        key: |recipe| Some(recipe.bake.map.density.is_some().to_string()),
    }

    /// SPH kernel of the density map: cubic_spline or wendland_c2
    kernel: DensityKernel {
        apply: |recipe, kernel| if let Some(density) = &mut recipe.bake.map.density {
            density.kernel = kernel.0;
        },
        default: "cubic_spline",
        placeholder: "KERNEL",
        example: "wendland_c2",
        needs: Some("density"),
        key: |recipe| Some(recipe.bake.map.density.map_or("none".into(), |density| density.kernel.to_string())),
        describe: |baked| {
            let kernel = baked.settings.map.density.map(|density| density.kernel.to_string().into());
            kernel.map(|name| ("density_kernel", name)).into_iter().collect()
        },
    }

    /// Quadrature of the density, written as the volume's (gl50 is the paper's)
    density_quadrature: Rule {
        apply: |recipe, rule| if let Some(density) = &mut recipe.bake.map.density {
            density.rule = rule;
        },
        default: "gl50",
        placeholder: "RULE",
        example: "gl30",
        needs: Some("density"),
        key: |recipe| Some(recipe.bake.map.density.map_or("none".into(), |density| density.rule.to_string())),
        describe: |baked| {
            let rule = baked.settings.map.density.map(|density| density.rule.to_string().into());
            rule.map(|name| ("density_quadrature", name)).into_iter().collect()
        },
    }

    /// Bake a shape instead of a mesh, by its exact distance: box:X,Y,Z, sphere:RADIUS, cylinder:RADIUS,HEIGHT,
    /// capsule:RADIUS,LENGTH (along y, around the origin) or plane:NX,NY,NZ (solid below it, within the domain)
    shape: Primitive {
        apply: |recipe, shape| recipe.input.shape = Some(shape.within(recipe.bake.map.domain)),
        unit: "metres",
        placeholder: "SHAPE",
        example: "sphere:0.5",
        section: Section::Mesh,
        key: |recipe| recipe.input.shape.map(|shape| shape.to_string()),
        describe: |baked| {
            let shape = baked.input.shape.map(|shape| shape.to_string().into());
            shape.map(|shape| ("shape", shape)).into_iter().collect()
        },
        restore: |bake, input| {
            if let Some(shape) = text(bake, "shape")? {
                input.shape = Some(shape.parse().map_err(|_| "shape")?);
            }
            Ok(())
        },
    }

    /// How inside and outside are told apart
    sign: SignMethod {
        apply: |recipe, sign| recipe.bake.sign = sign,
        default: "auto",
        placeholder: "SIGN",
        example: "winding",
        section: Section::Mesh,
        key: |recipe| Some(lower_case(recipe.bake.sign)),
        describe: |baked| {
            let sign = &baked.summary.sign;
            vec![("sign", lower_case(sign.method).into()), ("sign_reason", sign.reason.as_str().into())]
        },
    }

    /// Compute the sign by both methods at every node, and report where they differ
    check_sign: bool {
        apply: |recipe, check| recipe.bake.check_sign = check,
        placeholder: "BOOL",
        example: "true",
        section: Section::Mesh,
        key: |recipe| Some(recipe.bake.check_sign.to_string()),
    }

    /// Don't flip inconsistently oriented triangles
    keep_orientation: bool {
        apply: |recipe, keep| recipe.bake.keep_orientation = keep,
        placeholder: "BOOL",
        example: "true",
        section: Section::Mesh,
        key: |recipe| Some(recipe.bake.keep_orientation.to_string()),
        describe: |baked| vec![("keep_orientation", baked.settings.keep_orientation.into())],
    }

    /// Unit of the file's lengths: m, cm, mm, in, ft, or a number of metres
    unit: Unit {
        apply: |recipe, unit| {
            recipe.input.unit = Some(unit.0);
            recipe.bake.unit_is_given = true;
        },
        default: "the file's, or m",
        placeholder: "UNIT",
        example: "mm",
        section: Section::Mesh,
        key: |recipe| Some(or_auto(recipe.input.unit)),
        describe: |baked| vec![("unit", baked.input.placement.unit.into())],
        restore: |bake, input| {
            input.unit = real(bake, "unit")?.filter(|unit| !unit.is_nan());
            Ok(())
        },
    }

    /// Axis of the file that points up, and becomes +y
    up: Up {
        apply: |recipe, up| recipe.input.placement.up_axis = up.into(),
        default: "y",
        placeholder: "AXIS",
        example: "z",
        section: Section::Mesh,
        key: |recipe| Some(lower_case(recipe.input.placement.up_axis)),
        describe: |baked| vec![("up_axis", lower_case(baked.input.placement.up_axis).into())],
        restore: |bake, input| {
            if let Some(name) = text(bake, "up_axis")? {
                input.placement.up_axis = name.parse::<Up>().map(UpAxis::from).map_err(|_| "up_axis")?;
            }
            Ok(())
        },
    }

    /// Scale the mesh: S, or SX,SY,SZ
    scale: Scale {
        apply: |recipe, scale| recipe.input.placement.scale = scale.0,
        placeholder: "S",
        example: "1,2,3",
        section: Section::Mesh,
        range: Range::NotZero,
        key: |recipe| Some(format!("{:?}", recipe.input.placement.scale)),
        describe: |baked| vec![("scale", baked.input.placement.scale.into())],
        restore: |bake, input| restored(&mut input.placement.scale, reals(bake, "scale")),
    }

    /// Rotate the mesh, after scaling: AX,AY,AZ,DEGREES
    rotate: Numbers<4> {
        apply: |recipe, rotation| {
            let [x, y, z, degrees] = rotation.0;
            recipe.input.placement.rotation = Rotation { axis: [x, y, z], degrees };
        },
        placeholder: "ROTATION",
        example: "1,0,0,90",
        section: Section::Mesh,
        key: |recipe| {
            let Rotation { axis, degrees } = recipe.input.placement.rotation;
            Some(format!("{axis:?} {degrees:?}"))
        },
        describe: |baked| {
            let Rotation { axis, degrees } = baked.input.placement.rotation;
            vec![("rotation_axis", axis.into()), ("rotation_degrees", degrees.into())]
        },
        restore: |bake, input| {
            let rotation = &mut input.placement.rotation;
            restored(&mut rotation.axis, reals(bake, "rotation_axis"))?;
            restored(&mut rotation.degrees, real(bake, "rotation_degrees"))
        },
    }

    /// Move the mesh, after rotating: X,Y,Z
    translate: Numbers<3> {
        apply: |recipe, translation| recipe.input.placement.translation = translation.0,
        unit: "metres",
        placeholder: "VECTOR",
        example: "0.1,0.2,0.3",
        section: Section::Mesh,
        key: |recipe| Some(format!("{:?}", recipe.input.placement.translation)),
        describe: |baked| vec![("translation", baked.input.placement.translation.into())],
        restore: |bake, input| restored(&mut input.placement.translation, reals(bake, "translation")),
    }

    /// Merge vertices closer than this
    weld: f64 {
        apply: |recipe, length| recipe.input.weld_tolerance = length,
        unit: "in the file's unit",
        default: "0",
        placeholder: "LENGTH",
        example: "1e-3",
        section: Section::Mesh,
        range: Range::LengthFromZero,
        key: |recipe| Some(format!("{:?}", recipe.input.weld_tolerance)),
        describe: |baked| vec![("weld_tolerance", baked.input.weld_tolerance.into())],
        restore: |bake, input| restored(&mut input.weld_tolerance, real(bake, "weld_tolerance")),
    }

    /// Precision of the stored fields; by default of a bake for a tolerance 16 bits, where their rounding is a small part of
    /// it
    precision: PrecisionName {
        apply: |recipe, name| recipe.bake.map.precision = match name {
            PrecisionName::F32 => Precision::F32,
            PrecisionName::F64 => Precision::F64,
        },
        default: "f32",
        placeholder: "PRECISION",
        example: "f64",
        section: Section::File,
        group: Some(Group::Precision),
        key: |recipe| Some(precision_name(recipe.bake.map.precision).into()),
        describe: |baked| vec![("precision", precision_name(baked.settings.map.precision).into())],
    }

    /// Store 16-bit numbers, which halve the asset. At the nodes no distance changes by more than this fraction of the
    /// support radius, no volume by more than this fraction of the ball, no density by more than this fraction of
    /// rest density (0.01% or 1e-4); between the nodes by up to 5.75 times as much
    max_rounding: RoundingPart {
        apply: |recipe, part| recipe.bake.map.precision = Precision::Rounded(part.0),
        placeholder: "FRACTION",
        example: "0.01%",
        section: Section::File,
        group: Some(Group::Precision),
        key: |recipe| Some(match recipe.bake.map.precision {
            Precision::Rounded(part) => format!("{part:?}"),
            _ => "none".into(),
        }),
        describe: |baked| {
            let rounding = baked.summary.rounding.map(|rounding| rounding.allowed.into());
            rounding.map(|allowed| ("max_rounding", allowed)).into_iter().collect()
        },
    }

    /// Compression of the file: gzip, which every HDF5 library reads, or zstd, which is quicker and needs a plugin there
    compression: CompressionName {
        apply: |recipe, name| recipe.compression = match (name, recipe.bake.map.precision) {
            (CompressionName::Zstd, Precision::Rounded(_)) => ZSTD_OF_ROUNDED,
            (name, _) => name.into(),
        },
        default: "gzip",
        placeholder: "COMPRESSION",
        example: "zstd",
        section: Section::File,
        key: |recipe| Some(lower_case(recipe.compression)),
    }
}

/// What gives cells of one size.
const UNIFORM: [&str; 2] = ["resolution", "cell_size"];
/// What gives the cells in another way than by tolerances.
const OTHER_CELLS: [&str; 3] = ["resolution", "cell_size", "max_bytes"];

/// Numbers of 16 bits gain 5 % from a higher level, others less than 1 %.
const ZSTD_OF_ROUNDED: Compression = Compression::Zstd(5);

impl Parameters {
    /// What is given here, else what `base` gives. Of parameters that exclude each other, one given here drops the
    /// base's others.
    pub fn over(&self, base: &Parameters) -> Parameters {
        let mut out = self.clone();
        for row in base.given() {
            let is_excluded = (row.is_given)(self) || self.given().any(|own| row.is_excluded_by(own));
            if !is_excluded {
                (row.copy)(base, &mut out);
            }
        }
        out
    }

    /// The settings that follow from the parameters. The limit on memory is the default: it doesn't change an asset. Of
    /// parameters that exclude each other, which [`Parameters::check`] refuses, the last in the table holds.
    pub fn recipe(&self) -> Recipe {
        let mut recipe = Recipe::default();
        self.given().for_each(|row| (row.apply)(self, &mut recipe));
        if recipe.bake.map.density.is_some() && !self.gives(Group::Precision) {
            recipe.bake.map.precision = Precision::default();
        }
        if let GridChoice::Bytes(size) = &mut recipe.bake.map.grid {
            size.compression = recipe.compression;
        }
        recipe
    }

    /// The error in the words of what is given here: settings have one radius, which may be given as the particles'.
    pub fn explain(&self, error: Error) -> Error {
        if self.particle_radius.is_none() {
            return error;
        }
        let reworded = |text: String| text.replace("`support_radius`", "`particle_radius`");
        match error {
            Error::Setting { parameter: "support_radius", reason } => {
                Error::setting("particle_radius", reworded(reason))
            }
            Error::Setting { parameter, reason } => Error::setting(parameter, reworded(reason)),
            Error::Sized { about, reason } => {
                Error::Sized { about: reworded(about), reason: Box::new(self.explain(*reason)) }
            }
            other => other,
        }
    }
}

impl Recipe {
    /// Every parameter by name, given or by default, as a text that differs whenever the value does: what a content key
    /// is made of. `auto` is what the mesh decides; a particle radius stands as the support radius.
    pub fn effective(&self) -> BTreeMap<String, String> {
        let mut out: BTreeMap<String, String> =
            TABLE.iter().filter_map(|row| Some((row.name.to_owned(), (row.key)(self)?))).collect();
        // No parameter: simulations choose it.
        let extension =
            self.bake.map.density.map_or("none".into(), |density| format!("{:?}", density.extension));
        out.insert("density_extension".into(), extension);
        out
    }
}

/// What an asset says of its parameters.
pub fn describe(baked: &Baked) -> Attributes {
    let all = TABLE.iter().flat_map(|row| (row.describe)(baked));
    all.map(|(name, value)| (name.to_owned(), value)).collect()
}

/// How an asset says that its mesh was placed; the default for what it doesn't say.
///
/// # Errors
/// The attribute that no bake writes like this.
pub(crate) fn restore(bake: &Attributes) -> Result<InputSettings, &'static str> {
    let mut out = InputSettings::default();
    TABLE.iter().try_for_each(|row| (row.restore)(bake, &mut out))?;
    Ok(out)
}

fn restored<T>(place: &mut T, found: Result<Option<T>, &'static str>) -> Result<(), &'static str> {
    if let Some(value) = found? {
        *place = value;
    }
    Ok(())
}

/// Gives the keys of a schema the descriptions of the rows.
fn describe_schema(schema: &mut Schema) {
    let properties = schema.get_mut("properties").and_then(|properties| properties.as_object_mut());
    let Some(properties) = properties else { return };
    for row in TABLE {
        if let Some(key) = properties.get_mut(row.name).and_then(|key| key.as_object_mut()) {
            key.insert("description".into(), row.description().into());
        }
    }
}

fn or_auto(value: Option<impl Debug>) -> String {
    value.map_or("auto".into(), |value| format!("{value:?}"))
}

fn lower_case(value: impl Debug) -> String {
    format!("{value:?}").to_lowercase()
}

fn precision_name(precision: Precision) -> &'static str {
    match precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
        Precision::Rounded(_) => "i16",
    }
}

#[cfg(test)]
mod tests;
