//! A thin grid: a square lattice of bars, as in Bender et al. 2020, Fig. 13.
//!
//! The bars are occupied cells of a lattice of boxes whose spacing alternates between bar and hole. Only the
//! faces between an occupied and an empty cell become triangles, so bars that cross are properly united.

use glam::DVec3;

use crate::mesh::Mesh;

/// Holes along each of x and z.
pub const HOLES: usize = 9;
/// Edge of the bars' square section, m.
pub const BAR: f64 = 0.03;
/// Cells along a hole's edge, so that faces are about square.
const CELLS_PER_HOLE: usize = 3;

/// The grid: 1 m x 0.03 m x 1 m, in the plane y = 0, middle at the origin.
pub fn grid() -> Mesh {
    let (cuts, is_bar) = spacing();
    let heights = [-0.5 * BAR, 0.5 * BAR];
    let n = is_bar.len();
    let occupied = |i: usize, k: usize| i < n && k < n && (is_bar[i] || is_bar[k]);

    let mut points = Points { mesh: Mesh::default(), index: vec![u32::MAX; 2 * (n + 1) * (n + 1)], n };
    let position = |i: usize, j: usize, k: usize| DVec3::new(cuts[i], heights[j], cuts[k]);
    for k in 0..n {
        for i in (0..n).filter(|&i| occupied(i, k)) {
            let mut face = |corners: [[usize; 3]; 4]| {
                let quad = corners.map(|[di, j, dk]| points.get([i + di, j, k + dk], position));
                points.mesh.push_quad(quad);
            };
            face([[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]]);
            face([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]);
            if !occupied(i.wrapping_sub(1), k) {
                face([[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]]);
            }
            if !occupied(i + 1, k) {
                face([[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]);
            }
            if !occupied(i, k.wrapping_sub(1)) {
                face([[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]]);
            }
            if !occupied(i, k + 1) {
                face([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]);
            }
        }
    }
    points.mesh
}

/// The mesh and the vertex of each lattice point that has one.
struct Points {
    mesh: Mesh,
    index: Vec<u32>,
    n: usize,
}

impl Points {
    fn get(&mut self, [i, j, k]: [usize; 3], position: impl Fn(usize, usize, usize) -> DVec3) -> u32 {
        let slot = (k * 2 + j) * (self.n + 1) + i;
        if self.index[slot] == u32::MAX {
            self.index[slot] = self.mesh.push(position(i, j, k));
        }
        self.index[slot]
    }
}

/// Coordinates of the cuts along x (and z), m, and whether the cell after each cut but the last is a bar's.
fn spacing() -> (Vec<f64>, Vec<bool>) {
    let hole = (1.0 - (HOLES + 1) as f64 * BAR) / HOLES as f64;
    let (mut cuts, mut is_bar) = (Vec::new(), Vec::new());
    for number in 0..=HOLES {
        let start = -0.5 + number as f64 * (BAR + hole);
        cuts.push(start);
        is_bar.push(true);
        if number < HOLES {
            for cell in 0..CELLS_PER_HOLE {
                cuts.push(start + BAR + hole * cell as f64 / CELLS_PER_HOLE as f64);
                is_bar.push(false);
            }
        }
    }
    cuts.push(0.5);
    (cuts, is_bar)
}
