//! Where inside meets outside without a surface between: the sign of an open mesh jumps across a hole that is wider
//! than the band.

use super::band::BandCells;
use glam::UVec3;
use volmap_formats::asset::CellRun;

/// Number of faces between a cell deep in the solid and one far outside.
pub fn leaks(resolution: UVec3, cells: &BandCells) -> u64 {
    let mut known = [cells.band.as_slice(), &cells.solid].concat();
    known.sort_unstable_by_key(|run| (run.k, run.j, run.i));
    let n = [resolution.x, resolution.y, resolution.z].map(i64::from);
    let around = |run: &CellRun| {
        let [i, j, k, len] = [run.i, run.j, run.k, run.len].map(i64::from);
        let row = |j: i64, k: i64, from: i64, to: i64| {
            let (from, to) = (from.max(0), to.min(n[0]));
            let inside = (0..n[1]).contains(&j) && (0..n[2]).contains(&k) && from < to;
            if inside {
                (to - from) as u64 - covered(&known, [j as u32, k as u32], from as u32, to as u32)
            } else {
                0
            }
        };
        let across: u64 =
            [(-1, 0), (1, 0), (0, -1), (0, 1)].iter().map(|(dj, dk)| row(j + dj, k + dk, i, i + len)).sum();
        across + row(j, k, i - 1, i) + row(j, k, i + len, i + len + 1)
    };
    cells.solid.iter().map(around).sum()
}

/// Cells `from .. to` of a row that lie in one of the runs, which are sorted and don't overlap.
fn covered(runs: &[CellRun], [j, k]: [u32; 2], from: u32, to: u32) -> u64 {
    let first = runs.partition_point(|run| (run.k, run.j, run.i + run.len) <= (k, j, from));
    let in_row = runs[first..].iter().take_while(|run| (run.k, run.j) == (k, j) && run.i < to);
    in_row.map(|run| u64::from((run.i + run.len).min(to) - run.i.max(from))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_counted_once_from_the_solid_side() {
        let run = |i, j, k, len| CellRun { i, j, k, len };
        let n = UVec3::new(5, 3, 3);
        // A bar of 2 solid cells in the middle, nothing known around: 2 ends and 4 sides of 2.
        let bare = BandCells { band: vec![], solid: vec![run(1, 1, 1, 2)] };
        assert_eq!(leaks(n, &bare), 10);
        // Band on one side (two runs), at one end, and one cell of another side.
        let band = vec![run(2, 1, 0, 1), run(1, 0, 1, 1), run(2, 0, 1, 3), run(0, 1, 1, 1)];
        assert_eq!(leaks(n, &BandCells { band, ..bare }), 10 - 4);
        // The domain's faces are no leaks; two solid runs that touch leak nothing to each other.
        let slab =
            (0..9).flat_map(|row| [run(0, row % 3, row / 3, 2), run(2, row % 3, row / 3, 3)]).collect();
        assert_eq!(leaks(n, &BandCells { band: vec![], solid: slab }), 0);
    }
}
