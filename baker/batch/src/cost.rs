//! What an asset will cost, before it is made: for the order of a batch, its memory, its shards, and `--check`.

use super::job::{BakeInput, Cost, Estimate};
use crate::error::Error;
use volmap_bake::bake::plan_bake;
use volmap_bake::input;
use volmap_bake::plan::plan;
use volmap_bake::watch::Watch;

/// Measured on one core of an AMD EPYC, over the 206 meshes of `BENCHMARKS.md`: right to a third for half of the closed
/// ones, to a factor of 3 for most open ones, whose winding numbers take what they take.
const MAP: f64 = 0.22;
const SECONDS_PER_ASSET: f64 = 0.05;
const SECONDS_PER_TRIANGLE: f64 = 1e-5;
const SECONDS_PER_ERROR_POINT: f64 = 0.7e-3;
const SECONDS_PER_NODE_OF_OPEN: f64 = 5e-6;
const BYTES_PER_TRIANGLE: u64 = 400;
/// Measured on eleven meshes of 2 to 50,000 triangles, on 5,600 to 280,000 cells.
const REPORT_SECONDS: f64 = 4.0;
const REPORT_SECONDS_OF_OPEN: f64 = 2.0;
const REPORT_SECONDS_PER_CELL: f64 = 1.4e-5;
const REPORT_MEMORY: u64 = 40 << 20;
const REPORT_BYTES_PER_CELL: u64 = 220;
/// Of the worker itself.
const LEAST_MEMORY: u64 = 16 << 20;
/// A search for a tolerance bakes several grids, the finest of which is not known before.
const SEARCH: f64 = 6.0;
/// Of the fields' bytes, after compression.
const COMPRESSED: f64 = 0.75;
const NODES_PER_CELL: f64 = 7.5;

/// Estimates the cost of an asset, from the plan of its bake.
///
/// # Errors
/// A mesh that can't be read, or settings that can't be used with it; cancelled.
pub fn cost(source: &BakeInput, max_memory: u64, watch: &Watch) -> Result<Estimate, Error> {
    let mut recipe = source.parameters.recipe();
    recipe.bake.map.max_memory = max_memory;
    let settings = &recipe.bake.map;
    let explained = |error| source.parameters.explain(error);
    let input = input::load(&source.mesh, &recipe.input)?;
    let planned = plan_bake(input, &recipe.bake, watch).map_err(explained)?;
    let is_search = planned.plan().is_none();
    let lengths = planned.lengths();
    let estimate = match planned.plan() {
        Some(plan) => plan.estimate,
        None => plan(planned.extent(), settings).map_err(|error| explained(lengths.explain(error)))?.estimate,
    };
    let triangles = planned.input().mesh.triangles.len();
    let fields = 2.0 + f64::from(u8::from(settings.density.is_some()));
    let nodes = NODES_PER_CELL * estimate.cells as f64;
    let open = if planned.diagnosis().closed { 0.0 } else { nodes * SECONDS_PER_NODE_OF_OPEN };
    let map_seconds = (MAP * estimate.seconds + open) * if is_search { SEARCH } else { 1.0 };
    let of_mesh = triangles as u64 * BYTES_PER_TRIANGLE + LEAST_MEMORY;
    let (report_seconds, report_memory) = match source.report {
        true => report_cost(estimate.cells, planned.diagnosis().closed),
        false => (0.0, 0),
    };
    let cost = Cost {
        seconds: SECONDS_PER_ASSET
            + map_seconds
            + triangles as f64 * SECONDS_PER_TRIANGLE
            + f64::from(source.error_points) * SECONDS_PER_ERROR_POINT
            + report_seconds,
        memory: estimate.memory.max(report_memory) + of_mesh,
        file: (nodes * fields * settings.precision.bytes() as f64 * COMPRESSED) as u64,
    };
    let warnings = lengths.suspicion().into_iter().collect();
    Ok(Estimate { cost, length: lengths.suspicion().unwrap_or_else(|| lengths.told()), warnings })
}

/// Seconds on one thread, and bytes, of a report on so many cells. Most of it are integrals at a fixed number of points
/// and pixels, whatever the mesh.
fn report_cost(cells: u64, closed: bool) -> (f64, u64) {
    let open = if closed { 0.0 } else { REPORT_SECONDS_OF_OPEN };
    let seconds = REPORT_SECONDS + open + cells as f64 * REPORT_SECONDS_PER_CELL;
    (seconds, REPORT_MEMORY + cells * REPORT_BYTES_PER_CELL)
}
