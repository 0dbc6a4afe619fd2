//! Cells of several levels: partition, balance, constrained nodes, on random trees and by closed forms.

use proptest::prelude::*;
use std::collections::{HashMap, HashSet};
use volmap_runtime::layout::{CellRun, Held, LevelCell, LevelCells, Levels, LevelsError, serendipity};
use volmap_runtime::{DVec3, Grid, UVec3};

/// Random numbers that depend on the seed alone.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.0 >> 33
    }

    fn unit(&mut self) -> f64 {
        self.roll() as f64 / (1u64 << 31) as f64
    }
}

fn grid(resolution: [u32; 3]) -> Grid {
    Grid {
        origin: DVec3::new(-0.3, 0.7, 1.1),
        cell_size: DVec3::new(0.5, 0.3, 0.7),
        resolution: resolution.into(),
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Band,
    Solid,
    Fluid,
}

/// Leaves by level and index. Kinds are drawn by leaf.
type Tree = HashMap<(u32, [u32; 3]), Kind>;

/// A balanced tree: random splits, then those that balance needs.
fn tree(resolution: [u32; 3], levels: u32, dice: &mut Dice) -> Tree {
    let mut leaves: HashSet<(u32, [u32; 3])> = HashSet::new();
    for n in 0..resolution.iter().product() {
        let [x, y, _] = resolution;
        leaves.insert((0, [n % x, n / x % y, n / (x * y)]));
    }
    for level in 0..levels - 1 {
        let mut of_level: Vec<_> = leaves.iter().copied().filter(|leaf| leaf.0 == level).collect();
        of_level.sort();
        for leaf in of_level {
            if dice.roll().is_multiple_of(4) {
                split(&mut leaves, leaf);
            }
        }
    }
    while let Some(leaf) = leaves.iter().copied().find(|&leaf| unbalanced(&leaves, leaf)) {
        split(&mut leaves, leaf);
    }
    let mut leaves: Vec<_> = leaves.into_iter().collect();
    leaves.sort();
    let kind = |dice: &mut Dice| match dice.roll() % 8 {
        0 => Kind::Solid,
        1 => Kind::Fluid,
        _ => Kind::Band,
    };
    leaves.into_iter().map(|leaf| (leaf, kind(dice))).collect()
}

fn split(leaves: &mut HashSet<(u32, [u32; 3])>, leaf: (u32, [u32; 3])) {
    leaves.remove(&leaf);
    for child in 0..8 {
        leaves.insert((leaf.0 + 1, [0, 1, 2].map(|axis| 2 * leaf.1[axis] + (child >> axis & 1))));
    }
}

/// Whether cells two levels finer touch it: a slow oracle.
fn unbalanced(leaves: &HashSet<(u32, [u32; 3])>, leaf: (u32, [u32; 3])) -> bool {
    leaves.iter().any(|&other| other.0 > leaf.0 + 1 && touch(leaf, other))
}

fn touch(coarse: (u32, [u32; 3]), fine: (u32, [u32; 3])) -> bool {
    let scale = 1 << (fine.0 - coarse.0);
    (0..3).all(|axis| {
        let (low, high) = (coarse.1[axis] * scale, (coarse.1[axis] + 1) * scale);
        fine.1[axis] <= high && fine.1[axis] + 1 >= low
    })
}

/// Single cells or, where neighbours are of a kind, runs.
fn lists(tree: &Tree, levels: u32) -> Vec<LevelCells> {
    let of = |level: u32, kind: Kind| {
        let mut cells: Vec<[u32; 3]> =
            tree.iter().filter(|(at, of)| at.0 == level && **of == kind).map(|(at, _)| at.1).collect();
        cells.sort_by_key(|&[i, j, k]| (k, j, i));
        let mut runs: Vec<CellRun> = Vec::new();
        for [i, j, k] in cells {
            match runs.last_mut() {
                Some(run) if (run.j, run.k, run.i + run.len) == (j, k, i) => run.len += 1,
                _ => runs.push(CellRun { i, j, k, len: 1 }),
            }
        }
        runs
    };
    (0..levels)
        .map(|level| LevelCells { band: of(level, Kind::Band), solid: of(level, Kind::Solid) })
        .collect()
}

fn random(seed: u64) -> (Tree, Levels) {
    let mut dice = Dice(seed);
    for _ in 0..10 {
        dice.roll();
    }
    let resolution = [1, 2, 3].map(|_| 1 + (dice.roll() % 3) as u32);
    let levels = 1 + (dice.roll() % 4) as u32;
    let tree = tree(resolution, levels, &mut dice);
    let levels = Levels::new(grid(resolution), &lists(&tree, levels)).expect("balanced");
    (tree, levels)
}

/// A place of the band in a cell, by its reference coordinates.
fn place(levels: &Levels, cell: &LevelCell, xi: DVec3) -> DVec3 {
    let grid = levels.grid(cell.level);
    grid.origin + grid.cell_size * (cell.index.as_dvec3() + 0.5 * (xi + DVec3::ONE))
}

fn value(cell: &LevelCell, xi: DVec3, values: &[f64]) -> f64 {
    serendipity::shape(xi).iter().zip(cell.nodes).map(|(shape, node)| shape * values[node as usize]).sum()
}

/// Every monomial of total degree 3 at most.
fn cubic(x: DVec3) -> f64 {
    let DVec3 { x, y, z } = x;
    1.0 + 2.0 * x - y + 0.5 * z + x * y - 2.0 * y * z + 3.0 * x * z + x * x - y * y
        + z * z * (1.0 - x + 2.0 * y)
        + x * y * z
        - 0.7 * x * x * x
        + y * y * y * 0.2
        - z * z * z
        + x * x * y
        - y * y * x
}

fn free_values(levels: &Levels, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let places = levels.positions();
    levels.free().map(|node| f(places[node as usize])).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_point_is_in_the_leaf_that_holds_it(seed: u64) {
        let (tree, levels) = random(seed);
        let cells: Vec<LevelCell> = levels.cells().collect();
        prop_assert_eq!(cells.len(), levels.cell_count());
        let places = levels.positions();
        for (number, cell) in cells.iter().enumerate() {
            prop_assert_eq!(number, cell.number);
            prop_assert!(tree[&(cell.level, cell.index.to_array())] == Kind::Band);
            for (a, &node) in cell.nodes.iter().enumerate() {
                let expected = place(&levels, cell, serendipity::node(a));
                prop_assert!((places[node as usize] - expected).length() < 1e-14);
            }
        }
        for (&(level, index), kind) in &tree {
            let grid = levels.grid(level);
            let middle = grid.cell_corner(UVec3::from(index)) + 0.5 * grid.cell_size;
            let lowest = grid.cell_corner(UVec3::from(index)) + 1e-9 * grid.cell_size;
            for point in [middle, lowest] {
                match (levels.find(point), kind) {
                    (Held::Band { number, level: found, xi }, Kind::Band) => {
                        let cell = &cells[number];
                        prop_assert_eq!((found, cell.level, cell.index.to_array()), (level, level, index));
                        prop_assert!((place(&levels, cell, xi) - point).length() < 1e-14);
                    }
                    (found, Kind::Solid) => prop_assert_eq!(found, Held::Solid),
                    (found, Kind::Fluid) => prop_assert_eq!(found, Held::Fluid),
                    (found, _) => prop_assert!(false, "{found:?}"),
                }
            }
        }
    }

    #[test]
    fn constrained_nodes_are_those_on_cells_of_the_level_before(seed: u64) {
        let (_, levels) = random(seed);
        let cells: Vec<LevelCell> = levels.cells().collect();
        let places = levels.positions();
        let mut level_of = vec![0; levels.count()];
        cells.iter().for_each(|cell| cell.nodes.iter().for_each(|&node| level_of[node as usize] = cell.level));
        let on = |cell: &LevelCell, node: usize| {
            let grid = levels.grid(cell.level);
            let u = (places[node] - grid.origin) / grid.cell_size - cell.index.as_dvec3();
            cell.level + 1 == level_of[node] && (-1e-9 <= u.min_element()) && u.max_element() <= 1.0 + 1e-9
        };
        let free: Vec<u32> = levels.free().collect();
        let expected: Vec<u32> = (0..levels.count() as u32)
            .filter(|&node| !cells.iter().any(|cell| on(cell, node as usize)))
            .collect();
        prop_assert_eq!(&free, &expected);
        prop_assert_eq!(free.len(), levels.free_count());
        let corners: HashSet<u32> = cells.iter().flat_map(|cell| cell.nodes[..8].to_vec()).collect();
        let corners: Vec<u32> = free.into_iter().filter(|node| corners.contains(node)).collect();
        prop_assert_eq!(levels.free_corners().collect::<Vec<_>>(), corners);
    }

    #[test]
    fn a_cubic_is_reproduced_everywhere(seed: u64) {
        let (_, levels) = random(seed);
        let values = levels.complete(&free_values(&levels, cubic));
        let mut dice = Dice(seed);
        for cell in levels.cells() {
            let xi = DVec3::from([0; 3].map(|_| 2.0 * dice.unit() - 1.0));
            let error = value(&cell, xi, &values) - cubic(place(&levels, &cell, xi));
            prop_assert!(error.abs() < 1e-11, "{error}");
        }
    }

    #[test]
    fn values_and_weights_are_continuous_at_faces_edges_and_corners(seed: u64) {
        let (_, levels) = random(seed);
        let mut dice = Dice(seed ^ 1);
        let free: Vec<f64> = (0..levels.free_count()).map(|_| dice.unit()).collect();
        let values = levels.complete(&free);
        let free: Vec<u32> = levels.free_corners().map(|_| (dice.roll() % 2) as u32).collect();
        let weights = levels.complete_weights(&free);
        let cells: Vec<LevelCell> = levels.cells().collect();
        for cell in &cells {
            // On a face, an edge or a corner, at random.
            let sides = dice.roll();
            let xi = [0, 1, 2].map(|axis| match sides >> (2 * axis) & 3 {
                0 => -1.0,
                1 => 1.0,
                _ => 2.0 * dice.unit() - 1.0,
            });
            let point = place(&levels, cell, DVec3::from(xi));
            for other in &cells {
                let grid = levels.grid(other.level);
                let u = (point - grid.origin) / grid.cell_size - other.index.as_dvec3();
                if u.min_element() < -1e-12 || u.max_element() > 1.0 + 1e-12 {
                    continue;
                }
                let there = 2.0 * u - DVec3::ONE;
                let jump = value(cell, DVec3::from(xi), &values) - value(other, there, &values);
                prop_assert!(jump.abs() < 1e-11, "{jump}");
                let weight = |cell: &LevelCell, xi: DVec3| {
                    let corners = weights.palette[weights.of_cell[cell.number] as usize];
                    (0..8).map(|a| {
                        let side = DVec3::from([0, 1, 2].map(|axis| f64::from(a >> axis & 1) * 2.0 - 1.0));
                        corners[a as usize] * (0.5 * (DVec3::ONE + side * xi)).element_product()
                    }).sum::<f64>()
                };
                let jump = weight(cell, DVec3::from(xi)) - weight(other, there);
                prop_assert!(jump.abs() < 1e-11, "{jump}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, failure_persistence: None, ..ProptestConfig::default() })]

    /// A cell is split, and its children's free nodes have the values of the map before.
    #[test]
    fn children_whose_free_nodes_are_their_parents_equal_it(seed: u64) {
        let (mut tree, before) = random(seed);
        let cells: Vec<LevelCell> = before.cells().collect();
        let mut dice = Dice(seed ^ 2);
        let free: Vec<f64> = (0..before.free_count()).map(|_| dice.unit()).collect();
        let values = before.complete(&free);
        let at = |point: DVec3| {
            let place = |cell: &LevelCell| {
                let grid = before.grid(cell.level);
                2.0 * ((point - grid.origin) / grid.cell_size - cell.index.as_dvec3()) - DVec3::ONE
            };
            let holder = cells.iter().find(|cell| place(cell).abs().max_element() < 1.0 + 1e-12);
            holder.map(|cell| value(cell, place(cell), &values)).expect("in the band")
        };
        let coarsest = cells.iter().map(|cell| cell.level).min();
        prop_assume!(coarsest.is_some());
        let split = cells.iter().find(|cell| Some(cell.level) == coarsest).expect("there is one");
        let index = split.index.to_array();
        tree.remove(&(split.level, index));
        for child in 0..8 {
            let child = [0, 1, 2].map(|axis| 2 * index[axis] + (child >> axis & 1));
            tree.insert((split.level + 1, child), Kind::Band);
        }
        let finer = Levels::new(before.grid(0), &lists(&tree, 5)).expect("balanced as before");
        let values = finer.complete(&free_values(&finer, at));
        for cell in finer.cells() {
            let xi = DVec3::from([0; 3].map(|_| 2.0 * dice.unit() - 1.0));
            let error = value(&cell, xi, &values) - at(place(&finer, &cell, xi));
            prop_assert!(error.abs() < 1e-11, "{error}");
        }
    }
}

fn run(i: u32, j: u32, k: u32, len: u32) -> CellRun {
    CellRun { i, j, k, len }
}

fn band(runs: &[CellRun]) -> LevelCells {
    LevelCells { band: runs.to_vec(), solid: Vec::new() }
}

/// All children of cell (0, 0, 0).
fn eight() -> LevelCells {
    band(&[run(0, 0, 0, 2), run(0, 1, 0, 2), run(0, 0, 1, 2), run(0, 1, 1, 2)])
}

/// Two cells, the first of which is split: the nodes of the face between them are constrained.
#[test]
fn the_nodes_of_the_example_are_these() {
    let levels = Levels::new(grid([2, 1, 1]), &[band(&[run(1, 0, 0, 1)]), eight()]).expect("balanced");
    // 135 of the children, of which 9 corners and 12 edges are on the face.
    assert_eq!((levels.count(), levels.free_count()), (32 + 135, 32 + 135 - 9 - 24));
    let corner_free: Vec<u32> = levels.free_corners().collect();
    assert_eq!(corner_free.len(), 8 + 18);
    assert_eq!(corner_free[8..12], [32, 33, 35, 36]);
}

#[test]
fn cells_within_cells_are_refused() {
    let error = Levels::new(grid([2, 1, 1]), &[band(&[run(0, 0, 0, 2)]), eight()]).err();
    assert_eq!(error, Some(LevelsError::Nested { level: 0, cell: UVec3::ZERO }));
    let deep = LevelCells { band: Vec::new(), solid: vec![run(7, 3, 3, 1)] };
    let levels = [LevelCells::default(), band(&[run(3, 1, 1, 1)]), deep];
    let error = Levels::new(grid([2, 1, 1]), &levels).err();
    assert_eq!(error, Some(LevelsError::Nested { level: 1, cell: UVec3::new(3, 1, 1) }));
}

/// The small cell touches the large one at a face, an edge or a corner.
#[test]
fn cells_that_touch_and_differ_by_two_levels_are_refused() {
    for fine in [[3, 1, 2], [3, 3, 2], [3, 3, 3], [3, 0, 0]] {
        let [i, j, k] = fine;
        let levels = [
            band(&[run(1, 0, 0, 1), run(1, 1, 0, 1), run(1, 1, 1, 1)]),
            LevelCells::default(),
            band(&[run(i, j, k, 1)]),
        ];
        let error = Levels::new(grid([2, 2, 2]), &levels).err();
        assert!(matches!(error, Some(LevelsError::Unbalanced { level: 0, .. })), "{error:?}");
    }
    let apart = [band(&[run(1, 0, 0, 1)]), LevelCells::default(), band(&[run(2, 0, 0, 1)])];
    assert!(Levels::new(grid([2, 1, 1]), &apart).is_ok());
    let three_apart =
        [band(&[run(1, 0, 0, 1)]), LevelCells::default(), LevelCells::default(), band(&[run(7, 4, 4, 1)])];
    let error = Levels::new(grid([2, 1, 1]), &three_apart).err();
    assert_eq!(error, Some(LevelsError::Unbalanced { level: 0, cell: UVec3::new(1, 0, 0) }));
}
