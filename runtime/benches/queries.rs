//! Nanoseconds a point and milliseconds an opening, one thread: `cargo bench -p volmap-runtime`. With assets after `--`
//! those are compared instead, at the particles that a fluid of spacing r or 2 r has near their walls, in turns.
//!
//! The map is a torus made from closed forms. Every round measures every way once, so that what else the machine
//! does hits all alike; the table gives medians. `BENCHMARKS.md` says what the numbers mean.

#[path = "../tests/analytic/mod.rs"]
mod analytic;

use analytic::{Oracle, Random, adaptive_asset, asset, single};
use std::hint::black_box;
use std::time::Instant;
use volmap_formats::asset::{Asset, CellRun, GridSpec};
use volmap_runtime::{DVec3, Grid, Sample, SurfaceWithGradient, Values, VolumeMap};

const ROUNDS: usize = 31;
const POINTS: usize = 50_000;
const RADIUS: f64 = 0.1;

fn phi(x: DVec3) -> f64 {
    (x.x.hypot(x.z) - 0.5).hypot(x.y) - 0.25
}

fn volume(x: DVec3) -> f64 {
    let depth = (0.5 - phi(x) / RADIUS).clamp(0.0, 1.0);
    0.004 * depth * depth * (3.0 - 2.0 * depth)
}

/// A torus of 1.5 m on a grid of the domain that the peer chooses, the box grown by 8 r, or on a tight one.
fn torus(resolution: [u32; 3], margin: f64) -> Asset {
    let corner = DVec3::new(0.75, 0.25, 0.75) + margin;
    let cell_size =
        2.0 * corner / DVec3::new(resolution[0].into(), resolution[1].into(), resolution[2].into());
    let grid = GridSpec { origin: (-corner).into(), cell_size: cell_size.into(), resolution };
    let lattice = Grid::from(grid);
    let reach = 2.0 * RADIUS + 0.5 * cell_size.length();
    let mut cells = [Vec::new(), Vec::new()];
    for k in 0..resolution[2] {
        for j in 0..resolution[1] {
            for i in 0..resolution[0] {
                let depth = phi(lattice.cell_corner([i, j, k].into()) + 0.5 * cell_size);
                if depth <= reach {
                    push(&mut cells[usize::from(depth < -reach)], i, j, k);
                }
            }
        }
    }
    asset(grid, cells, phi, volume)
}

fn push(runs: &mut Vec<CellRun>, i: u32, j: u32, k: u32) {
    match runs.last_mut() {
        Some(run) if (run.k, run.j, run.i + run.len) == (k, j, i) => run.len += 1,
        _ => runs.push(CellRun { i, j, k, len: 1 }),
    }
}

/// Whether 0 < Phi < 2 r: where particles see the wall.
fn is_near(map: &VolumeMap, point: DVec3) -> bool {
    let reach = 2.0 * map.support_radius();
    map.sample(point).near().is_some_and(|at| at.distance > 0.0 && at.distance < reach)
}

/// Particles near the wall.
fn particles(map: &VolumeMap) -> Vec<DVec3> {
    let mut random = Random(1);
    let mut points = Vec::with_capacity(POINTS);
    while points.len() < POINTS {
        let point = random.point(map.grid().origin, map.grid().max_corner());
        if is_near(map, point) {
            points.push(point);
        }
    }
    points
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// Nanoseconds a point: oracle (of uniform maps), samples alone, batch, batch of values.
fn queries(map: &VolumeMap, oracle: Option<&Oracle>, points: &[DVec3]) -> [f64; 4] {
    let (mut samples, mut values) = (Vec::<Sample>::new(), Vec::<Values>::new());
    let mut times: [Vec<f64>; 4] = Default::default();
    for _ in 0..ROUNDS {
        times[0].push(seconds(|| {
            samples.clear();
            samples.extend(oracle.iter().flat_map(|oracle| points.iter().map(|&x| oracle.sample(x).0)));
        }));
        times[1].push(seconds(|| {
            samples.clear();
            samples.extend(points.iter().map(|&x| map.sample(x)));
        }));
        times[2].push(seconds(|| map.sample_batch(points, &mut samples)));
        times[3].push(seconds(|| map.sample_batch(points, &mut values)));
        black_box::<&[Sample]>(&samples);
        black_box(&values);
    }
    times.map(|times| 1e9 * median(times) / points.len() as f64)
}

fn report(name: &str, asset: &Asset) {
    let map = VolumeMap::from_asset(asset).unwrap();
    let oracle = (!asset.is_adaptive()).then(|| Oracle::new(asset));
    let mut points = particles(&map);
    let opened = median((0..ROUNDS).map(|_| seconds(|| drop(VolumeMap::from_asset(asset)))).collect());
    let megabytes = map.memory_bytes() as f64 / 1e6;
    for order in ["random", "sorted"] {
        if order == "sorted" {
            let (origin, size) = (map.grid().origin, map.finest_cell_size());
            points.sort_by_key(|&x| {
                let cell = ((x - origin) / size).as_uvec3();
                (cell.z, cell.y, cell.x)
            });
        }
        let [plain, alone, batch, values] = queries(&map, oracle.as_ref(), &points);
        println!(
            "{name:22} {order:7} {plain:8.1} {alone:8.1} {batch:8.1} {values:8.1}  {:6.2} {megabytes:6.2}",
            1e3 * opened
        );
    }
}

/// Places of a jittered lattice, sorted by cells of 4 r as a solver's search does, where a map has 0 < Phi < 2 r.
fn fluid(map: &VolumeMap, spacing: f64) -> Vec<DVec3> {
    let mut random = Random(1);
    let (origin, size) = (map.grid().origin, map.grid().max_corner() - map.grid().origin);
    let [nx, ny, nz] = (size / spacing).floor().as_u64vec3().to_array();
    let mut points = Vec::new();
    for (i, j, k) in (0..nx).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k)))) {
        let place = DVec3::new(i as f64, j as f64, k as f64) + 0.5;
        let point = origin + spacing * (place + 0.2 * random.point(DVec3::NEG_ONE, DVec3::ONE));
        if is_near(map, point) {
            points.push(point);
        }
    }
    points.sort_by_key(|&x| {
        let cell = ((x - origin) / (4.0 * map.support_radius())).as_u64vec3();
        (cell.z, cell.y, cell.x)
    });
    points
}

/// Batches with the volume's gradient on several maps of one shape.
fn compare(paths: &[String]) {
    let maps: Vec<VolumeMap> = paths.iter().map(|path| VolumeMap::open(path).unwrap()).collect();
    for spacings in [1.0, 2.0] {
        let points = fluid(&maps[0], spacings * maps[0].support_radius());
        println!("{} points of spacing {spacings} r", points.len());
        let mut out = Vec::<Sample<SurfaceWithGradient>>::new();
        let mut times: Vec<Vec<f64>> = vec![Vec::new(); maps.len()];
        for _ in 0..ROUNDS {
            for (map, times) in maps.iter().zip(&mut times) {
                times.push(seconds(|| map.sample_batch(&points, &mut out)));
                black_box(&out);
            }
        }
        for ((path, map), times) in paths.iter().zip(&maps).zip(times) {
            let ns = 1e9 * median(times) / points.len() as f64;
            println!("  {ns:6.1} ns, {:8.2} MB, {path}", map.memory_bytes() as f64 / 1e6);
        }
    }
}

fn main() {
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    if !given.is_empty() {
        return compare(&given);
    }
    println!(
        "{POINTS} points with 0 < Phi < 2 r, medians of {ROUNDS} rounds, ns a point; from_asset in ms; MB in memory"
    );
    println!(
        "{:22} {:7} {:>8} {:>8} {:>8} {:>8}  {:>6} {:>6}",
        "map", "order", "oracle", "sample", "batch", "values", "open", "MB"
    );
    for (name, resolution, margin) in
        [("torus 20^3", [20; 3], 0.8), ("torus 40^3", [40; 3], 0.8), ("torus 96x44x96", [96, 44, 96], 0.3)]
    {
        let double = torus(resolution, margin);
        report(&format!("{name} f32"), &single(&double));
        report(&format!("{name} f64"), &double);
    }
    // From cells of 4 r to cells of r / 2, towards x = 0; the same by difference from a flat wall's volume.
    let grid = GridSpec { origin: [-1.2, -0.8, -1.2], cell_size: [0.4; 3], resolution: [6, 4, 6] };
    for (name, weight) in [("adaptive", 0), ("adaptive, flat wall", 1)] {
        report(
            &format!("{name} f32"),
            &single(&adaptive_asset(grid, 4, [&phi, &volume, &|x| x.x], |_| weight)),
        );
    }
}
