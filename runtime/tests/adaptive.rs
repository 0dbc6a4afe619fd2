//! Adaptive maps: against a slow oracle, uniform maps, and a flat wall.

mod analytic;

use analytic::{Random, adaptive_asset, adaptive_ball, asset, in_steps, single, trilinear};
use volmap_formats::asset::{Array, Asset, CellRun, GridSpec, LevelCells, Rounded};
use volmap_runtime::layout::{CornerWeights, FlatWall, Held, LevelCell, Levels, serendipity};
use volmap_runtime::{DVec3, Grid, Sample, SurfaceWithGradient, Values, VolumeMap};

/// SPEC.md, section 14, word by word.
struct Oracle {
    levels: Levels,
    cells: Vec<LevelCell>,
    phi: Vec<f64>,
    volume: Vec<f64>,
    weights: CornerWeights,
    wall: FlatWall,
}

impl Oracle {
    fn new(asset: &Asset) -> Oracle {
        let mut cells = vec![LevelCells { band: asset.band_cells.clone(), solid: asset.solid_cells.clone() }];
        cells.extend(asset.finer.iter().cloned());
        let levels = Levels::new(Grid::from(asset.grid), &cells).unwrap();
        Oracle {
            cells: levels.cells().collect(),
            phi: levels.complete(&asset.signed_distance.to_f64()),
            volume: levels.complete(&asset.volume.to_f64()),
            weights: levels.complete_weights(asset.plane_weight.as_ref().unwrap()),
            wall: FlatWall::new(asset.support_radius, asset.quadrature.ball_volume),
            levels,
        }
    }

    /// Distance, volume and their gradients.
    fn at(&self, point: DVec3) -> Result<[(f64, DVec3); 2], Held> {
        let Held::Band { number, level, xi } = self.levels.find(point) else {
            return Err(self.levels.find(point));
        };
        let cell = &self.cells[number];
        let per = 2.0 / self.levels.grid(level).cell_size;
        let (shape, slopes) = serendipity::shape_and_gradient(xi);
        let field = |values: &[f64]| {
            let nodes = || cell.nodes.iter().map(|&node| values[node as usize]);
            let value: f64 = nodes().zip(shape).map(|(value, n)| n * value).sum();
            (value, per * nodes().zip(slopes).map(|(value, slope)| value * slope).sum::<DVec3>())
        };
        let (phi, normal) = field(&self.phi);
        let (rest, slope) = field(&self.volume);
        let corners = &self.weights.palette[self.weights.of_cell[number] as usize];
        let weight = trilinear(corners, xi);
        let step = |axis: DVec3| trilinear(corners, xi + 0.5 * axis) - trilinear(corners, xi - 0.5 * axis);
        let rise = per * DVec3::new(step(DVec3::X), step(DVec3::Y), step(DVec3::Z));
        let volume = weight * self.wall.volume(phi) + rest;
        let slope = weight * self.wall.slope(phi) * normal + self.wall.volume(phi) * rise + slope;
        Ok([(phi, normal), (volume, slope)])
    }
}

fn level_of(oracle: &Oracle, point: DVec3) -> usize {
    match oracle.levels.find(point) {
        Held::Band { level, .. } => level as usize,
        _ => panic!("not in the band"),
    }
}

fn points(map: &VolumeMap, count: usize) -> Vec<DVec3> {
    let mut random = Random(5);
    let (low, high) = (map.grid().origin, map.grid().max_corner());
    let mut points: Vec<DVec3> = (0..count).map(|_| random.point(low - 0.1, high + 0.1)).collect();
    points.sort_by_key(|&x| map.grid().locate(x).map(|at| (at.cell.z, at.cell.y, at.cell.x)));
    // On faces, edges and corners of the finest cells.
    let size = map.finest_cell_size();
    let on_faces = |x: &DVec3| {
        let u = (*x - low) / size;
        low + size * DVec3::new(u.x.round(), if u.x < 3.0 { u.y.round() } else { u.y }, u.z)
    };
    points.extend(points.iter().step_by(7).map(on_faces).collect::<Vec<_>>());
    // Many in one cell.
    points.extend((0..100).map(|_| random.point(DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.51, 0.01, 0.01))));
    points
}

#[test]
fn adaptive_maps_answer_as_the_oracle_does() {
    for levels in 1..=4u32 {
        let asset = adaptive_ball(levels);
        let (map, oracle) = (VolumeMap::from_asset(&asset).unwrap(), Oracle::new(&asset));
        assert_eq!((map.levels(), map.has_plane_weights()), (levels, true));
        let mut near = [0; 4];
        for point in points(&map, 3_000) {
            match (map.sample_with_gradient(point), oracle.at(point)) {
                (Sample::Near(found), Ok([(phi, normal), (volume, slope)])) => {
                    near[level_of(&oracle, point)] += 1;
                    assert!((found.surface.distance - phi).abs() < 1e-13);
                    assert!((found.surface.normal - normal.normalize()).length() < 1e-11);
                    assert!((found.surface.volume - volume).abs() < 1e-15);
                    assert!((found.volume_gradient - slope).length() < 1e-13, "{point}");
                }
                (Sample::DeepInside, Err(Held::Solid)) => {}
                (Sample::Outside, Err(Held::Fluid | Held::Outside)) => {}
                (found, expected) => panic!("{point}: {found:?}, {expected:?}"),
            }
        }
        assert!(near[..levels as usize].iter().all(|&near| near > 10), "{near:?}");
    }
}

#[test]
fn batches_have_the_bits_of_samples_by_themselves() {
    for asset in [adaptive_ball(4), single(&adaptive_ball(3)), in_steps(&adaptive_ball(3))] {
        let map = VolumeMap::from_asset(&asset).unwrap();
        let points = points(&map, 5_000);
        let mut gradients: Vec<Sample<SurfaceWithGradient>> = Vec::new();
        let (mut samples, mut values) = (Vec::<Sample>::new(), Vec::<Values>::new());
        map.sample_batch(&points, &mut gradients);
        map.sample_batch(&points, &mut samples);
        map.sample_batch(&points, &mut values);
        for (n, &point) in points.iter().enumerate() {
            assert_eq!(gradients[n], map.sample_with_gradient(point));
            assert_eq!(samples[n], map.sample(point));
            assert_eq!(values[n], map.values(point));
            assert_eq!(samples[n], gradients[n].map(|near| near.surface));
        }
    }
}

/// One level and no weights: the bits of the uniform map.
#[test]
fn one_level_without_weights_is_a_uniform_map() {
    let grid = GridSpec { origin: [-1.0, -2.0, 0.5], cell_size: [0.3, 0.2, 0.25], resolution: [5, 4, 3] };
    let band = (0..12).map(|row| CellRun { i: row % 2, j: row % 4, k: row / 4, len: 3 }).collect();
    let solid = vec![CellRun { i: 4, j: 0, k: 0, len: 1 }];
    let wave = |x: DVec3| (x.x * 5.0 + x.y * 7.0).sin() + x.z * x.z;
    let uniform = asset(grid, [band, solid], wave, |x| 0.01 * wave(x));
    let corners =
        Levels::new(Grid::from(grid), &[LevelCells { band: uniform.band_cells.clone(), solid: Vec::new() }]);
    let weights = vec![0; corners.unwrap().free_corner_count()];
    let adaptive = Asset { plane_weight: Some(weights), ..uniform.clone() };
    let maps = [&uniform, &adaptive].map(|asset| VolumeMap::from_asset(asset).unwrap());
    for point in points(&maps[0], 3_000) {
        let [a, b] = [0, 1].map(|n| maps[n].sample_with_gradient(point));
        assert_eq!(a, b, "{point}");
    }
}

/// Cells of two radii, and no error but rounding.
#[test]
fn a_tilted_flat_wall_is_exact_in_large_cells() {
    let grid = GridSpec { origin: [-0.4; 3], cell_size: [0.2; 3], resolution: [4; 3] };
    let normal = DVec3::new(0.48, 0.6, 0.64);
    let wall = FlatWall::new(0.1, 0.004);
    let phi = |x: DVec3| normal.dot(x) - 0.03;
    for levels in [1, 3] {
        let asset = adaptive_asset(grid, levels, [&phi, &|x| wall.volume(phi(x)), &|x| x.length()], |_| 1);
        let map = VolumeMap::from_asset(&asset).unwrap();
        let mut random = Random(3);
        for _ in 0..2_000 {
            let point = random.point(DVec3::splat(-0.4), DVec3::splat(0.4));
            let Sample::Near(near) = map.sample_with_gradient(point) else { continue };
            let exact = wall.volume(phi(point));
            assert!((near.surface.volume - exact).abs() < 1e-13 * 0.004, "{}", near.surface.volume - exact);
            let slope = wall.slope(phi(point)) * normal;
            assert!((near.volume_gradient - slope).length() < 1e-12, "{point}");
        }
    }
}

/// Beside a face, an edge or a corner between cells of different size the values are the same.
#[test]
fn values_are_continuous_between_levels() {
    let map = VolumeMap::from_asset(&adaptive_ball(4)).unwrap();
    let mut random = Random(8);
    let (low, size) = (map.grid().origin, map.finest_cell_size());
    let mut compared = 0;
    for n in 0..20_000 {
        let mut x = (random.point(low, map.grid().max_corner()) - low) / size;
        for axis in 0..=(n % 3) {
            x[axis] = x[axis].round();
        }
        let beside = [-1.0, 1.0].map(|side| map.values(low + size * (x + side * 1e-12)));
        if beside.iter().all(|at| at.distance.is_finite()) {
            compared += 1;
            assert!((beside[0].distance - beside[1].distance).abs() < 1e-11);
            assert!((beside[0].volume - beside[1].volume).abs() < 1e-13);
        }
    }
    assert!(compared > 1_000, "{compared}");
}

#[test]
fn steps_of_16_bits_are_the_values_that_they_stand_for() {
    let rounded = in_steps(&adaptive_ball(3));
    let values = |array: &Array| Array::F64(array.to_f64());
    let exact = Asset {
        signed_distance: values(&rounded.signed_distance),
        volume: values(&rounded.volume),
        ..rounded.clone()
    };
    assert!(matches!(&rounded.volume, Array::Rounded(Rounded { .. })));
    let [rounded, exact] = [rounded, exact].map(|asset| VolumeMap::from_asset(&asset).unwrap());
    for point in points(&exact, 2_000) {
        let (a, b) = (rounded.values(point), exact.values(point));
        assert!(a.distance == b.distance || (a.distance - b.distance).abs() < 1e-6, "{a:?} {b:?}");
        assert!((a.volume - b.volume).abs() < 1e-8);
    }
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    type Change = fn(&mut Asset);
    let all: [(&str, Change); 5] = [
        ("`/fields/signed_distance` has", |asset| {
            let Array::F64(values) = &mut asset.signed_distance else { panic!() };
            values.push(0.0);
            asset.volume = asset.signed_distance.clone();
        }),
        ("`/fields/plane_weight` has", |asset| asset.plane_weight.as_mut().unwrap().truncate(5)),
        ("holds cells of finer levels", |asset| {
            asset.band_cells = vec![CellRun { i: 0, j: 2, k: 1, len: 4 }];
            asset.solid_cells.clear();
        }),
        ("can't belong to", |asset| {
            asset.signed_distance = Array::F64(vec![0.0; 3]);
            asset.volume = Array::F64(vec![0.0; 3]);
        }),
        ("can't belong to", |asset| {
            asset.finer.resize(12, LevelCells::default());
            asset.finer[11].solid = (0..100).map(|j| CellRun { i: 0, j: 2 * j, k: 0, len: 8192 }).collect();
        }),
    ];
    for (text, change) in all {
        let mut asset = adaptive_ball(3);
        change(&mut asset);
        let error = VolumeMap::from_asset(&asset).unwrap_err().to_string();
        assert!(error.contains(text), "{text}: {error}");
    }
}

#[test]
fn memory_and_sizes_are_those_of_the_levels() {
    let map = VolumeMap::from_asset(&single(&adaptive_ball(3))).unwrap();
    assert_eq!(map.finest_cell_size(), map.grid().cell_size / 4.0);
    let nodes = Oracle::new(&adaptive_ball(3)).levels.count();
    assert!((8 * nodes..40 * nodes).contains(&map.memory_bytes()), "{}", map.memory_bytes() / nodes);
}
