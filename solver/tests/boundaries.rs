//! All boundary methods and pressures at the boundary in small simulations: water at rest, momentum, threads, bad scenes.

use std::path::{Path, PathBuf};
use volmap_runtime::DVec3;
use volmap_solver::assemble::assemble;
use volmap_solver::scene::{Bake, Block, Body, FreeMotion, Motion, PerAxis, Scene, prepare};
use volmap_solver::settings::{BoundaryMethod, BoundaryPressure};
use volmap_solver::simulation::Simulation;

const RADIUS: f64 = 0.05;
const METHODS: [BoundaryMethod; 4] = [
    BoundaryMethod::VolumeMap,
    BoundaryMethod::DensityMap,
    BoundaryMethod::Particles,
    BoundaryMethod::TubeMap,
];
const PRESSURES: [BoundaryPressure; 4] =
    [BoundaryPressure::Own, BoundaryPressure::Mirror, BoundaryPressure::Sph, BoundaryPressure::Mls];

/// data/tank.obj is 3.1 m wide and high, on y = 0.
fn cube(edge: f64, invert: bool) -> Body {
    let scale = Some(PerAxis([edge / 3.1; 3]));
    Body {
        mesh: Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/tank.obj")),
        bake: Bake { invert, scale, cell_size: Some(2.0 * RADIUS), ..Bake::default() },
        ..Body::default()
    }
}

fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("maps")
}

fn scene(boundary: BoundaryMethod, pressure: BoundaryPressure, bodies: Vec<Body>) -> Scene {
    let mut scene =
        Scene { particle_radius: RADIUS, boundary, cache: Some(cache()), bodies, ..Scene::default() };
    scene.solver.boundary_pressure = pressure;
    scene
}

fn simulation(scene: &Scene) -> Simulation {
    Simulation::new(assemble(scene, prepare(scene, &mut |_| ()).unwrap()).unwrap()).unwrap()
}

/// Half a metre of water in a tank of a metre.
fn tank(boundary: BoundaryMethod, pressure: BoundaryPressure) -> Scene {
    let block = Block { min: [-0.5, 0.0, -0.5], max: [0.5, 0.5, 0.5], velocity: [0.0; 3] };
    Scene { blocks: vec![block], ..scene(boundary, pressure, vec![cube(1.0, true)]) }
}

fn rms_speed(simulation: &Simulation) -> f64 {
    let all = simulation.particles().velocities.iter().flatten();
    (all.map(|&x| f64::from(x).powi(2)).sum::<f64>() / simulation.particles().len() as f64).sqrt()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[derive(Debug, Default)]
struct Rest {
    floor: f64,
    layer: usize,
    top: f64,
    speed: f64,
    pressure: f64,
    inside: usize,
    iterations: f64,
    momentum: f64,
}

fn settle(scene: &Scene, end: f64) -> Rest {
    let mut simulation = simulation(scene);
    let mut rest = Rest::default();
    let mut count = 0.0;
    while simulation.time() < end {
        let report = simulation.step().unwrap();
        rest.inside += report.inside + report.removed;
        if simulation.time() > 0.5 * end {
            count += 1.0;
            rest.iterations += f64::from(report.density.iterations);
            let deep = simulation.particles().positions.iter().zip(simulation.pressures());
            let deep: Vec<f64> = deep
                .filter(|(x, _)| x.y > 0.1 && x.y < 0.4)
                .map(|(x, p)| f64::from(p) / (1000.0 * 9.81 * (0.5 - x.y)))
                .collect();
            rest.pressure += deep.iter().sum::<f64>() / deep.len() as f64;
            rest.speed += rms_speed(&simulation);
        }
    }
    rest.speed /= count;
    rest.pressure /= count;
    rest.iterations /= count;
    let positions = &simulation.particles().positions;
    let heights: Vec<f64> = positions.iter().map(|x| x.y / RADIUS).collect();
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let layer: Vec<f64> = heights.iter().copied().filter(|&y| y < lowest + 1.0).collect();
    rest.layer = layer.len();
    rest.floor = median(layer);
    rest.top = heights.iter().copied().fold(0.0, f64::max) * RADIUS + RADIUS;
    rest
}

#[test]
fn explore() {
    for method in METHODS {
        for pressure in PRESSURES {
            let start = std::time::Instant::now();
            let rest = settle(&tank(method, pressure), 2.0);
            println!("{method:?} {pressure:?} {:.2?} {rest:.3?}", start.elapsed());
        }
    }
}
