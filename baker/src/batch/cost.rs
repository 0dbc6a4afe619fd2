//! What an asset will cost, before it is made: for the order of a batch, its memory, its shards, and `--check`.

use super::job::{Cost, Subject};
use crate::error::Error;
use crate::input::{self, bounds};
use crate::plan::{Extent, GridChoice, plan};
use glam::DVec3;
use volmap_formats::mesh::TriangleMesh;

/// Measured on one core of an AMD EPYC, over the meshes of `BENCHMARKS.md`.
const SECONDS_PER_TRIANGLE: f64 = 3e-6;
const SECONDS_PER_ERROR_POINT: f64 = 1e-3;
const BYTES_PER_TRIANGLE: u64 = 400;
/// Of the worker itself.
const LEAST_MEMORY: u64 = 16 << 20;
/// A search for a tolerance bakes several grids, the finest of which is not known before.
const SEARCH: f64 = 6.0;
/// Of the fields' bytes, after compression.
const COMPRESSED: f64 = 0.75;
const NODES_PER_CELL: f64 = 7.5;

/// Estimates the cost of an asset.
///
/// # Errors
/// A mesh that can't be read, or settings that can't be used with it.
pub fn cost(subject: &Subject, max_memory: u64) -> Result<Cost, Error> {
    let recipe = subject.parameters.recipe();
    let mesh = input::load(&subject.mesh, &recipe.input)?.mesh;
    let [min, max] = bounds(&mesh);
    let mut settings = recipe.bake.map.clone();
    settings.max_memory = max_memory;
    let planned = plan(&Extent { min, max, area: area(&mesh) }, &settings)?;
    let triangles = mesh.triangles.len();
    let fields = 2.0 + f64::from(u8::from(settings.density.is_some()));
    let nodes = NODES_PER_CELL * planned.estimate.cells as f64;
    let is_search = matches!(settings.grid, GridChoice::Tolerance(_));
    let map_seconds = planned.estimate.seconds * if is_search { SEARCH } else { 1.0 };
    Ok(Cost {
        seconds: map_seconds
            + triangles as f64 * SECONDS_PER_TRIANGLE
            + f64::from(subject.error_points) * SECONDS_PER_ERROR_POINT,
        memory: planned.estimate.memory + triangles as u64 * BYTES_PER_TRIANGLE + LEAST_MEMORY,
        file: (nodes * fields * settings.precision.bytes() as f64 * COMPRESSED) as u64,
    })
}

fn area(mesh: &TriangleMesh) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.vertices[v as usize]);
    let twice = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
    0.5 * mesh.triangles.iter().map(|triangle| twice(triangle.map(corner))).sum::<f64>()
}
