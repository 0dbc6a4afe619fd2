//! All boundary methods and pressures at the boundary in small simulations: densities at a wall, water at rest,
//! momentum, threads, and scenes that can't be.

use std::path::{Path, PathBuf};
use volmap_bake::parameters::{Parameters, Scale};
use volmap_fluid::boundary::{Boundary, tube_map};
use volmap_fluid::settings::BoundaryMethod::{self, DensityMap, Particles, TubeMap, VolumeMap};
use volmap_fluid::settings::BoundaryPressure::{self, Mirror, Mls, Own, Sph};
use volmap_fluid::shapes::ball;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{ClosureKind, DVec3, KernelKind};
use volmap_scenes::assemble::assemble;
use volmap_scenes::scene::{Block, Body, FreeMotion, Motion, Scene, Syntax, parse, prepare};

const RADIUS: f64 = 0.05;
const METHODS: [BoundaryMethod; 4] = [VolumeMap, DensityMap, Particles, TubeMap];
const PRESSURES: [BoundaryPressure; 4] = [Own, Mirror, Sph, Mls];

/// data/tank.obj is 3.1 m wide and high, on y = 0.
fn cube(edge: f64, invert: bool) -> Body {
    let scale = Some(Scale([edge / 3.1; 3]));
    Body {
        mesh: Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/tank.obj")),
        bake: Parameters {
            invert: Some(invert),
            scale,
            cell_size: Some(2.0 * RADIUS),
            ..Parameters::default()
        },
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
    if boundary == VolumeMap {
        // Narrow maps need finer cells than the others.
        scene.bodies.iter_mut().for_each(|body| body.bake.cell_size = Some(0.5 * RADIUS));
    }
    scene
}

fn simulation(scene: &Scene) -> Simulation {
    Simulation::new(assemble(scene, prepare(scene, &Default::default(), &mut |_| ()).unwrap()).unwrap())
        .unwrap()
}

/// 9 x 5 x 9 particles in a tank of a metre, which begin a spacing from its walls.
fn tank(boundary: BoundaryMethod, pressure: BoundaryPressure) -> Scene {
    let block = Block {
        min: [-0.45, 0.05, -0.45],
        max: [0.45, 0.55, 0.45],
        velocity: [0.0; 3],
        packing: Default::default(),
    };
    Scene { blocks: vec![block], ..scene(boundary, pressure, vec![cube(1.0, true)]) }
}

/// A cube that floats without gravity, and water that flies against it.
fn collision(boundary: BoundaryMethod, pressure: BoundaryPressure) -> Scene {
    let free = Motion::Free(FreeMotion { density: Some(500.0), ..FreeMotion::default() });
    let body = Body { motion: free, ..cube(0.5, false) };
    let block = Block {
        min: [-0.8, 0.1, -0.2],
        max: [-0.3, 0.4, 0.2],
        velocity: [1.0, 0.0, 0.0],
        packing: Default::default(),
    };
    let domain = Some(volmap_scenes::scene::Region { min: [-50.0; 3], max: [50.0; 3] });
    Scene { gravity: [0.0; 3], blocks: vec![block], domain, ..scene(boundary, pressure, vec![body]) }
}

/// What the middle of a tank's floor adds at a height, over rho_0, and its gradient.
fn of_floor(method: BoundaryMethod, height: f64) -> (f64, DVec3) {
    let scene = tank(method, Own);
    let setup = assemble(&scene, prepare(&scene, &Default::default(), &mut |_| ()).unwrap()).unwrap();
    let mut boundary = Boundary::new(&setup.world, &setup.fluid, &setup.bodies).unwrap();
    boundary.sample_alone(&setup.bodies, &[DVec3::new(0.02, height, -0.03)]);
    let wall = boundary.of_particle[0];
    (wall.density.into(), DVec3::from_array(wall.gradient.map(f64::from)))
}

#[test]
fn density_maps_and_tubes_have_the_integral_over_a_half_space() {
    for method in [DensityMap, TubeMap] {
        for d in [0.1, 0.25, 0.5, 0.75] {
            let [value, slope] = tube_map::density(KernelKind::CubicSpline, d, [0.0; 2]);
            let (density, gradient) = of_floor(method, d * 0.2);
            // Cells of a density map are half a support radius wide here.
            let bound = if method == TubeMap { 1e-3 } else { 0.05 };
            assert!((density - value).abs() < bound * value.max(0.2), "{method:?} {d}: {density} {value}");
            let bound = 4.0 * bound * slope.abs().max(0.5) / 0.2;
            assert!((gradient.y - slope / 0.2).abs() < bound, "{method:?} {d}: {gradient} {slope}");
            assert!(gradient.with_y(0.0).length() < 0.05 * gradient.length(), "{method:?} {d}: {gradient}");
        }
    }
}

#[test]
fn particles_have_the_density_of_a_sheet() {
    let sheet = |z: f64| KernelKind::CubicSpline.sheet_integral(z);
    for d in [0.25, 0.5, 0.75] {
        let (density, gradient) = of_floor(Particles, d * 0.2);
        let exact = sheet(d) / sheet(0.0);
        assert!((density - exact).abs() < 0.1 * exact.max(0.2), "{d}: {density} {exact}");
        assert!(
            gradient.y < 0.0 && gradient.with_y(0.0).length() < 0.2 * gradient.length(),
            "{d}: {gradient}"
        );
    }
}

/// Of water that has settled for a while.
#[derive(Debug)]
struct Rest {
    /// Median height of the lowest particles, rp.
    floor: f64,
    /// 99th percentile of the height, and rp: metres.
    top: f64,
    /// Root of the mean square in the last fifth, m/s.
    speed: f64,
    /// Particles found in the wall or lost.
    inside: usize,
}

fn settle(scene: &Scene, end: f64) -> Rest {
    let mut simulation = simulation(scene);
    let (mut squares, mut steps, mut inside) = (0.0, 0.0, 0);
    while simulation.time() < end {
        let report = simulation.step().unwrap();
        inside += report.inside + report.removed;
        if simulation.time() > 0.8 * end {
            let all = simulation.particles().velocities.iter().flatten();
            squares += all.map(|&x| f64::from(x).powi(2)).sum::<f64>() / simulation.particles().len() as f64;
            steps += 1.0;
        }
    }
    let mut heights: Vec<f64> = simulation.particles().positions.iter().map(|x| x.y).collect();
    heights.sort_by(f64::total_cmp);
    let layer = heights.partition_point(|&y| y < heights[5] + RADIUS);
    let [floor, top] = [heights[layer / 2] / RADIUS, heights[heights.len() * 99 / 100] + RADIUS];
    Rest { floor, top, speed: (squares / steps).sqrt(), inside }
}

/// Simulates 1.2 s of each pressure; bounds are wider than what is reached: of the first layer, the height, the speed.
fn rests(method: BoundaryMethod, bounds: &[(BoundaryPressure, [f64; 2], f64, f64)]) {
    for &(pressure, [low, high], top, speed) in bounds {
        let rest = settle(&tank(method, pressure), 1.2);
        println!("{method:?} {pressure:?} {rest:.3?}");
        assert!((low..=high).contains(&rest.floor), "{pressure:?} {rest:?}");
        assert!(rest.top < top && rest.speed < speed && rest.inside == 0, "{pressure:?} {rest:?}");
    }
}

#[test]
fn water_rests_on_volume_maps() {
    rests(
        VolumeMap,
        &[(Own, [0.9, 1.2], 0.46, 0.25), (Sph, [0.9, 1.3], 0.48, 0.25), (Mls, [0.9, 1.3], 0.48, 0.25)],
    );
}

#[test]
fn water_rests_on_density_maps() {
    rests(DensityMap, &[(Own, [1.1, 1.6], 0.55, 0.2), (Mls, [1.4, 2.2], 0.58, 0.3)]);
}

#[test]
fn water_rests_on_particles() {
    rests(Particles, &[(Own, [1.5, 2.2], 0.65, 0.3), (Mls, [1.8, 2.7], 0.65, 0.3)]);
}

#[test]
fn water_rests_on_tubes() {
    rests(TubeMap, &[(Own, [1.1, 1.6], 0.55, 0.3)]);
}

#[test]
fn water_rests_on_tubes_in_a_bowl() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bowl.obj");
    let mesh = ball(0.6, 4);
    let vertices = mesh.vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = mesh.triangles.iter().map(|t| t.map(|v| v + 1)).map(|[a, b, c]| format!("f {a} {b} {c}\n"));
    std::fs::write(&path, vertices.chain(faces).collect::<String>()).unwrap();
    let bake = Parameters { invert: Some(true), cell_size: Some(2.0 * RADIUS), ..Parameters::default() };
    let body = Body { mesh: Some(path), bake, ..Body::default() };
    let block = Block {
        min: [-0.3, -0.4, -0.3],
        max: [0.3, 0.0, 0.3],
        velocity: [0.0; 3],
        packing: Default::default(),
    };
    for pressure in [Own, Mls] {
        let scene = Scene { blocks: vec![block.clone()], ..scene(TubeMap, pressure, vec![body.clone()]) };
        let rest = settle(&scene, 1.2);
        println!("TubeMap {pressure:?} {rest:.3?}");
        // The lowest belong 1 rp above the bowl, -12 rp.
        assert!((-11.0..-9.0).contains(&rest.floor) && rest.speed < 0.4 && rest.inside == 0, "{rest:?}");
    }
}

fn momentum(simulation: &Simulation) -> DVec3 {
    let velocities = simulation.particles().velocities.iter();
    let sum: DVec3 = velocities.map(|v| DVec3::from_array(v.map(f64::from))).sum();
    simulation.particle_mass() * sum + simulation.bodies().totals().momentum
}

#[test]
fn fluid_and_body_keep_their_momentum() {
    for method in METHODS {
        for pressure in PRESSURES {
            let mut simulation = simulation(&collision(method, pressure));
            let start = momentum(&simulation);
            for _ in 0..80 {
                // What is put back out of a body loses its momentum.
                assert_eq!(simulation.step().unwrap().inside, 0, "{method:?} {pressure:?}");
                let error = (momentum(&simulation) - start).length() / start.length();
                assert!(error < 2e-6, "{method:?} {pressure:?}: {error}");
            }
            let body = simulation.bodies().totals().momentum.x / start.x;
            println!("{method:?} {pressure:?}: {body:.3}");
            assert!(body > 0.01, "{method:?} {pressure:?}: the body took {body} of it");
        }
    }
}

#[test]
fn threads_change_nothing() {
    let after = |threads: usize, scene: &Scene| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = simulation(scene);
            for _ in 0..15 {
                simulation.step().unwrap();
            }
            simulation.particles().clone()
        })
    };
    for method in METHODS {
        for scene in [tank(method, Sph), tank(method, Mls), collision(method, Mls)] {
            assert_eq!(after(1, &scene), after(3, &scene), "{method:?}");
        }
    }
}

#[test]
fn boundary_particles_are_counted() {
    let prepared = prepare(&tank(Particles, Own), &Default::default(), &mut |_| ()).unwrap();
    // 6 m^2 at 0.075 m.
    assert_eq!(prepared.bodies[0].boundary_particles, Some(1067));
    assert_eq!(simulation(&tank(Particles, Own)).boundary_particles(), 1067);
    assert_eq!(simulation(&tank(VolumeMap, Own)).boundary_particles(), 0);
}

fn refused(text: &str) -> String {
    let text = format!("version = 1\nparticle_radius = 0.05\n{text}");
    parse(&text, Syntax::Toml, "scene.toml").unwrap_err().to_string()
}

#[test]
fn settings_that_contradict_are_refused() {
    let body = "[[bodies]]\nmap = \"a.h5\"\n";
    let both = refused("boundary = \"particles\"\nclosure = \"mirror\"");
    assert!(both.contains("scene.toml:4:1: closure: belongs to volume maps"), "{both}");
    let sampling = refused("boundary_sampling = \"blue_noise\"");
    assert!(sampling.contains("boundary_sampling: belongs to boundary particles"), "{sampling}");
    let map = refused(&format!("boundary = \"particles\"\n{body}"));
    assert!(map.contains("scene.toml:5:1: bodies[0].map: ") && map.contains("give `mesh`"), "{map}");
    let kernel = refused("boundary = \"density_map\"\nkernel = \"spiky\"");
    assert!(kernel.contains("kernel: density maps are baked for cubic_spline and wendland_c2"), "{kernel}");
    let unknown = refused("boundary = \"partikel\"");
    assert!(unknown.contains("unknown value `partikel`"), "{unknown}");
    let old = refused("[solver]\nmirrored_pressure = true");
    assert!(old.contains("unknown key `mirrored_pressure`"), "{old}");
    let thick = "[[bodies]]\nmesh = \"a.obj\"\nbake = { thickness = 0.1 }";
    let thick = refused(&format!("boundary = \"particles\"\n{thick}"));
    assert!(thick.contains("bodies[0].bake.thickness"), "{thick}");
}

#[test]
fn maps_without_the_density_of_the_kernel_are_refused() {
    // Any asset that was baked for another boundary.
    let volume = tank(VolumeMap, Own);
    let setup = assemble(&volume, prepare(&volume, &Default::default(), &mut |_| ()).unwrap()).unwrap();
    let world = Scene { boundary: DensityMap, ..volume }.world();
    let error = Boundary::new(&world, &setup.fluid, &setup.bodies).unwrap_err().to_string();
    assert!(error.contains("tank") && error.contains("it holds no density"), "{error}");
    let density = tank(DensityMap, Own);
    let setup = assemble(&density, prepare(&density, &Default::default(), &mut |_| ()).unwrap()).unwrap();
    let world = Scene { kernel: volmap_runtime::KernelKind::WendlandC2, ..density }.world();
    let error = Boundary::new(&world, &setup.fluid, &setup.bodies).unwrap_err().to_string();
    assert!(error.contains("cubic_spline, the scene's is wendland_c2"), "{error}");
}

#[test]
fn assets_without_a_density_are_refused_with_the_cure() {
    let folder = tempfile::tempdir().unwrap();
    let wide = Some(ClosureKind::Calibrated);
    prepare(
        &Scene { cache: Some(folder.path().into()), closure: wide, ..tank(VolumeMap, Own) },
        &Default::default(),
        &mut |_| (),
    )
    .unwrap();
    let map = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    let scene = scene(DensityMap, Own, vec![Body { map: Some(map), ..Body::default() }]);
    let error = prepare(&scene, &Default::default(), &mut |_| ()).unwrap_err().to_string();
    assert!(error.starts_with("bodies[0].map") && error.contains("it holds no density"), "{error}");
    assert!(
        error.contains("support_radius = 0.2, invert = true, density = true, kernel = \"cubic_spline\""),
        "{error}"
    );
}
