//! Fluids in two dimensions: water at rest has the pressure of its depth and stays in its plane, and what isn't known
//! there is refused.

use std::sync::Arc;
use volmap_bake::area_map::outline::OutlineDistance;
use volmap_bake::area_map::{AreaSettings, bake};
use volmap_bake::plan::GridChoice;
use volmap_fluid::bodies::{Bodies, Motion};
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{BoundaryMethod, FluidSettings, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{Shape, baked_for, ball, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_formats::mesh::Outline;
use volmap_runtime::{ClosureKind, DVec3, Dimension, VolumeMap};

const RADIUS: f64 = 0.025;
const SUPPORT: f64 = 4.0 * RADIUS;
const WIDTH: f64 = 0.5;
const LAYERS: u32 = 12;

fn tank() -> Shape {
    tank_for(ClosureKind::Offset)
}

fn tank_for(closure: ClosureKind) -> Shape {
    let radius = closure.map_radius(SUPPORT);
    let points = vec![[0.0, 0.0], [WIDTH, 0.0], [WIDTH, 1.0], [0.0, 1.0]];
    let outline = Outline { points, segments: vec![[0, 1], [1, 2], [2, 3], [3, 0]], ..Default::default() };
    let phi = OutlineDistance::new(&outline, true, 0.0);
    let settings = AreaSettings {
        support_radius: Some(radius),
        grid: GridChoice::CellSize(0.5 * radius),
        invert: true,
        ..AreaSettings::default()
    };
    let map =
        VolumeMap::from_asset(&bake(phi.bounds(), &|x| phi.at(x), &settings, &Default::default()).unwrap())
            .unwrap();
    let mesh = cuboid(DVec3::new(0.0, 0.0, -1.0), DVec3::new(WIDTH, 1.0, 1.0));
    Shape { mesh: Arc::new(mesh), map: Arc::new(map) }
}

fn world() -> World {
    World {
        dimension: Dimension::Two,
        particle_radius: RADIUS,
        support_radius: SUPPORT,
        closure: ClosureKind::Offset,
        ..World::default()
    }
}

fn setup(world: World, shape: &Shape) -> Setup {
    let across = (WIDTH / (2.0 * RADIUS)).round() as u32;
    let place = |n: u32| {
        let place = |n: u32| 2.0 * RADIUS * (f64::from(n) + 0.5);
        DVec3::new(place(n % across), place(n / across), 0.0)
    };
    let places: Vec<DVec3> = (0..across * LAYERS).map(place).collect();
    let mut particles = Particles::default();
    particles.add(&places, &vec![[0.0; 3]; places.len()]);
    let bodies = Bodies::new(vec![shape.body("tank", DVec3::ZERO, Motion::Static)], world.gravity).unwrap();
    Setup {
        fluid: FluidSettings { viscosity: 0.02, ..FluidSettings::default() },
        ..Setup::new(world, particles, bodies)
    }
}

fn simulated(closure: ClosureKind, time: f64) -> Simulation {
    let mut simulation = Simulation::new(setup(World { closure, ..world() }, &tank_for(closure))).unwrap();
    while simulation.time() < time {
        simulation.step().unwrap();
    }
    simulation
}

#[test]
fn water_stays_in_its_plane_and_at_rest_has_the_pressure_of_its_depth() {
    for closure in [ClosureKind::Offset, ClosureKind::Mirror] {
        rests(closure);
    }
}

fn rests(closure: ClosureKind) {
    let simulation = simulated(closure, 2.0);
    assert!((simulation.particle_mass() - 1000.0 * 4.0 * RADIUS * RADIUS).abs() < 1e-12);
    let particles = simulation.particles();
    assert_eq!(particles.len(), (LAYERS * 10) as usize);
    assert!(particles.positions.iter().all(|x| x.z == 0.0 && x.x > 0.0 && x.x < WIDTH && x.y > 0.0));
    assert!(particles.velocities.iter().all(|v| v[2] == 0.0));
    if closure == ClosureKind::Offset {
        // Its walls throw single particles of so small a tank to and fro, and pressures with them.
        return;
    }
    // Pressure grows by rho g with depth, between the layers in the middle.
    let depths = particles.positions.iter().zip(simulation.pressures());
    let inner = |(x, _): &(&DVec3, f32)| (0.12..0.38).contains(&x.x) && (0.15..0.45).contains(&x.y);
    let points: Vec<[f64; 2]> = depths.filter(inner).map(|(x, p)| [x.y, f64::from(p)]).collect();
    let [_, slope] = volmap_fluid::observe::line(&points);
    assert!((slope / -9810.0 - 1.0).abs() < 0.15, "{closure}: {slope} Pa/m");
}

#[test]
fn steps_are_the_same_on_any_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| simulated(ClosureKind::Offset, 0.1)).particles().clone()
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn what_is_not_known_in_two_dimensions_is_refused() {
    let flat = tank();
    let error = |setup: Setup| Simulation::new(setup).err().expect("is refused").to_string();
    let closure = |closure| setup(World { closure, ..world() }, &flat);
    assert!(error(closure(ClosureKind::Calibrated)).contains("closure: in two dimensions"));
    let particles = World { boundary: BoundaryMethod::Particles, ..world() };
    assert!(error(setup(particles, &flat)).contains("volume maps and density maps"));
    let mut lifted = setup(world(), &flat);
    lifted.particles.positions[3].z = 0.1;
    assert!(error(lifted).contains("z = 0"));
    let solid = baked_for(ClosureKind::Offset, ball(0.2, 2), SUPPORT, false).unwrap();
    assert!(error(setup(world(), &solid)).contains("its map is in 3 dimensions, the fluid in 2"));
    let space = World { dimension: Dimension::Three, ..world() };
    assert!(error(setup(space, &flat)).contains("its map is in 2 dimensions, the fluid in 3"));
}
