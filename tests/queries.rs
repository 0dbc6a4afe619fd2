//! Queries of a map: numbering against brute force, continuity, gradients, what lies outside the band, poses.

use std::collections::BTreeSet;
use std::sync::Arc;
use volmap_bake::plan::MapSettings;
use volmap_bake::volume_map::quadrature::Rule;
use volmap_formats::asset::{Array, Asset, CellRun, Exterior, Rounded};
use volmap_runtime::layout::serendipity::node;
use volmap_runtime::layout::{Cell, CellIndex, Family, Nodes};
use volmap_runtime::{DQuat, DVec3, Pose, PosedMap, Sample, VolumeMap};
use volmap_tests::{Random, SPHERE, Solid, TORUS, asset_of, compute, map_of};

fn settings() -> MapSettings {
    MapSettings { support_radius: Some(0.1), rule: Rule::Ball(4), ..MapSettings::default() }
}

fn random_cells(random: &mut Random, n: [u32; 3], share: f64) -> Vec<CellRun> {
    let mut runs = Vec::new();
    for k in 0..n[2] {
        for j in 0..n[1] {
            let mut i = 0;
            while i < n[0] {
                let len = 1 + random.below(3) as u32;
                if random.unit() < share && i + len <= n[0] {
                    runs.push(CellRun { i, j, k, len });
                }
                i += len;
            }
        }
    }
    runs
}

/// Every lattice point that a cell touches, sorted as `SPEC.md` says: the definition, without intervals.
fn brute_force_numbers(runs: &[CellRun]) -> Vec<(u32, [u32; 3], u32)> {
    let reach = [[1, 1, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0]];
    let mut points = BTreeSet::new();
    for run in runs {
        for i in run.i..run.i + run.len {
            for (family, [rx, ry, rz]) in reach.into_iter().enumerate() {
                for (dz, dy, dx) in
                    (0..=rz).flat_map(|z| (0..=ry).flat_map(move |y| (0..=rx).map(move |x| (z, y, x))))
                {
                    points.insert((family as u32, run.k + dz, run.j + dy, i + dx));
                }
            }
        }
    }
    let thirds = |family: u32| if family == 0 { 1 } else { 2 };
    points.into_iter().flat_map(|(f, k, j, i)| (0..thirds(f)).map(move |t| (f, [i, j, k], t))).collect()
}

#[test]
fn numbers_of_nodes_are_those_of_the_specification() {
    let mut random = Random::from_state(7);
    for share in [0.1, 0.5, 1.0] {
        let n = [7, 5, 4];
        let runs = random_cells(&mut random, n, share);
        let nodes = Nodes::new(n.into(), &runs).unwrap();
        let expected = brute_force_numbers(&runs);
        assert_eq!(nodes.count(), expected.len());
        let position = |(family, [i, j, k], t): (u32, [u32; 3], u32)| {
            DVec3::new(i.into(), j.into(), k.into()) + Family::ALL[family as usize].offset(t)
        };
        // Node a of a cell lies where the element says.
        let index = CellIndex::new(n.into(), &runs, &[], &nodes);
        for run in &runs {
            for i in run.i..run.i + run.len {
                let Cell::Band(numbers) = index.find([i, run.j, run.k].into()) else { panic!("stored") };
                let corner = DVec3::new(i.into(), run.j.into(), run.k.into());
                for (a, number) in numbers.all().into_iter().enumerate() {
                    let at = corner + (node(a) + DVec3::ONE) * 0.5;
                    assert!(
                        (position(expected[number as usize]) - at).length() < 1e-12,
                        "node {a} of {corner}"
                    );
                }
            }
        }
        let cells: usize = runs.iter().map(|run| run.len as usize).sum();
        let stored: Vec<usize> = index.stored().map(|numbers| numbers.cell()).collect();
        assert_eq!(stored, (0..cells).collect::<Vec<_>>());
    }
}

#[test]
fn fields_are_continuous_across_cells() {
    let map = map_of(&TORUS, 17, &settings());
    let mut random = Random::from_state(3);
    let mut checked = 0;
    for _ in 0..40_000 {
        let mut at = random.point(map.grid().origin, map.grid().max_corner());
        // Onto the face below a cell.
        let axis = random.below(3);
        let cell = ((at - map.grid().origin) / map.grid().cell_size).floor();
        at[axis] = map.grid().origin[axis] + map.grid().cell_size[axis] * cell[axis];
        let mut step = DVec3::ZERO;
        step[axis] = 1e-12;
        if let (Sample::Near(below), Sample::Near(above)) = (map.sample(at - step), map.sample(at + step)) {
            assert!((below.distance - above.distance).abs() < 1e-10, "{below:?} {above:?}");
            assert!((below.volume - above.volume).abs() < 1e-12, "{below:?} {above:?}");
            checked += 1;
        }
    }
    assert!(checked > 5_000, "{checked}");
}

#[test]
fn normals_are_finite_differences() {
    let map = map_of(&SPHERE, 15, &settings());
    let mut random = Random::from_state(5);
    let mut checked = 0;
    while checked < 2_000 {
        let at = random.point(map.grid().origin, map.grid().max_corner());
        let xi = (at - map.grid().origin) / map.grid().cell_size;
        if (xi - xi.floor() - 0.5).abs().max_element() > 0.49 {
            continue;
        }
        let Sample::Near(near) = map.sample(at) else { continue };
        let h = 1e-6;
        let phi = |x: DVec3| map.sample(x).near().unwrap().distance;
        let slope = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| (phi(at + h * e) - phi(at - h * e)) / (2.0 * h));
        let expected = DVec3::from(slope).normalize();
        assert!((near.normal - expected).length() < 1e-6, "{} {expected}", near.normal);
        assert!((near.normal.length() - 1.0).abs() < 1e-12);
        assert!((near.closest_point - (at - near.distance * near.normal)).length() < 1e-15);
        checked += 1;
    }
}

const TANK: Solid = Solid { name: "inverted sphere", extent: SPHERE.extent, phi: |x| 0.5 - x.length() };

#[test]
fn beyond_the_band_the_answer_is_outside_or_deep_inside() {
    let sphere = map_of(&SPHERE, 30, &settings());
    assert_eq!(sphere.sample(DVec3::ZERO), Sample::DeepInside);
    assert_eq!(sphere.sample(DVec3::splat(0.65)), Sample::Outside);
    assert_eq!(sphere.sample(DVec3::splat(100.0)), Sample::Outside);
    let tank = map_of(&TANK, 30, &MapSettings { invert: true, ..settings() });
    assert_eq!(tank.sample(DVec3::ZERO), Sample::Outside);
    assert_eq!(tank.sample(DVec3::splat(0.65)), Sample::DeepInside);
    assert_eq!(tank.sample(DVec3::splat(100.0)), Sample::DeepInside);
    for not_a_point in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(sphere.sample(DVec3::new(0.0, not_a_point, 0.0)), Sample::Outside);
        assert_eq!(tank.sample(DVec3::new(0.0, not_a_point, 0.0)), Sample::Outside);
    }
    assert_eq!((sphere.exterior(), tank.exterior()), (Exterior::Fluid, Exterior::Solid));
    let mut random = Random::from_state(11);
    for _ in 0..10_000 {
        let at = random.point(DVec3::splat(-0.8), DVec3::splat(0.8));
        let depth = at.length() - 0.5;
        if depth.abs() > 1e-3 {
            assert_eq!(sphere.inside(at), depth < 0.0, "{at}");
            assert_eq!(tank.inside(at), depth > 0.0, "{at}");
        }
    }
}

#[test]
fn bodies_share_a_map() {
    let map: Arc<VolumeMap> = Arc::new(map_of(&TORUS, 20, &settings()));
    let rotation = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
    let pose = Pose { rotation, translation: DVec3::new(3.0, -2.0, 1.0) };
    let body = PosedMap { map: map.clone(), pose };
    let mut random = Random::from_state(13);
    let points: Vec<DVec3> =
        (0..2_000).map(|_| random.point(map.grid().origin, map.grid().max_corner())).collect();
    let in_world: Vec<DVec3> = points.iter().map(|&x| pose.to_world(x)).collect();
    let (mut local, mut world) = (Vec::<Sample>::new(), Vec::<Sample>::new());
    map.sample_batch(&points, &mut local);
    body.sample_batch(&in_world, &mut world);
    assert_eq!((local.len(), world.len()), (points.len(), points.len()));
    let mut near = 0;
    for ((a, b), x) in local.iter().zip(&world).zip(&in_world) {
        // A point on the edge of a cell may fall to either side by rounding.
        if let (Sample::Near(a), Sample::Near(b)) = (a, b) {
            assert!((a.distance - b.distance).abs() < 1e-12 && (a.volume - b.volume).abs() < 1e-14);
            assert!((pose.to_world(a.closest_point) - b.closest_point).length() < 1e-9);
            assert!((rotation * a.normal - b.normal).length() < 1e-9);
            assert_eq!(body.inside(*x), b.distance < 0.0);
            near += 1;
        }
    }
    assert!(near > 500, "{near}");
}

#[test]
fn fields_of_16_bits_differ_by_less_than_the_element_allows() {
    let (plan, maps) = compute(&SPHERE, 15, &settings());
    let double = asset_of(&plan, &settings(), maps);
    let (part, ball) = (1e-3, double.quadrature.ball_volume);
    let rounded = |array: &Array, unit: f64| match array {
        Array::F64(v) => Array::Rounded(Rounded::new(v, unit, part).unwrap()),
        other => other.clone(),
    };
    let signed_distance = rounded(&double.signed_distance, double.support_radius);
    let short = Asset { signed_distance, volume: rounded(&double.volume, ball), ..double.clone() };
    // The largest sum of |N_a| in the element: SPEC.md, section 3.
    let [distance_bound, volume_bound] = [double.support_radius, ball].map(|unit| 5.75 * part * unit);
    let [double, short] = [double, short].map(|asset| VolumeMap::from_asset(&asset).unwrap());
    let (mut random, mut worst) = (Random::from_state(18), [0.0f64; 2]);
    for _ in 0..20_000 {
        let at = random.point(double.grid().origin, double.grid().max_corner());
        match (double.sample(at), short.sample(at)) {
            (Sample::Near(a), Sample::Near(b)) => {
                worst[0] = worst[0].max((a.distance - b.distance).abs() / distance_bound);
                worst[1] = worst[1].max((a.volume - b.volume).abs() / volume_bound);
            }
            (a, b) => assert_eq!(a, b),
        }
    }
    println!("largest differences, of what the element allows: {worst:?}");
    assert!(worst.iter().all(|part| (0.1..1.0).contains(part)), "{worst:?}");
    assert!(2 * short.memory_bytes() < double.memory_bytes());
}

#[test]
fn fields_of_single_precision_are_those_of_double_precision_rounded() {
    let (plan, maps) = compute(&SPHERE, 15, &settings());
    let double = asset_of(&plan, &settings(), maps);
    let mut single = double.clone();
    let rounded = |array: &volmap_formats::asset::Array| match array {
        volmap_formats::asset::Array::F64(v) => {
            volmap_formats::asset::Array::F32(v.iter().map(|&x| x as f32).collect())
        }
        other => other.clone(),
    };
    single.signed_distance = rounded(&double.signed_distance);
    single.volume = rounded(&double.volume);
    let [double, single] = [double, single].map(|asset| VolumeMap::from_asset(&asset).unwrap());
    let mut random = Random::from_state(17);
    for _ in 0..2_000 {
        let at = random.point(double.grid().origin, double.grid().max_corner());
        if let (Sample::Near(a), Sample::Near(b)) = (double.sample(at), single.sample(at)) {
            assert!((a.distance - b.distance).abs() < 1e-6 && (a.volume - b.volume).abs() < 1e-8);
        }
    }
    assert!(single.memory_bytes() < double.memory_bytes());
}
