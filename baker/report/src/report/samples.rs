//! Random points of the band, from a seed.

use glam::{DVec3, UVec3};
use volmap_bake::random::Random;
use volmap_formats::asset::CellRun;
use volmap_runtime::Grid;

/// Points spread evenly over the volume of the stored cells, of which there is at least one.
pub fn band_points(grid: &Grid, band: &[CellRun], count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = Random::new(seed);
    let mut cells = 0;
    let ends: Vec<u64> = band
        .iter()
        .map(|run| {
            cells += u64::from(run.len);
            cells
        })
        .collect();
    let point = |_| {
        let cell = (random.unit() * cells as f64) as u64;
        let at = ends.partition_point(|&end| end <= cell).min(band.len() - 1);
        let run = band[at];
        let i = run.i + run.len - 1 - (ends[at] - 1 - cell.min(ends[at] - 1)) as u32;
        let inside = DVec3::new(random.unit(), random.unit(), random.unit());
        grid.origin + grid.cell_size * (UVec3::new(i, run.j, run.k).as_dvec3() + inside)
    };
    (0..count).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_the_cells_and_nothing_else() {
        let grid = Grid {
            origin: DVec3::new(-1.0, 2.0, 0.0),
            cell_size: DVec3::new(0.5, 1.0, 2.0),
            resolution: UVec3::new(9, 4, 5),
        };
        let band = [(2, 1, 0, 3), (8, 3, 4, 1)].map(|(i, j, k, len)| CellRun { i, j, k, len });
        let mut counts = [0; 4];
        for p in band_points(&grid, &band, 4000, 7) {
            let cell = ((p - grid.origin) / grid.cell_size).floor().as_uvec3().to_array();
            let known = [[2, 1, 0], [3, 1, 0], [4, 1, 0], [8, 3, 4]];
            counts[known.iter().position(|own| *own == cell).unwrap_or_else(|| panic!("{p}"))] += 1;
        }
        assert!(counts.iter().all(|n| (850..1150).contains(n)), "{counts:?}");
    }
}
