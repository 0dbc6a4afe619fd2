//! Fluids that begin spread instead of on a lattice, and full containers.

use std::path::{Path, PathBuf};
use volmap_bake::parameters::Parameters;
use volmap_bake::primitive::Primitive;
use volmap_bake::watch::Watch;
use volmap_fluid::observe::line;
use volmap_fluid::settings::BoundaryMethod;
use volmap_runtime::{ClosureKind, DVec3};
use volmap_scenes::plan::{Plan, plan};
use volmap_scenes::scene::{Block, Body, Fill, FreeMotion, Motion, Packing, Rotation, Scene, Spin};

const RP: f64 = 0.025;

fn scene() -> Scene {
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("packed-maps");
    Scene { particle_radius: RP, cache: Some(cache), gravity: [0.0; 3], ..Scene::default() }
}

/// The simulation at time 0.
fn begun(scene: &Scene) -> Plan {
    let mut plan = plan(scene, 1.0, &Watch::default(), &mut |_| ()).unwrap();
    plan.pack(scene, &Watch::default()).unwrap();
    plan
}

fn fill(shape: Primitive, packing: Packing) -> Fill {
    let rotation = Rotation::about([0.0, 0.0, 1.0], 45.0);
    Fill { shape: Some(shape), rotation, packing, ..Fill::default() }
}

/// Particles of a fill, in parts of its volume's.
fn filled(scene: &Scene, shape: Primitive) -> (f64, Plan) {
    let plan = begun(scene);
    let count = plan.simulation.particles().len() as f64;
    assert_eq!(plan.counts[0].particles as f64, count);
    (count * plan.simulation.particle_volume() / shape.volume(), plan)
}

/// Cubes turned by 45 degrees and balls, 8 rp wide and of 8 rp radius.
#[test]
fn spread_particles_fill_a_solid_and_are_at_rest() {
    let shapes = [Primitive::Box { size: [16.0 * RP; 3] }, Primitive::Sphere { radius: 8.0 * RP }];
    for (shape, on_lattice) in shapes.into_iter().zip([0.781, 0.716]) {
        let lattice = Scene { fills: vec![fill(shape, Packing::Lattice)], ..scene() };
        let (part, plan) = filled(&lattice, shape);
        assert!((part - on_lattice).abs() < 0.01, "{part}");
        let told = format!("its lattice fills {:.0}", 100.0 * on_lattice);
        assert!(plan.notes.iter().any(|note| note.contains(&told[..told.len() - 1])), "{:?}", plan.notes);

        let (part, mut plan) =
            filled(&Scene { fills: vec![fill(shape, Packing::Relaxed)], ..scene() }, shape);
        assert!((part - 1.0).abs() < 0.03, "{part}");
        assert!(plan.notes.is_empty(), "{:?}", plan.notes);
        let pose = fill(shape, Packing::Relaxed).pose();
        let deepest = |x: &DVec3| {
            let x = pose.to_map(*x);
            match shape {
                Primitive::Sphere { radius } => radius - x.length(),
                _ => 8.0 * RP - x.abs().max_element(),
            }
        };
        let all = &plan.simulation.particles().positions;
        assert!(all.iter().all(|x| deepest(x) > 0.5 * RP));
        let report = plan.simulation.step().unwrap();
        assert!(report.compression.largest < 0.011, "{:?}", report.compression);
    }
}

/// In a drum that turns, full of fluid, without friction.
#[test]
fn full_containers_of_every_method_stay_at_rest() {
    use BoundaryMethod::{DensityMap, Particles, TubeMap, VolumeMap};
    use ClosureKind::{Calibrated, Lattice, Mirror, Offset, Paper, Wedge};
    let closures = [Mirror, Calibrated, Wedge, Lattice, Offset, Paper].map(|kind| (VolumeMap, Some(kind)));
    let others = [DensityMap, TubeMap, Particles].map(|method| (method, None));
    for (boundary, closure) in closures.into_iter().chain(others) {
        let shape = Primitive::Cylinder { radius: 8.0 * RP, height: 16.0 * RP };
        let spin = Spin { axis: [0.0, 1.0, 0.0], rpm: 60.0, centre: None };
        let bake = Parameters { invert: Some(true), ..Parameters::default() };
        let drum = Body { shape: Some(shape), bake, motion: Motion::Spin(spin), ..Body::default() };
        let fills = vec![Fill { shape: Some(shape), ..Fill::default() }];
        let scene = Scene { boundary, closure, bodies: vec![drum], fills, ..scene() };
        let mut simulation = begun(&scene).simulation;
        while simulation.time() < 0.3 {
            simulation.step().unwrap();
        }
        let particles = simulation.particles();
        let all = particles.positions.iter().zip(&particles.velocities);
        let [mut turn, mut inertia] = [0.0; 2];
        for (x, v) in all {
            turn += x.z * f64::from(v[0]) - x.x * f64::from(v[2]);
            inertia += x.x * x.x + x.z * x.z;
        }
        let of_wall = turn / inertia / std::f64::consts::TAU;
        assert!(of_wall.abs() < 0.02, "{boundary:?} {closure:?}: {of_wall}");
        let rms = volmap_fluid::observe::rms_speed(&simulation);
        // Those that boiled had 0.5 to 1.8 m/s.
        assert!(
            rms < 0.07,
            "{boundary:?} {closure:?}: {rms} m/s, {} at the wall",
            0.2 * std::f64::consts::TAU
        );
    }
}

/// A block that fills a tank, with a method whose fluid rests farther from walls than rp: told, and spread at rest.
#[test]
fn blocks_too_near_to_walls_are_told_and_can_be_spread() {
    let bake = Parameters { invert: Some(true), ..Parameters::default() };
    let shape = Some(Primitive::Box { size: [16.0 * RP; 3] });
    let tank = Body { shape, bake, ..Body::default() };
    let speed = |packing: Packing| {
        let [min, max] = [[-8.0 * RP; 3], [8.0 * RP; 3]];
        let block = Block { min, max, velocity: [0.0; 3], packing };
        let boundary = BoundaryMethod::DensityMap;
        let mut plan = begun(&Scene { boundary, bodies: vec![tank.clone()], blocks: vec![block], ..scene() });
        for _ in 0..50 {
            plan.simulation.step().unwrap();
        }
        (volmap_fluid::observe::rms_speed(&plan.simulation), plan.notes)
    };
    let (fast, notes) = speed(Packing::Lattice);
    // All but the inner 6^3 of 8^3.
    assert!(notes.iter().any(|note| note.contains("296 particles begin nearer")), "{notes:?}");
    let (calm, notes) = speed(Packing::Relaxed);
    assert!(notes.is_empty(), "{notes:?}");
    assert!(calm < 0.02 && fast > 10.0 * calm, "{calm} {fast}");
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

/// A ball of 8 rp in water at rest, 16 rp below the surface; by how much its middle is off the lattice, in rp.
fn released(density: f64, off: f64) -> Scene {
    let rp = 0.0125;
    let size = [0.6, 0.6, 0.6];
    let bake = Parameters { invert: Some(true), ..Parameters::default() };
    let tank =
        Body { shape: Some(Primitive::Box { size }), bake, translation: [0.0, 0.3, 0.0], ..Body::default() };
    let ball = Body {
        shape: Some(Primitive::Sphere { radius: 8.0 * rp }),
        translation: [off * rp, 0.25 + off * rp, off * rp],
        motion: Motion::Free(FreeMotion { density: Some(density), ..FreeMotion::default() }),
        ..Body::default()
    };
    let block = Block {
        min: [-0.3, 0.0, -0.3],
        max: [0.3, 0.45, 0.3],
        velocity: [0.0; 3],
        packing: Packing::Relaxed,
    };
    let mut scene = Scene {
        particle_radius: rp,
        gravity: Scene::default().gravity,
        blocks: vec![block],
        bodies: vec![tank, ball],
        ..scene()
    };
    scene.fluid.viscosity = 0.0;
    scene
}

/// (rho_w - rho_b) g / (rho_b + rho_w / 2), the added mass of a ball; on the lattice and half a spacing off.
#[test]
fn a_released_ball_starts_as_its_added_mass_says() {
    for (density, off) in [(500.0, 0.0), (500.0, 1.0)] {
        let mut simulation = begun(&released(density, off)).simulation;
        let exact = 9.81 * (1000.0 - density) / (density + 500.0);
        let mut points = vec![[0.0, 0.0]];
        while simulation.time() < 0.05 {
            simulation.step().unwrap();
            points.push([simulation.time(), simulation.bodies().state(1).velocity.y]);
        }
        let [_, found] = line(&points);
        assert!((found / exact - 1.0).abs() < 0.1, "{density} {off}: {found} {exact}");
    }
}

#[test]
fn the_same_on_any_number_of_threads() {
    let shape = Primitive::Sphere { radius: 5.0 * RP };
    let scene = Scene { fills: vec![fill(shape, Packing::Relaxed)], ..scene() };
    let places = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| begun(&scene).simulation.particles().positions.clone())
    };
    assert_eq!(places(1), places(3));
}

#[test]
fn a_map_alone_cant_be_filled_evenly() {
    let map = Some(data("tank.h5"));
    let scene = Scene { fills: vec![Fill { map, packing: Packing::Relaxed, ..Fill::default() }], ..scene() };
    let error = scene.validate().unwrap_err().to_string();
    assert!(error.starts_with("fills[0].packing: \"relaxed\" needs `mesh` or `shape`"), "{error}");
}
