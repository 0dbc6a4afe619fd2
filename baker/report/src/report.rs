//! How exact an asset is: errors against references of order 100 and beyond, their parts, and pictures of them.
//!
//! ```text
//! asset (+ mesh, shape) -> model -> samples -> volume_error, distance_error, thin -> statistics -> figures, page, JSON
//! ```
//! The model is Fig. 6 of Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*: the map, its difference
//! to an order-100 integral at every pixel, the surface, the largest error.

pub mod density_error;
pub mod distance_error;
pub mod figures;
pub mod findings;
pub mod levels;
pub mod model;
pub mod page;
pub mod reference;
pub mod reference_check;
pub mod samples;
pub mod shape;
pub mod slices;
pub mod statistics;
pub mod thin;
pub mod views;
pub mod volume_error;

use crate::error::Error;
use figures::{Picture, level_pictures, slice_pictures, view_picture};
use findings::{Findings, findings};
use glam::DVec3;
use levels::LevelMap;
use model::{Model, Solid};
use reference_check::{ReferenceCheck, check_reference};
use shape::ClosedForm;
use slices::ErrorSlice;
use statistics::Measurement;
use thin::Width;
use views::View;
use volmap_bake::input::Input;
use volmap_bake::sdf::{compare_signs, points_near_surface};
use volmap_bake::watch::Watch;
use volmap_formats::asset::Asset;
use volume_error::{Measuring, VolumeSample};

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportSettings {
    /// Random points of the band.
    pub points: usize,
    /// How many of them are compared with the mesh.
    pub mesh_points: usize,
    /// How many of them by the paper's rule too, which takes long there.
    pub gl100_mesh_points: usize,
    /// Seed of the points.
    pub seed: u64,
    /// The shape that the mesh stands for.
    pub shape: Option<ClosedForm>,
    /// Largest error that passes, as a part of the full ball.
    pub max_error: Option<f64>,
    /// Pixels of the longest side of a slice; none are made of 0.
    pub pixels: usize,
}

impl Default for ReportSettings {
    fn default() -> ReportSettings {
        ReportSettings {
            points: 10_000,
            mesh_points: 1_000,
            gl100_mesh_points: 0,
            seed: 1,
            shape: None,
            max_error: None,
            pixels: 288,
        }
    }
}

/// Points at which the exact distance itself is checked, at most.
const CHECKED: usize = 2_000;

/// All that was measured.
pub struct Report {
    /// The figures, as they stand in the JSON file.
    pub findings: Findings,
    /// Slices through the middle of the solid and through the worst point.
    pub slices: Vec<ErrorSlice>,
    /// The cells that these slices cut, of an adaptive map.
    pub levels: Option<LevelMap>,
    /// The surface from three sides, and what is thin of it.
    pub views: Vec<View>,
    /// The mesh, if there is one.
    pub solid: Option<Solid>,
}

impl Report {
    /// Its pictures.
    pub fn pictures(&self) -> Vec<Picture> {
        let mesh = self.solid.as_ref().map(|solid| (&solid.mesh, solid.name.as_str()));
        let mut out = slice_pictures(&self.slices, mesh);
        out.extend(self.levels.iter().flat_map(|levels| level_pictures(&self.slices, levels)));
        let signs = self.findings.signs.iter().flat_map(|signs| &signs.worst);
        let disagreeing: Vec<DVec3> = signs.map(|(point, _)| DVec3::from(*point)).collect();
        out.extend(view_picture(&self.views, &disagreeing));
        out
    }
}

/// Measures an asset.
///
/// # Errors
/// An asset or a mesh that can't be used; cancelled.
pub fn report(
    asset: &Asset,
    mesh: Option<Input>,
    settings: &ReportSettings,
    watch: &Watch,
) -> Result<Report, Error> {
    watch.step("preparing")?;
    let model = Model::new(asset)?;
    if asset.band_count() == 0 {
        return Err(Error::setting("asset", "stores no cells; there is nothing to measure"));
    }
    let solid = mesh.map(|input| Solid::new(asset, input)).transpose()?;
    let shape = settings.shape.or_else(|| solid.as_ref().and_then(Solid::closed_form));
    let mut points =
        samples::band_points(&model.field.grid, &model.cells.band, settings.points, settings.seed);
    points.retain(|&point| model.counts(point));
    let measuring = Measuring {
        model: &model,
        solid: solid.as_ref(),
        shape,
        mesh_points: settings.mesh_points,
        gl100_mesh_points: settings.gl100_mesh_points,
    };
    let volumes = volume_error::measure(&measuring, &points, watch)?;
    let surface = match &solid {
        Some(solid) => Some(surface(asset, &model, solid, &points, watch)?),
        None => None,
    };
    let worst = findings::worst_point(&volumes);
    let slices = slices::slices(&model, worst, settings.pixels, watch)?;
    watch.step("drawing")?;
    let views = match (&solid, settings.pixels) {
        (Some(solid), pixels @ 1..) => views::views(&model, solid, pixels, watch)?,
        _ => Vec::new(),
    };
    let levels = LevelMap::new(asset);
    let measured =
        Measured { asset, model: &model, levels: levels.as_ref(), solid: solid.as_ref(), volumes, surface };
    let findings = findings(&measured, settings, &slices)?;
    watch.check()?;
    Ok(Report { findings, slices, levels, views, solid })
}

/// What was measured, before it is summed up.
pub struct Measured<'a> {
    /// The asset.
    pub asset: &'a Asset,
    /// The same, opened.
    pub model: &'a Model,
    /// Its cells, if they have several sizes.
    pub levels: Option<&'a LevelMap>,
    /// The solid.
    pub solid: Option<&'a Solid>,
    /// Volumes.
    pub volumes: Vec<VolumeSample>,
    /// What needs the mesh.
    pub surface: Option<SurfaceFindings>,
}

/// What needs the mesh.
pub struct SurfaceFindings {
    /// Errors of the density, if the asset has one.
    pub density: Option<Vec<Measurement>>,
    /// Errors of distance and normal.
    pub errors: distance_error::DistanceErrors,
    /// Where signs differ.
    pub signs: volmap_bake::sdf::SignComparison,
    /// What winding numbers say of the exact distance.
    pub reference: ReferenceCheck,
    /// Widths of walls and gaps at points spread over the surface.
    pub widths: Vec<Width>,
}

fn surface(
    asset: &Asset,
    model: &Model,
    solid: &Solid,
    points: &[DVec3],
    watch: &Watch,
) -> Result<SurfaceFindings, Error> {
    let (corners, numbers) = solid.phi.mesh.surface_triangles();
    let density = match &asset.density {
        Some(density) => density_error::measure(model, density, solid, points, watch)?,
        None => None,
    };
    let errors = distance_error::measure(model, solid, points, watch)?;
    let near = points_near_surface(&corners);
    let work = watch.begin("comparing the signs", near.len() as u64)?;
    let signs = compare_signs(&solid.phi.mesh, &near, &work)?;
    let checked = &points[..points.len().min(CHECKED)];
    let reference = check_reference(solid, checked, watch)?;
    let widths = thin::widths(solid, &thin::spread(&corners, &numbers), thin::reach(model), watch)?;
    Ok(SurfaceFindings { density, errors, signs, reference, widths })
}
