//! The whole bake: a mesh in, an asset out.

use crate::density_map::compute_density;
use crate::describe;
use crate::error::Error;
use crate::input::{Input, bounds};
use crate::maps::{Maps, Stage, compute_maps};
use crate::mesh::{Prepared, prepare};
use crate::plan::{Extent, GridChoice, Plan, Precision, Settings, plan};
use crate::rows::positions;
use crate::sdf::boundary_distance::BoundaryDistance;
use crate::sdf::{MeshDistance, compare_signs};
use crate::tolerance::{Found, Problem, search};
use crate::work::Work;
use std::time::Instant;
use volmap_formats::asset::{Array, Asset, Dimension, QuadratureSpec, Rounded};

pub use crate::recipe::BakeSettings;
pub use crate::summary::{CellCounts, Rounding, Summary};

/// A baked asset and what there is to say of it.
#[derive(Clone, Debug)]
pub struct Bake {
    /// The asset.
    pub asset: Asset,
    /// What there is to say.
    pub summary: Summary,
}

/// Steps of a bake, for progress.
#[derive(Clone, Debug)]
pub enum Step {
    /// Diagnosis and orientation of the mesh, and the tree for its distance.
    Mesh,
    /// Part of the fields.
    Field(Stage),
    /// Comparison of the signs.
    CheckSign,
}

impl Step {
    /// In words.
    pub fn name(&self) -> &'static str {
        match self {
            Step::Mesh => "examining the mesh",
            Step::Field(Stage::Reference(_)) => "measuring the exact volume",
            Step::Field(Stage::Band(_)) => "finding the band",
            Step::Field(Stage::Distance(_)) => "sampling the distance",
            Step::Field(Stage::Volume(_)) => "integrating the volume",
            Step::Field(Stage::Density(_)) => "computing the density",
            Step::CheckSign => "comparing the signs",
        }
    }

    /// How far it is, if it counts.
    pub fn work(&self) -> Option<&Work> {
        match self {
            Step::Field(
                Stage::Reference(work)
                | Stage::Band(work)
                | Stage::Distance(work)
                | Stage::Volume(work)
                | Stage::Density(work),
            ) => Some(work),
            Step::Mesh | Step::CheckSign => None,
        }
    }
}

/// Bakes a mesh. `on_plan` sees the plan before anything large is computed, `on_step` the beginning of each step.
///
/// # Errors
/// Settings that can't be used with this mesh, or a bake over the memory limit.
pub fn bake(
    mut input: Input,
    settings: &BakeSettings,
    on_plan: &mut dyn FnMut(&Plan),
    on_step: &mut dyn FnMut(Step),
) -> Result<Bake, Error> {
    let mut clock = Clock { last: Instant::now(), laps: Vec::new() };
    on_step(Step::Mesh);
    let Prepared { repair, diagnosis, .. } = prepare(&mut input.mesh, settings.keep_orientation);
    clock.lap("mesh");
    let [min, max] = bounds(&input.mesh);
    let extent = Extent { min, max, area: diagnosis.area };
    if !matches!(settings.map.grid, GridChoice::Tolerance(_)) {
        on_plan(&plan(&extent, &settings.map)?);
    }
    let phi = BoundaryDistance {
        mesh: MeshDistance::new(&input.mesh, settings.sign, &diagnosis),
        invert: settings.map.invert,
        thickness: settings.map.thickness,
    };
    let problem = Problem { mesh: &input.mesh, extent: &extent, phi: &phi };
    let mut stage_name = "tree";
    let mut enter = |stage: Stage| {
        clock.lap(std::mem::replace(&mut stage_name, stage.name()));
        on_step(Step::Field(stage));
    };
    let (plan, mut maps, tolerance) = fields(&problem, settings, &mut enter)?;
    if let Some(density) = &settings.map.density {
        maps.density = Some(compute_density(&plan, density, &phi, &maps, &mut enter)?);
    }
    clock.lap(stage_name);
    let sign_comparison = settings.check_sign.then(|| {
        on_step(Step::CheckSign);
        let comparison = compare_signs(&phi.mesh, &positions(&maps.nodes, &plan.grid).collect::<Vec<_>>());
        clock.lap("check");
        comparison
    });
    let summary = Summary {
        bounds: [min, max],
        diagnosis,
        repair,
        sign: phi.mesh.sign_choice().clone(),
        sign_comparison,
        cells: cell_counts(&plan, &maps),
        nodes: maps.nodes.count(),
        tolerance,
        field_bytes: field_bytes(&plan, &maps, &settings.map),
        density: settings.map.density,
        rounding: None,
        seconds: clock.laps,
        warnings: Vec::new(),
        source: input.source.clone(),
        cleaning: input.cleaning.clone(),
        placement: input.placement,
        plan,
    };
    let summary = Summary { warnings: describe::warnings(&summary, &maps, settings), ..summary };
    asset(maps, &input, summary, settings)
}

/// The grid and the fields on it, after a search if a tolerance is asked for.
fn fields(
    problem: &Problem<BoundaryDistance>,
    settings: &BakeSettings,
    enter: &mut dyn FnMut(Stage),
) -> Result<(Plan, Maps, Option<Found>), Error> {
    if let GridChoice::Tolerance(tolerance) = settings.map.grid {
        let (plan, maps, found) = search(problem, &settings.map, tolerance, enter)?;
        return Ok((plan, maps, Some(found)));
    }
    let plan = plan(problem.extent, &settings.map)?;
    let maps = compute_maps(&plan, settings.map.rule, problem.phi, enter)?;
    Ok((plan, maps, None))
}

/// Wall time of the stages.
struct Clock {
    last: Instant,
    laps: Vec<(&'static str, f64)>,
}

impl Clock {
    fn lap(&mut self, name: &'static str) {
        let now = Instant::now();
        let seconds = (now - self.last).as_secs_f64();
        // A search goes through the stages several times.
        match self.laps.iter_mut().find(|lap| lap.0 == name) {
            Some(lap) => lap.1 += seconds,
            None => self.laps.push((name, seconds)),
        }
        self.last = now;
    }
}

fn cell_counts(plan: &Plan, maps: &Maps) -> CellCounts {
    let n = plan.grid.resolution;
    CellCounts {
        grid: u64::from(n.x) * u64::from(n.y) * u64::from(n.z),
        band: maps.cells.band_count(),
        solid: maps.cells.solid.iter().map(|run| u64::from(run.len)).sum(),
    }
}

fn field_bytes(plan: &Plan, maps: &Maps, settings: &Settings) -> [u64; 2] {
    let [x, y, z] = plan.grid.resolution.to_array().map(u64::from);
    let corners = (x + 1) * (y + 1) * (z + 1);
    let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
    let fields = 2 + u64::from(settings.density.is_some());
    [corners + 2 * edges, maps.nodes.count() as u64].map(|nodes| fields * settings.precision.bytes() * nodes)
}

fn asset(maps: Maps, input: &Input, mut summary: Summary, settings: &BakeSettings) -> Result<Bake, Error> {
    let rule = settings.map.rule;
    let quadrature = QuadratureSpec {
        name: rule.to_string(),
        degree: rule.degree(),
        points: rule.points().len() as u64,
        ball_volume: rule.ball_volume(summary.plan.support_radius),
    };
    let (r, ball) = (summary.plan.support_radius, quadrature.ball_volume);
    let (signed_distance, distance_change) = stored(maps.distance, r, settings.map.precision)?;
    let (volume, volume_change) = stored(maps.volume, ball, settings.map.precision)?;
    let density = maps.density.map(|values| stored(values, 1.0, settings.map.precision)).transpose()?;
    let (density, density_change) = density.unzip();
    if let Precision::Rounded(allowed) = settings.map.precision {
        let [distance, volume, density] = [distance_change, volume_change, density_change.unwrap_or(0.0)];
        summary.rounding = Some(Rounding { allowed, distance, volume, density });
    }
    let asset = Asset {
        dimension: Dimension::Three,
        grid: summary.plan.grid.into(),
        support_radius: r,
        exterior: summary.plan.exterior,
        quadrature,
        band_cells: maps.cells.band,
        solid_cells: maps.cells.solid,
        signed_distance,
        volume,
        density: settings.map.density.zip(density).map(|(density, values)| density.field(r, values)),
        bake: describe::parameters(input, &summary, settings),
        source: describe::source(input, &summary),
        diagnosis: describe::diagnosis(&summary),
    };
    Ok(Bake { asset, summary })
}

/// A field as it is stored, and, where it is rounded to parts of `unit`, the largest change in that unit.
pub(crate) fn stored(values: Vec<f64>, unit: f64, precision: Precision) -> Result<(Array, f64), Error> {
    match precision {
        Precision::F32 => Ok((Array::F32(values.into_iter().map(|x| x as f32).collect()), 0.0)),
        Precision::F64 => Ok((Array::F64(values), 0.0)),
        Precision::Rounded(part) => {
            let rounded = Rounded::new(&values, unit, part);
            let rounded = rounded.map_err(|error| Error::setting("max_rounding", error.to_string()))?;
            let worst = rounded.worst_error(&values);
            Ok((Array::Rounded(rounded), worst / unit))
        }
    }
}
