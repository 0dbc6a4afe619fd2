//! A simulation made in Rust, step by step: a ball falls into a tank of water.
//!
//! ```text
//! cargo run --release -p volmap-fluid --example step_by_step
//! ```

use volmap_fluid::Error;
use volmap_fluid::bodies::{Bodies, FreeBody, Motion, Weight};
use volmap_fluid::lattice::fill_box;
use volmap_fluid::observe;
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{FluidSettings, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{baked, ball, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

fn main() -> Result<(), Error> {
    let mut simulation = tank_with_ball()?;
    println!("{} particles", simulation.particles().len());
    while simulation.time() < 1.0 {
        println!("{}", tenth_of_a_second(&mut simulation)?);
    }
    Ok(())
}

/// Water in a tank of 0.8 x 0.8 m, and a ball of half of its density above it.
///
/// # Errors
/// A body that can't be baked or placed.
pub fn tank_with_ball() -> Result<Simulation, Error> {
    // Everything is in metres, seconds and kilograms; y is up.
    let world = World { particle_radius: 0.04, support_radius: 0.16, ..World::default() };

    // Bodies are meshes with maps, baked for the closure and the support radius. Of a container the hollow is the mesh.
    let hollow = cuboid(DVec3::new(-0.4, 0.0, -0.4), DVec3::new(0.4, 1.2, 0.4));
    let tank = baked(hollow, world.support_radius, true)?.body("tank", DVec3::ZERO, Motion::Static);
    let free = FreeBody { weight: Weight::Density(500.0), ..FreeBody::default() };
    let shape = baked(ball(0.15, 3), world.support_radius, false)?;
    let ball = shape.body("ball", DVec3::new(0.0, 0.9, 0.0), Motion::Free(free));
    let bodies = Bodies::new(vec![tank, ball], world.gravity)?;

    // The fluid begins as a lattice, a particle radius away from the walls.
    let places: Vec<DVec3> =
        fill_box([DVec3::new(-0.4, 0.0, -0.4), DVec3::new(0.4, 0.48, 0.4)], 2.0 * world.particle_radius)
            .collect();
    let mut particles = Particles::default();
    particles.add(&places, &vec![[0.0; 3]; places.len()]);

    let fluid = FluidSettings { rest_density: 1000.0, viscosity: 0.01, ..FluidSettings::default() };
    Simulation::new(Setup { fluid, ..Setup::new(world, particles, bodies) })
}

/// Simulates a tenth of a second, and says how things are then.
///
/// # Errors
/// As [`Simulation::step`].
pub fn tenth_of_a_second(simulation: &mut Simulation) -> Result<String, Error> {
    let (end, mut steps, mut iterations) = (simulation.time() + 0.1, 0, 0);
    while simulation.time() < end {
        let report = simulation.step()?;
        (steps, iterations) = (steps + 1, iterations + report.density.iterations);
    }
    let (ball, [force, _]) = (simulation.bodies().state(1), simulation.body_forces()[1]);
    Ok(format!(
        "{:.2} s: {steps} steps, {iterations} iterations; water's centre at {:.3} m, ball at {:.3} m, pushed {:.1} N",
        simulation.time(),
        observe::centre(simulation).y,
        ball.centre.y,
        force.y
    ))
}
