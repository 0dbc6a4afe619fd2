//! Implicit viscosity and pressure together: what is stiff stands still, creeps as its closed form says, and flows in
//! long steps as in short ones.

use volmap_fluid::bodies::{Bodies, Motion};
use volmap_fluid::observe::{centre, kinetic_energy, momenta, until, velocities};
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{FluidSettings, TimeStepSettings, ViscosityMethod, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{baked, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

const RP: f64 = 0.025;
const SPACING: f64 = 2.0 * RP;
const GRAVITY: f64 = 9.81;

/// A block of particles on the floor of a frictionless tank; its lowest corner.
fn standing(viscosity: f64, counts: [u32; 3], corner: DVec3) -> Setup {
    let world = World { particle_radius: RP, support_radius: 4.0 * RP, ..World::default() };
    let [min, max] = [DVec3::new(-0.3, 0.0, -0.15), DVec3::new(0.3, 0.6, 0.15)];
    let tank = baked(cuboid(min, max), world.support_radius, true).unwrap();
    let bodies = Bodies::new(vec![tank.body("tank", DVec3::ZERO, Motion::Static)], world.gravity).unwrap();
    filled(world, bodies, viscosity, counts, corner)
}

fn filled(world: World, bodies: Bodies, viscosity: f64, counts: [u32; 3], corner: DVec3) -> Setup {
    let [nx, ny, nz] = counts;
    let at = |n: u32| DVec3::new((n % nx).into(), (n / nx % ny).into(), (n / nx / ny).into());
    let places: Vec<DVec3> = (0..nx * ny * nz).map(|n| corner + RP + SPACING * at(n)).collect();
    let mut particles = Particles::default();
    particles.add(&places, &vec![[0.0; 3]; places.len()]);
    let fluid =
        FluidSettings { viscosity, viscosity_method: ViscosityMethod::Implicit, ..FluidSettings::default() };
    Setup {
        fluid,
        domain: Some([DVec3::splat(-5.0), DVec3::splat(5.0)]),
        ..Setup::new(world, particles, bodies)
    }
}

/// Beside a wall that nothing holds it to; steps of 2 ms.
#[test]
fn a_stiff_block_stays_where_it_stands() {
    for viscosity in [1e3, 1e6, 1e9] {
        let corner = DVec3::new(-0.3, 0.0, -0.15);
        let mut simulation = Simulation::new(standing(viscosity, [5, 8, 6], corner)).unwrap();
        let start = centre(&simulation);
        until(&mut simulation, 0.3, &mut |_, report| {
            assert!(report.viscosity.error <= 1e-3, "{report:?}");
        })
        .unwrap();
        let mass = simulation.particle_mass() * simulation.particles().len() as f64;
        let drift = momenta(&simulation)[0] / mass;
        let moved = centre(&simulation) - start;
        assert!(drift.x.abs() < 1e-3 && drift.z.abs() < 1e-3, "{viscosity}: {drift} m/s");
        assert!(moved.x.abs() < 5e-4 && moved.y.abs() < 1e-3, "{viscosity}: {moved}");
    }
}

/// A free column on a frictionless floor: 3 rho nu dv/dy = -rho g (h - y), of which the mean is g h^2 / (9 nu). A cubic
/// lattice is 0.7 times as viscous along its axes, and its surface lacks neighbours; g dt, which it isn't, is 20 mm/s.
#[test]
fn a_column_creeps_as_its_closed_form_says() {
    let world = World { particle_radius: RP, support_radius: 4.0 * RP, ..World::default() };
    let floor =
        baked(cuboid(DVec3::new(-1.0, -0.2, -1.0), DVec3::new(1.0, 0.0, 1.0)), 4.0 * RP, false).unwrap();
    for viscosity in [20.0, 200.0] {
        let body = floor.body("floor", DVec3::ZERO, Motion::Static);
        let bodies = Bodies::new(vec![body], world.gravity).unwrap();
        let corner = DVec3::new(-4.5, 0.0, -4.5) * SPACING;
        let setup = filled(world.clone(), bodies, viscosity, [9, 5, 9], corner);
        let mut simulation = Simulation::new(setup).unwrap();
        until(&mut simulation, 0.3, &mut |_, _| ()).unwrap();
        let before = centre(&simulation).y;
        until(&mut simulation, 0.5, &mut |_, _| ()).unwrap();
        let sinks = (before - centre(&simulation).y) / 0.2;
        let exact = GRAVITY * (5.0 * SPACING).powi(2) / (9.0 * viscosity);
        assert!((0.8..1.4).contains(&(sinks / exact)), "{viscosity}: {sinks} of {exact} m/s");
    }
}

/// A block that slumps: implicit steps of 2 ms against explicit ones that are 30 times as short.
#[test]
fn long_steps_flow_as_short_explicit_ones() {
    let slumped = |method: ViscosityMethod| {
        let mut setup = standing(1.0, [5, 8, 6], DVec3::new(-0.3, 0.0, -0.15));
        setup.fluid.viscosity_method = method;
        if method == ViscosityMethod::Explicit {
            setup.solver.time_step.min = 6e-5;
            setup.solver.time_step.initial = 6e-5;
        }
        let mut simulation = Simulation::new(setup).unwrap();
        let start = centre(&simulation);
        until(&mut simulation, 0.25, &mut |_, _| ()).unwrap();
        (centre(&simulation) - start, kinetic_energy(&simulation), simulation.steps())
    };
    let (exact, energy, many) = slumped(ViscosityMethod::Explicit);
    let (moved, got, few) = slumped(ViscosityMethod::Implicit);
    assert!(many > 20 * few && exact.y < -0.005, "{many} {few} {exact}");
    assert!((moved - exact).length() < 0.05 * exact.length(), "{moved} {exact}");
    assert!((got / energy - 1.0).abs() < 0.1, "{got} {energy}");
}

/// A thick block beside a wall: the wall's pressure, which no viscous stress of the wall's answers, pushes it away while
/// it spreads. That isn't made by long steps, as they push no more than short ones.
#[test]
fn a_thick_block_leaves_a_wall_in_long_steps_as_in_short_ones() {
    let moved = |dt: f64| {
        let mut setup = standing(10.0, [5, 8, 6], DVec3::new(-0.3, 0.0, -0.15));
        setup.solver.time_step =
            TimeStepSettings { initial: dt, min: dt, max: dt, ..TimeStepSettings::default() };
        let mut simulation = Simulation::new(setup).unwrap();
        let start = centre(&simulation);
        until(&mut simulation, 0.3, &mut |_, _| ()).unwrap();
        centre(&simulation) - start
    };
    let (exact, found) = (moved(2e-4), moved(2e-3));
    assert!((0.003..0.006).contains(&exact.x) && found.x < 1.1 * exact.x, "{found} {exact}");
    assert!((found.y / exact.y - 1.0).abs() < 0.4, "{found} {exact}");
}

/// Pressures press apart what lies in each other, but give it no speed.
#[test]
fn what_begins_too_dense_comes_apart_slowly() {
    let mut setup = standing(1e3, [5, 8, 6], DVec3::new(-0.1, 0.0, -0.15));
    setup.world.gravity = DVec3::ZERO;
    let middle = DVec3::new(0.0, 0.2, 0.0);
    for x in &mut setup.particles.positions {
        *x = middle + (*x - middle) * DVec3::new(0.97, 1.0, 1.0);
    }
    let mut simulation = Simulation::new(setup).unwrap();
    let mut first = 0.0;
    until(&mut simulation, 0.2, &mut |_, report| first = f64::max(first, report.compression.mean)).unwrap();
    let fastest = velocities(&simulation).map(DVec3::length).fold(0.0, f64::max);
    assert!(first > 0.01 && fastest < 1e-3, "{first} {fastest} m/s");
    let report = simulation.step().unwrap();
    assert!(report.compression.mean < 1e-3, "{:?}", report.compression);
}
