//! Queries against the oracle, and alone against in batches: bands with gaps, single cells, faces, far points, NaN.

#[path = "analytic/mod.rs"]
mod analytic;

use analytic::{Oracle, Random, asset, double_of, in_steps, single, with_density};
use std::sync::Arc;
use volmap_formats::asset::{Asset, CellRun, Exterior, GridSpec};
use volmap_runtime::{DQuat, DVec3, Grid, Pose, PosedMap, Sample, Values, VolumeMap};

const BALL: f64 = 0.004;

/// Random runs of band and solid cells, many of a single cell, with gaps, some touching.
fn random_asset(random: &mut Random, resolution: [u32; 3]) -> Asset {
    let mut cells = [Vec::new(), Vec::new()];
    for k in 0..resolution[2] {
        for j in 0..resolution[1] {
            let mut i = 0;
            while i < resolution[0] {
                let len = (1 + (random.unit() * 3.0) as u32).min(resolution[0] - i);
                match (random.unit() * 4.0) as usize {
                    0 | 1 => cells[0].push(CellRun { i, j, k, len }),
                    2 => cells[1].push(CellRun { i, j, k, len }),
                    _ => {}
                }
                i += len;
            }
        }
    }
    let grid = GridSpec { origin: [-0.31, 0.2, 7.0], cell_size: [0.1, 0.07, 0.13], resolution };
    let noise = |x: DVec3, s: f64| (x.dot(DVec3::new(31.0, 47.0, 23.0)) * s).sin();
    let mut made = asset(grid, cells, |x| noise(x, 1.0), |x| 0.004 * noise(x, 1.7));
    made.quadrature.ball_volume = BALL;
    made
}

/// Points in cells, on faces, edges and corners of cells and domain, beyond it, and what is no point.
fn points(random: &mut Random, grid: &Grid) -> Vec<DVec3> {
    let (low, high) = (grid.origin, grid.max_corner());
    let margin = 0.1 * (high - low);
    let mut out: Vec<DVec3> = (0..3_000).map(|_| random.point(low - margin, high + margin)).collect();
    for n in 0..1_000 {
        let mut x = random.point(low, high);
        for axis in 0..3 {
            if n >> axis & 1 == 1 {
                let face = (random.unit() * f64::from(grid.resolution[axis] + 1)).floor();
                x[axis] = low[axis] + grid.cell_size[axis] * face;
            }
        }
        out.push(x);
    }
    // Runs of points in one cell, as sorted particles are.
    for n in 0..500 {
        let x = random.point(low, high);
        out.extend((0..n % 11).map(|_| x + 1e-3 * (random.point(DVec3::ZERO, DVec3::ONE) - 0.5)));
    }
    for odd in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e300, f64::MAX, -0.0, 5e-324] {
        for axis in 0..3 {
            let mut x = 0.5 * (low + high);
            x[axis] = odd;
            out.push(x);
        }
        out.push(DVec3::splat(odd));
    }
    out.extend([low, high, high + margin, low - margin]);
    out
}

fn maps() -> Vec<(Asset, VolumeMap)> {
    let mut random = Random(3);
    let mut out = Vec::new();
    for resolution in [[7, 5, 4], [1, 1, 1], [40, 3, 2]] {
        for exterior in [Exterior::Fluid, Exterior::Solid] {
            let double = Asset { exterior, ..random_asset(&mut random, resolution) };
            for asset in [single(&double), double] {
                let map = VolumeMap::from_asset(&asset).unwrap();
                out.push((asset, map));
            }
        }
    }
    out
}

fn numbers(sample: Sample) -> Vec<u64> {
    let Sample::Near(at) = sample else { return vec![u64::from(sample == Sample::Outside)] };
    let mut out = vec![at.distance, at.volume];
    out.extend(at.normal.to_array());
    out.extend(at.closest_point.to_array());
    out.into_iter().map(f64::to_bits).collect()
}

#[test]
fn samples_are_those_of_the_oracle() {
    let mut near = 0;
    for (asset, map) in maps() {
        let oracle = Oracle::new(&asset);
        for point in points(&mut Random(5), map.grid()) {
            match (map.sample(point), oracle.sample(point)) {
                (Sample::Near(ours), (Sample::Near(exact), slope)) => {
                    assert!((ours.distance - exact.distance).abs() < 1e-12, "{ours:?} {exact:?}");
                    assert!((ours.volume - exact.volume).abs() < 1e-14, "{ours:?} {exact:?}");
                    assert!((ours.normal - exact.normal).length() * slope < 1e-10, "{ours:?} {exact:?}");
                    assert!((ours.normal.length() - 1.0).abs() < 1e-14);
                    let closest = point - ours.distance * ours.normal;
                    assert!((ours.closest_point - closest).length() < 1e-15 * (1.0 + point.length()));
                    near += 1;
                }
                (ours, (exact, _)) => assert_eq!(ours, exact, "{point}"),
            }
        }
    }
    assert!(near > 20_000, "{near}");
}

#[test]
fn batches_of_any_order_and_length_have_the_bits_of_single_samples() {
    for (_, map) in maps() {
        let mut random = Random(7);
        let mut points = points(&mut random, map.grid());
        let (mut samples, mut values) = (Vec::new(), vec![Values { distance: 0.0, volume: 0.0 }; 9]);
        for round in 0..4 {
            for length in [0, 1, 2, 3, 4, 5, 63, 64, 65, 130, points.len()] {
                let part = &points[points.len() - length..];
                map.sample_batch(part, &mut samples);
                map.sample_batch(part, &mut values);
                assert_eq!((samples.len(), values.len()), (length, length));
                for ((&point, &sample), &value) in part.iter().zip(&samples).zip(&values) {
                    assert_eq!(numbers(sample), numbers(map.sample(point)), "{point} in round {round}");
                    assert_eq!(value, map.values(point));
                    let expected = match sample {
                        Sample::Near(at) => Values { distance: at.distance, volume: at.volume },
                        Sample::Outside => Values { distance: f64::INFINITY, volume: 0.0 },
                        Sample::DeepInside => Values { distance: f64::NEG_INFINITY, volume: BALL },
                    };
                    assert_eq!(value, expected, "{point}");
                    assert_eq!(map.inside(point), expected.distance < 0.0, "{point}");
                }
            }
            // Sorted by cells in the second round, shuffled in the others.
            points.sort_by_key(|&x| map.grid().locate(x).map(|at| (at.cell.z, at.cell.y, at.cell.x)));
            if round > 0 {
                points.sort_by_cached_key(|_| random.unit().to_bits());
            }
        }
    }
}

#[test]
fn vanishing_gradients_have_no_normal() {
    let grid = GridSpec { origin: [0.0; 3], cell_size: [1.0; 3], resolution: [2, 2, 2] };
    let cells = (0..4).map(|row| CellRun { i: 0, j: row % 2, k: row / 2, len: 2 }).collect();
    let map = VolumeMap::from_asset(&asset(grid, [cells, Vec::new()], |_| 0.0, |_| 0.0)).unwrap();
    let at = map.sample(DVec3::new(0.3, 1.2, 1.7)).near().unwrap();
    assert_eq!((at.distance, at.normal), (0.0, DVec3::ZERO));
}

#[test]
fn batches_of_a_body_have_the_bits_of_its_single_samples() {
    for (_, map) in maps() {
        let rotation = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
        let pose = Pose { rotation, translation: DVec3::new(3.0, -2.0, 1.0) };
        let body = PosedMap { map: Arc::new(map), pose };
        let points: Vec<DVec3> =
            points(&mut Random(11), body.map.grid()).into_iter().map(|x| pose.to_world(x)).collect();
        let (mut samples, mut values) = (Vec::<Sample>::new(), Vec::<Values>::new());
        body.sample_batch(&points, &mut samples);
        body.sample_batch(&points, &mut values);
        assert_eq!((samples.len(), values.len()), (points.len(), points.len()));
        for ((&point, &sample), &value) in points.iter().zip(&samples).zip(&values) {
            assert_eq!(numbers(sample), numbers(body.sample(point)), "{point}");
            assert_eq!(value, body.values(point));
        }
    }
}

#[test]
fn densities_are_those_of_the_oracle_alone_and_in_batches() {
    let mut random = Random(13);
    let mut near = 0;
    for resolution in [[7, 5, 4], [1, 1, 1], [40, 3, 2]] {
        let double = with_density(random_asset(&mut random, resolution), 900.0);
        for asset in [single(&double), in_steps(&double), double] {
            let map = VolumeMap::from_asset(&asset).unwrap();
            let oracle = Oracle::new(&double_of(&asset));
            let points = points(&mut Random(5), map.grid());
            let mut batch = vec![None; 3];
            map.sample_batch(&points, &mut batch);
            assert_eq!(batch.len(), points.len());
            for (&point, &found) in points.iter().zip(&batch) {
                assert_eq!(found, map.density(point), "{point}");
                let (Some(found), Some(exact)) = (found, oracle.density(point)) else {
                    assert_eq!(found.is_some(), oracle.density(point).is_some(), "{point}");
                    continue;
                };
                assert!((found.value - exact.value).abs() < 1e-12, "{found:?} {exact:?}");
                assert!((found.gradient - exact.gradient).length() < 1e-10, "{found:?} {exact:?}");
                near += usize::from(map.sample(point).near().is_some());
            }
        }
    }
    assert!(near > 10_000, "{near}");
}
