//! The map itself as cells of VTK, exactly: the 32 shape functions of the cubic Serendipity element lie in the space
//! of the 64 products of cubics, so a Lagrange hexahedron of degree 3 with the element's values at its 64 points is the
//! same function. The points are the thirds of the cells; neighbours share theirs.

use super::values;
use crate::error::Error;
use glam::UVec3;
use volmap_bake::watch::Watch;
use volmap_formats::asset::{Asset, CellRun};
use volmap_formats::export::vtkhdf::{CubicHexahedra, POINTS};
use volmap_runtime::layout::serendipity::{NODES, THIRDS, shape};
use volmap_runtime::layout::{Cell, CellIndex, Family, Nodes};
use volmap_runtime::{DVec3, Grid, VolumeMap};

/// Both fields on the band's cells. Points and values are of double precision, whatever that of the asset.
///
/// # Errors
/// An asset that isn't consistent, or too many cells; cancelled.
pub fn hexahedra(asset: &Asset, watch: &Watch) -> Result<CubicHexahedra, Error> {
    watch.step("finding the cells' points")?;
    let grid = *VolumeMap::from_asset(asset)?.grid();
    let too_many = || Error::setting("output", "a .vtkhdf file can't have that many cells; take .vti");
    let thirds = Nodes::new(3 * grid.resolution, &in_thirds(&asset.band_cells)).ok_or_else(too_many)?;
    let cells = cells(&asset.band_cells, &thirds);
    let points = points(&grid, &thirds);
    watch.step("finding the points' values")?;
    let fields = [values(&asset.signed_distance), values(&asset.volume)];
    let [distance, volume] = spread(asset, &fields, &cells, points.len())?;
    Ok(CubicHexahedra {
        points,
        cells,
        point_data: vec![("signed_distance", distance), ("volume", volume)],
        field_data: vec![("support_radius", asset.support_radius)],
    })
}

/// The runs on a grid three times as fine.
fn in_thirds(runs: &[CellRun]) -> Vec<CellRun> {
    let third = |run: &CellRun, b: u32| CellRun {
        i: 3 * run.i,
        j: 3 * run.j + b % 3,
        k: 3 * run.k + b / 3,
        len: 3 * run.len,
    };
    let mut out: Vec<CellRun> = runs.iter().flat_map(|run| (0..9).map(move |b| third(run, b))).collect();
    out.sort_unstable_by_key(|run| (run.k, run.j, run.i));
    out
}

fn points(grid: &Grid, thirds: &Nodes) -> Vec<[f64; 3]> {
    let place =
        |i: u32, j: u32, k: u32| grid.origin + grid.cell_size * (UVec3::new(i, j, k).as_dvec3() / 3.0);
    let rows = thirds.intervals(Family::Corner);
    rows.flat_map(|(j, k, row)| (row.first..row.end).map(move |i| place(i, j, k).to_array())).collect()
}

/// The points of each cell, at the thirds (a, b, c): number a + 4 b + 16 c.
fn cells(runs: &[CellRun], thirds: &Nodes) -> Vec<[u32; POINTS]> {
    let mut out = Vec::new();
    for run in runs {
        let row = |p: u32| thirds.number(Family::Corner, 3 * run.i, 3 * run.j + p % 4, 3 * run.k + p / 4);
        let first: [u32; 16] = std::array::from_fn(|p| row(p as u32));
        out.extend((0..run.len).map(|step| -> [u32; POINTS] {
            std::array::from_fn(|p| first[p / 4] + 3 * step + p as u32 % 4)
        }));
    }
    out
}

/// The values of the 32 shape functions at each point of a cell; at the nodes exactly 1 and 0.
fn weights() -> Vec<[f64; NODES]> {
    let place = |p: u32| UVec3::new(p % 4, p / 4 % 4, p / 16);
    let at = |place: UVec3| match (0..NODES).find(|&a| UVec3::from(THIRDS[a].map(u32::from)) == place) {
        Some(own) => std::array::from_fn(|a| f64::from(u8::from(a == own))),
        None => shape(place.as_dvec3() / 1.5 - DVec3::ONE),
    };
    (0..POINTS as u32).map(|p| at(place(p))).collect()
}

/// The fields' values at the points, element by element.
fn spread(
    asset: &Asset,
    fields: &[Vec<f64>; 2],
    cells: &[[u32; POINTS]],
    points: usize,
) -> Result<[Vec<f64>; 2], Error> {
    let weights = weights();
    let mut out = [vec![0.0; points], vec![0.0; points]];
    for (numbers, cell) in band_nodes(asset)?.iter().zip(cells) {
        for (field, out) in fields.iter().zip(&mut out) {
            let nodes = numbers.map(|number| field[number as usize]);
            for (&point, weights) in cell.iter().zip(&weights) {
                out[point as usize] = weights.iter().zip(&nodes).map(|(w, x)| w * x).sum();
            }
        }
    }
    Ok(out)
}

/// The nodes of each cell of the band, in the order of the runs.
pub(super) fn band_nodes(asset: &Asset) -> Result<Vec<[u32; NODES]>, Error> {
    let resolution = asset.grid.resolution.into();
    let nodes = Nodes::new(resolution, &asset.band_cells)
        .ok_or_else(|| Error::setting("asset", "has more than 2^32 nodes"))?;
    let index = CellIndex::new(resolution, &asset.band_cells, &[], &nodes);
    let cells =
        asset.band_cells.iter().flat_map(|run| (run.i..run.i + run.len).map(|i| UVec3::new(i, run.j, run.k)));
    let numbers = cells.filter_map(|cell| match index.find(cell) {
        Cell::Band(numbers) => Some(numbers.all()),
        Cell::Solid | Cell::Fluid => None,
    });
    Ok(numbers.collect())
}
