//! The step as a whole: conservation, what comes back from inside a body, and numbers that are none.

use std::path::Path;
use volmap_bake::parameters::{Parameters, Scale};
use volmap_bake::random::Random;
use volmap_fluid::Error;
use volmap_fluid::particles::Particles;
use volmap_fluid::setup::Setup;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;
use volmap_scenes::assemble::assemble;
use volmap_scenes::scene::{Block, Body, FreeMotion, Motion, Scene, prepare};

const SPACING: f64 = 0.1;

/// The solid of data/tank.obj, 3.1 m wide and high, on y = 0; or smaller.
fn solid(scale: f64, translation: [f64; 3], motion: Motion) -> Body {
    Body {
        mesh: Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/tank.obj")),
        bake: Parameters { scale: Some(Scale([scale; 3])), ..Parameters::default() },
        translation,
        motion,
        ..Body::default()
    }
}

/// No gravity; 3 x 3 x 3 particles far away stand for the fluid, to be replaced.
fn scene(bodies: Vec<Body>) -> Scene {
    Scene {
        particle_radius: 0.5 * SPACING,
        gravity: [0.0; 3],
        cache: Some(Path::new(env!("CARGO_TARGET_TMPDIR")).join("maps")),
        blocks: vec![Block { min: [9.0; 3], max: [9.3; 3], velocity: [0.0; 3], packing: Default::default() }],
        bodies,
        ..Scene::default()
    }
}

fn setup(scene: &Scene) -> Setup {
    assemble(scene, prepare(scene, &Default::default(), &mut |_| ()).unwrap()).unwrap()
}

fn block(min: DVec3, counts: [u32; 3]) -> Vec<DVec3> {
    let [nx, ny, nz] = counts;
    let at = move |n: u32| DVec3::new((n % nx).into(), (n / nx % ny).into(), (n / nx / ny).into());
    (0..nx * ny * nz).map(|n| min + SPACING * at(n)).collect()
}

fn fluid(positions: &[DVec3], velocity: impl Fn(usize) -> [f32; 3]) -> Particles {
    let mut particles = Particles::default();
    let velocities: Vec<_> = (0..positions.len()).map(velocity).collect();
    particles.add(positions, &velocities);
    particles
}

fn momentum(simulation: &Simulation) -> DVec3 {
    let velocities = simulation.particles().velocities.iter();
    let sum: DVec3 = velocities.map(|v| DVec3::from_array(v.map(f64::from))).sum();
    simulation.particle_mass() * sum + simulation.bodies().totals().momentum
}

/// Twice the kinetic energy for each mass.
fn energy(simulation: &Simulation) -> f64 {
    simulation.particles().velocities.iter().flatten().map(|&x| f64::from(x).powi(2)).sum()
}

#[test]
fn fluid_and_body_keep_their_momentum() {
    let free = Motion::Free(FreeMotion { density: Some(300.0), ..FreeMotion::default() });
    // A cube of 0.5 m; a block of fluid flies against it.
    let mut setup = setup(&scene(vec![solid(0.161_290_322_58, [0.0; 3], free)]));
    setup.particles = fluid(&block(DVec3::new(-1.5, -0.1, -0.3), [8, 8, 7]), |_| [2.0, 0.0, 0.0]);
    setup.domain = Some([DVec3::splat(-50.0), DVec3::splat(50.0)]);
    let mut simulation = Simulation::new(setup).unwrap();
    let start = momentum(&simulation);
    let mut touched = 0;
    for _ in 0..250 {
        let report = simulation.step().unwrap();
        touched += report.near_bodies;
        assert_eq!((report.inside, report.removed), (0, 0));
        assert!(
            (momentum(&simulation) - start).length() < 2e-6 * start.length(),
            "{}",
            momentum(&simulation) - start
        );
    }
    assert!(touched > 100, "{touched}");
    let body = simulation.bodies().totals().momentum;
    assert!(body.x > 0.05 * start.x, "the body was pushed: {body} of {start}");
}

#[test]
fn particles_in_a_body_come_back_calmly() {
    // At different depths below the top at 3.1 m, the last ones deeper than the map's band; all go deeper.
    for depth in [0.01, 0.05, 0.15, 0.35, 0.8, 1.4] {
        let mut setup = setup(&scene(vec![solid(1.0, [0.0; 3], Motion::Static)]));
        setup.particles = fluid(&[DVec3::new(0.1, 3.1 - depth, 0.2)], |_| [0.3, -1.0, 0.0]);
        let mut simulation = Simulation::new(setup).unwrap();
        let (mut last, mut steps) = (energy(&simulation), 0);
        loop {
            let report = simulation.step().unwrap();
            assert_eq!(simulation.particles().len(), 1);
            let now = energy(&simulation);
            if report.inside == 0 {
                break;
            }
            steps += 1;
            assert!(steps < 500, "{depth}: it stays in at {:?}", simulation.particles().positions);
            assert!(now <= last, "depth {depth}: {now} of {last}");
            last = now;
        }
        assert!(steps > 0, "it was counted");
        // Nor is it shot away from the surface.
        simulation.step().unwrap();
        assert!(
            energy(&simulation) <= last * 1.0001,
            "{depth}: {} {last} {:?}",
            energy(&simulation),
            simulation.particles()
        );
        let place = simulation.particles().positions[0];
        // By the top, or the side at z = 1.55 m, which is nearer to the last one.
        assert!(place.y.max(place.z + 1.55) >= 3.1 - 1e-3, "{depth}: {place}");
    }
}

#[test]
fn viscosity_calms_even_where_it_bounds_the_step() {
    let mut setup = setup(&scene(vec![]));
    let mut generator = Random::new(1);
    let mut random = || generator.unit() as f32 - 0.5;
    let places = block(DVec3::ZERO, [9, 8, 7]);
    let velocities: Vec<[f32; 3]> = places.iter().map(|_| [(); 3].map(|()| 0.1 * random())).collect();
    setup.particles = fluid(&places, |i| velocities[i]);
    setup.fluid.viscosity = 1.0;
    setup.solver.density.enabled = false;
    setup.solver.divergence.enabled = false;
    let mut simulation = Simulation::new(setup).unwrap();
    let mut last = energy(&simulation);
    let first = last;
    for _ in 0..40 {
        let report = simulation.step().unwrap();
        // r^2 / (120 nu)
        assert!(report.dt <= 0.04 / 120.0 * (1.0 + 1e-12));
        let now = energy(&simulation);
        assert!(now <= last, "{now} {last}");
        last = now;
    }
    assert!(last < 0.5 * first);
}

#[test]
fn what_is_no_number_is_an_error() {
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        let mut setup = setup(&scene(vec![]));
        setup.particles =
            fluid(&block(DVec3::ZERO, [8, 8, 8]), |i| [0.0, if i == 300 { bad } else { 0.0 }, 0.0]);
        let error = Simulation::new(setup).unwrap().step().unwrap_err();
        assert!(matches!(&error, Error::Simulation { step: 0, .. }), "{error}");
        assert!(error.to_string().contains("largest speed"), "{error}");
    }
}

#[test]
fn nothing_and_one_particle_are_a_fluid_too() {
    let mut empty = setup(&scene(vec![]));
    empty.particles = Particles::default();
    let mut simulation = Simulation::new(empty).unwrap();
    for _ in 0..3 {
        assert_eq!(simulation.step().unwrap().removed, 0);
    }
    assert!(simulation.time() > 0.0 && simulation.densities().is_empty());
    let mut one = setup(&Scene { gravity: [0.0, -10.0, 0.0], ..scene(vec![]) });
    one.particles = fluid(&[DVec3::ZERO], |_| [0.5, 0.0, 0.0]);
    let mut simulation = Simulation::new(one).unwrap();
    while simulation.time() < 0.5 {
        simulation.step().unwrap();
    }
    let [x, y, z] = simulation.particles().velocities[0].map(f64::from);
    assert!((x - 0.5).abs() < 1e-6 && (y + 10.0 * simulation.time()).abs() < 1e-5 && z == 0.0, "{x} {y}");
}
