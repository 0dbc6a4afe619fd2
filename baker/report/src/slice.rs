//! A map on a plane, as a picture: Fig. 6a of Bender et al. 2020, *Implicit Frictional Boundary Handling for
//! SPH*.

use crate::error::Error;
use glam::DVec3;
use rayon::prelude::*;
use std::io::Write;
use volmap_bake::sdf::bvh::Bvh;
use volmap_bake::watch::{Cancelled, Watch};
use volmap_figures::picture::colours::{BLACK, DISTINCT, WHITE};
use volmap_figures::picture::{
    ColourMap, Colouring, Figure, Limits, Line, Panel, Pixel, PixelLattice, Plane, Quantity, Raster,
    contours, section,
};
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::{number, typeset};
use volmap_runtime::{Sample, VolumeMap};

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SliceField {
    /// Volume of the solid in the ball, m^3.
    #[default]
    Volume,
    /// Boundary density over rest density, if the asset has it.
    Density,
    /// Signed distance, m.
    Distance,
    /// A component (0, 1, 2) of the normal.
    Normal(usize),
    /// Angle between the map's normal and the line to the closest point of the mesh, degrees, 0 to 90.
    NormalAngle,
}

/// What a slice depends on beside the map.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceSettings {
    /// Where.
    pub plane: Plane,
    /// What.
    pub field: SliceField,
    /// Pixels along the longer side.
    pub pixels: usize,
    /// Values of the field that get a curve.
    pub contours: Vec<f64>,
}

/// Values on a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Slice {
    /// The picture.
    pub figure: Figure,
    /// The numbers.
    pub raster: Raster,
}

/// A mesh in the frame of the map, and its name.
#[derive(Clone, Copy, Debug)]
pub struct NamedMesh<'a> {
    /// Metres.
    pub mesh: &'a TriangleMesh,
    /// For the legend.
    pub name: &'a str,
}

/// Samples a map on a plane through its domain, and draws it, its surface and the mesh's.
///
/// # Errors
/// A plane outside the domain; the angle of normals without a mesh; cancelled.
pub fn slice(
    map: &VolumeMap,
    settings: &SliceSettings,
    mesh: Option<NamedMesh>,
    watch: &Watch,
) -> Result<Slice, Error> {
    let lattice = lattice(map, settings)?;
    if settings.field == SliceField::Density && map.density_kernel().is_none() {
        return Err(Error::setting("field", "density: the asset has none; bake it with `density`"));
    }
    let tree = match (settings.field, mesh) {
        (SliceField::NormalAngle, None) => {
            return Err(Error::setting("field", "normal-angle: needs `mesh`, to compare with"));
        }
        (SliceField::NormalAngle, Some(NamedMesh { mesh, .. })) => Some(tree(mesh)),
        _ => None,
    };
    let (pixels, distances) = sampled(map, settings.field, &lattice, tree.as_ref(), watch)?;
    let raster = Raster { lattice, pixels };
    watch.step("drawing")?;
    let panel = Panel {
        title: settings.plane.to_string().replace('-', "−"),
        raster: raster.clone(),
        quantity: quantity(settings.field),
        colouring: colouring(settings.field),
        lines: lines(&raster, &distances, settings, mesh),
        markers: Vec::new(),
    };
    watch.check()?;
    Ok(Slice { figure: Figure::of(panel), raster })
}

fn tree(mesh: &TriangleMesh) -> Bvh {
    let corner = |vertex: u32| DVec3::from(mesh.vertices[vertex as usize]);
    let corners: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|triangle| triangle.map(corner)).collect();
    Bvh::new(&corners)
}

/// The field, and the distance in metres or NaN, at the pixels.
fn sampled(
    map: &VolumeMap,
    field: SliceField,
    lattice: &PixelLattice,
    tree: Option<&Bvh>,
    watch: &Watch,
) -> Result<(Vec<Pixel>, Vec<f64>), Cancelled> {
    let work = watch.begin("asking the map at pixels", lattice.size[1] as u64)?;
    let row = |j: usize| {
        work.check()?;
        let points: Vec<DVec3> = (0..lattice.size[0]).map(|i| lattice.point(i, j)).collect();
        let mut samples: Vec<Sample> = Vec::new();
        map.sample_batch(&points, &mut samples);
        let pixel = |(sample, point): (&Sample, &DVec3)| match (field, map.density(*point)) {
            (SliceField::Density, Some(density)) if sample.near().is_some() => Pixel::Value(density.value),
            _ => pixel(field, sample, *point, tree),
        };
        let distance = |sample: &Sample| sample.near().map_or(f64::NAN, |near| near.distance);
        work.add(1);
        Ok((samples.iter().zip(&points).map(pixel).collect(), samples.iter().map(distance).collect()))
    };
    let rows: Result<Vec<_>, Cancelled> = (0..lattice.size[1]).into_par_iter().map(row).collect();
    let (pixels, distances): (Vec<Vec<Pixel>>, Vec<Vec<f64>>) = rows?.into_iter().unzip();
    Ok((pixels.concat(), distances.concat()))
}

/// The pixels of the plane, if it goes through the domain.
fn lattice(map: &VolumeMap, settings: &SliceSettings) -> Result<PixelLattice, Error> {
    let (low, high) = (map.grid().origin, map.grid().max_corner());
    let Plane { axis, at } = settings.plane;
    let [from, to] = [low, high].map(|corner| corner[axis.index()]);
    if !(from..=to).contains(&at) {
        let name = axis.name();
        let reason = format!("{name} = {at} is outside the domain, where {name} goes from {from} to {to} m");
        return Err(Error::setting("plane", reason));
    }
    Ok(PixelLattice::over(settings.plane, low, high, settings.pixels))
}

fn pixel(field: SliceField, sample: &Sample, point: DVec3, tree: Option<&Bvh>) -> Pixel {
    let near = match sample {
        Sample::Near(near) => near,
        Sample::Outside => return Pixel::Fluid,
        Sample::DeepInside => return Pixel::Solid,
    };
    match (field, tree) {
        (SliceField::Volume, _) => Pixel::Value(near.volume),
        (SliceField::Distance, _) => Pixel::Value(near.distance),
        (SliceField::Normal(component), _) => Pixel::Value(near.normal[component]),
        (SliceField::NormalAngle, Some(tree)) => {
            let line = (point - tree.closest(point, f64::INFINITY).point).normalize_or_zero();
            // By the half angle's tangent, which is exact for small angles too; either direction of the line
            // counts.
            let [sum, difference] = [(near.normal + line).length(), (near.normal - line).length()];
            let known = line != DVec3::ZERO && near.normal != DVec3::ZERO;
            match known {
                true => Pixel::Value(2.0 * sum.min(difference).atan2(sum.max(difference)).to_degrees()),
                false => Pixel::Unknown,
            }
        }
        (SliceField::NormalAngle, None) | (SliceField::Density, _) => Pixel::Unknown,
    }
}

fn lines(raster: &Raster, distances: &[f64], settings: &SliceSettings, mesh: Option<NamedMesh>) -> Vec<Line> {
    let lattice = &raster.lattice;
    let value = |pixel: &Pixel| match pixel {
        Pixel::Value(x) => *x,
        _ => f64::NAN,
    };
    let mut lines = Vec::new();
    if !settings.contours.is_empty() {
        let values: Vec<f64> = raster.pixels.iter().map(value).collect();
        let curves = settings.contours.iter().flat_map(|level| contours(lattice, &values, *level)).collect();
        let levels: Vec<String> = settings.contours.iter().map(|level| typeset(&number(*level))).collect();
        let Quantity { name, unit } = quantity(settings.field);
        let colour = if matches!(colouring(settings.field), Colouring::Linear(ColourMap::BlueRed, _)) {
            BLACK
        } else {
            WHITE
        };
        lines.push(Line {
            width: 0.6,
            ..Line::new(format!("{name} {} {unit}", levels.join(", ")), curves, colour)
        });
    }
    // The mesh below, wide: where both agree it is the edge of the other.
    if let Some(NamedMesh { mesh, name }) = mesh {
        lines.push(Line { width: 2.0, ..Line::new(name, section(mesh, lattice), DISTINCT[1]) });
    }
    let width = if mesh.is_some() { 0.7 } else { 1.0 };
    lines.push(Line { width, ..Line::new("surface of the map", contours(lattice, distances, 0.0), BLACK) });
    lines
}

fn quantity(field: SliceField) -> Quantity {
    match field {
        SliceField::Volume => Quantity::new("volume", "m³"),
        SliceField::Density => Quantity::new("boundary density / rest density", ""),
        SliceField::Distance => Quantity::new("distance", "m"),
        SliceField::Normal(component) => {
            Quantity::new(format!("{} of the normal", ["x", "y", "z"][component.min(2)]), "")
        }
        SliceField::NormalAngle => Quantity::new("error of the normal", "degrees"),
    }
}

fn colouring(field: SliceField) -> Colouring {
    match field {
        SliceField::Volume | SliceField::Density => Colouring::Linear(ColourMap::Viridis, Limits::Auto),
        SliceField::Distance => Colouring::Linear(ColourMap::BlueRed, Limits::Auto),
        SliceField::Normal(_) => Colouring::Linear(ColourMap::BlueRed, Limits::Given([-1.0, 1.0])),
        SliceField::NormalAngle => Colouring::Log(ColourMap::Viridis, Limits::Auto),
    }
}

/// The numbers as a table: x, y, z in metres, value, region (`band`, `outside`, `deep_inside`).
///
/// # Errors
/// What `out` reports.
pub fn write_csv(raster: &Raster, mut out: impl Write) -> std::io::Result<()> {
    writeln!(out, "x,y,z,value,region")?;
    for (point, pixel) in raster.lattice.points().into_iter().zip(&raster.pixels) {
        write!(out, "{},{},{},", point.x, point.y, point.z)?;
        match pixel {
            Pixel::Value(value) => writeln!(out, "{value},band")?,
            Pixel::Unknown => writeln!(out, ",band")?,
            Pixel::Fluid => writeln!(out, ",outside")?,
            Pixel::Solid => writeln!(out, ",deep_inside")?,
        }
    }
    Ok(())
}
