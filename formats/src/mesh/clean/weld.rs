//! Which vertices are one.

use std::collections::HashMap;

/// For every vertex the one that it becomes: the earliest at an equal position (-0 equals 0), then
/// an earlier one within `tolerance` that stays. Finite positions only.
pub fn weld(positions: &[[f64; 3]], tolerance: f64) -> Vec<u32> {
    let mut target = weld_equal(positions);
    if tolerance > 0.0 {
        weld_near(positions, tolerance, &mut target);
    }
    target
}

fn weld_equal(positions: &[[f64; 3]]) -> Vec<u32> {
    let bits = |k: u32| positions[k as usize].map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&k| (bits(k), k));
    let mut target = vec![0; positions.len()];
    let mut first = 0;
    for (place, &k) in order.iter().enumerate() {
        if place == 0 || bits(k) != bits(first) {
            first = k;
        }
        target[k as usize] = first;
    }
    target
}

/// Greedy, in the file's order: a vertex joins the nearest one that stays, or stays itself. Cells of
/// the grid are as wide as the tolerance, so all candidates are in 27 cells. The map is only looked
/// up, never iterated.
fn weld_near(positions: &[[f64; 3]], tolerance: f64, target: &mut [u32]) {
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut joined = vec![u32::MAX; positions.len()];
    for k in 0..positions.len() {
        if target[k] as usize != k {
            joined[k] = joined[target[k] as usize];
            continue;
        }
        let p = positions[k];
        let cell = p.map(|c| (c / tolerance).floor() as i64);
        joined[k] = match nearest(positions, &grid, cell, (p, tolerance)) {
            Some(stays) => stays,
            None => {
                grid.entry(cell).or_default().push(k as u32);
                k as u32
            }
        };
    }
    target.copy_from_slice(&joined);
}

fn nearest(
    positions: &[[f64; 3]],
    grid: &HashMap<[i64; 3], Vec<u32>>,
    cell: [i64; 3],
    (p, tolerance): ([f64; 3], f64),
) -> Option<u32> {
    let mut best: Option<(f64, u32)> = None;
    for shift in 0..27 {
        let step = [shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1];
        let near: [i64; 3] = std::array::from_fn(|i| cell[i].saturating_add(step[i]));
        for &candidate in grid.get(&near).into_iter().flatten() {
            let q = positions[candidate as usize];
            let distance = (p[0] - q[0]).hypot(p[1] - q[1]).hypot(p[2] - q[2]);
            if distance <= tolerance && best.is_none_or(|best| (distance, candidate) < best) {
                best = Some((distance, candidate));
            }
        }
    }
    best.map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minus_zero_is_zero() {
        let positions = [[0.0, -0.0, 1.0], [-0.0, 0.0, 1.0], [0.0, 0.0, 1.0 + 1e-15]];
        assert_eq!(weld(&positions, 0.0), [0, 0, 2]);
    }

    #[test]
    fn near_vertices_join_across_cells() {
        let positions = [[0.99, 0.0, 0.0], [1.01, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert_eq!(weld(&positions, 0.5), [0, 0, 2, 2]);
        assert_eq!(weld(&positions, 0.01), [0, 1, 2, 2]);
    }
}
