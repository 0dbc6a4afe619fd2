//! The whole bake: a mesh in, an asset out.

use crate::describe;
use crate::error::Error;
use crate::input::{Input, Source, bounds};
use crate::maps::{Maps, Stage, compute_maps};
use crate::mesh::{Diagnosis, OrientationRepair, Prepared, prepare};
use crate::plan::{Extent, Plan, Precision, Settings, plan};
use crate::rows::positions;
use crate::sdf::boundary_distance::BoundaryDistance;
use crate::sdf::sign::SignChoice;
use crate::sdf::{MeshDistance, SignComparison, SignMethod, compare_signs};
use glam::DVec3;
use std::time::Instant;
use volmap_formats::asset::{Array, Asset, QuadratureSpec};
use volmap_formats::mesh::{CleanReport, Placement};

/// What a bake depends on beside the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeSettings {
    /// Grid, field and rule.
    pub map: Settings,
    /// How inside and outside are told apart.
    pub sign: SignMethod,
    /// Leave the triangles' orientation as it comes.
    pub keep_orientation: bool,
    /// Compare both signs at every node.
    pub check_sign: bool,
}

/// A baked asset and what there is to say of it.
#[derive(Clone, Debug)]
pub struct Bake {
    /// The asset.
    pub asset: Asset,
    /// What there is to say.
    pub summary: Summary,
}

/// What a person wants to know of a bake.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The mesh's file.
    pub source: Source,
    /// What cleaning did.
    pub cleaning: CleanReport,
    /// What was done to the file's coordinates.
    pub placement: Placement,
    /// Box of the placed mesh, metres.
    pub bounds: [DVec3; 2],
    /// What is wrong with the mesh, after the repair.
    pub diagnosis: Diagnosis,
    /// What orienting did.
    pub repair: OrientationRepair,
    /// The sign in use.
    pub sign: SignChoice,
    /// Where the two signs differ, if that was asked for.
    pub sign_comparison: Option<SignComparison>,
    /// The grid and the estimate of the cost.
    pub plan: Plan,
    /// Cells of the grid, of the band and beyond it in the solid.
    pub cells: CellCounts,
    /// Nodes of the band.
    pub nodes: usize,
    /// Bytes of both fields if every cell of the grid were stored, and for the band alone.
    pub field_bytes: [u64; 2],
    /// Stages and their seconds, in order.
    pub seconds: Vec<(&'static str, f64)>,
    /// What a careful person would look at.
    pub warnings: Vec<String>,
}

/// Cells by kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellCounts {
    /// Of the whole grid.
    pub grid: u64,
    /// Stored.
    pub band: u64,
    /// Deeper in the solid than the band.
    pub solid: u64,
}

/// Steps of a bake, for progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Diagnosis and orientation of the mesh, and the tree for its distance.
    Mesh,
    /// Part of the fields.
    Field(Stage),
    /// Comparison of the signs.
    CheckSign,
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
    let plan = plan(&Extent { min, max, area: diagnosis.area }, &settings.map)?;
    on_plan(&plan);
    let phi = BoundaryDistance {
        mesh: MeshDistance::new(&input.mesh, settings.sign, &diagnosis),
        invert: settings.map.invert,
        thickness: settings.map.thickness,
    };
    let maps = compute_maps(&plan, settings.map.rule, &phi, &mut |stage| {
        match stage {
            Stage::Band => clock.lap("tree"),
            Stage::Distance => clock.lap("band"),
            Stage::Volume => clock.lap("distance"),
        }
        on_step(Step::Field(stage));
    })?;
    clock.lap("volume");
    let sign_comparison = settings.check_sign.then(|| {
        on_step(Step::CheckSign);
        let comparison = compare_signs(&phi.mesh, &positions(&maps.nodes, &plan.grid));
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
        field_bytes: field_bytes(&plan, &maps, settings.map.precision),
        seconds: clock.laps,
        warnings: Vec::new(),
        source: input.source.clone(),
        cleaning: input.cleaning.clone(),
        placement: input.placement,
        plan,
    };
    let summary = Summary { warnings: describe::warnings(&summary, &maps, settings), ..summary };
    let asset = asset(maps, &input, &summary, settings);
    Ok(Bake { asset, summary })
}

/// Wall time of the stages.
struct Clock {
    last: Instant,
    laps: Vec<(&'static str, f64)>,
}

impl Clock {
    fn lap(&mut self, name: &'static str) {
        let now = Instant::now();
        self.laps.push((name, (now - self.last).as_secs_f64()));
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

fn field_bytes(plan: &Plan, maps: &Maps, precision: Precision) -> [u64; 2] {
    let [x, y, z] = plan.grid.resolution.to_array().map(u64::from);
    let corners = (x + 1) * (y + 1) * (z + 1);
    let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
    let size = if precision == Precision::F32 { 4 } else { 8 };
    [corners + 2 * edges, maps.nodes.count() as u64].map(|nodes| 2 * size * nodes)
}

fn asset(maps: Maps, input: &Input, summary: &Summary, settings: &BakeSettings) -> Asset {
    let rule = settings.map.rule;
    let stored = |values: Vec<f64>| match settings.map.precision {
        Precision::F32 => Array::F32(values.into_iter().map(|x| x as f32).collect()),
        Precision::F64 => Array::F64(values),
    };
    Asset {
        grid: summary.plan.grid.into(),
        support_radius: summary.plan.support_radius,
        exterior: summary.plan.exterior,
        quadrature: QuadratureSpec {
            name: rule.to_string(),
            degree: rule.degree(),
            points: rule.points().len() as u64,
            ball_volume: rule.ball_volume(summary.plan.support_radius),
        },
        band_cells: maps.cells.band,
        solid_cells: maps.cells.solid,
        signed_distance: stored(maps.distance),
        volume: stored(maps.volume),
        bake: describe::parameters(input, summary, settings),
        source: describe::source(input, summary),
        diagnosis: describe::diagnosis(summary),
    }
}
