//! Forces against closed forms.

use volmap_fluid::bodies::Bodies;
use volmap_fluid::forces::ForceSettings;
use volmap_fluid::forces::damping::Damping;
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::World;
use volmap_fluid::setup::Setup;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

/// Particles that are nobody's neighbours.
fn apart(gravity: DVec3, rate: f64) -> Result<Simulation, volmap_fluid::Error> {
    let world = World { gravity, ..World::default() };
    let places: Vec<DVec3> = (0..10).map(|n| DVec3::new(f64::from(n), 0.0, 0.0)).collect();
    let velocities: Vec<[f32; 3]> = (0..10_u8).map(|n| [0.1 * f32::from(n), 1.0, -0.5]).collect();
    let mut particles = Particles::default();
    particles.add(&places, &velocities);
    let forces = ForceSettings { damping: Some(Damping { rate }) };
    let bodies = Bodies::new(Vec::new(), gravity)?;
    Simulation::new(Setup { forces, ..Setup::new(world, particles, bodies) })
}

#[test]
fn damped_velocities_decay_exponentially() {
    let mut simulation = apart(DVec3::ZERO, 3.0).unwrap();
    while simulation.time() < 0.5 {
        simulation.step().unwrap();
    }
    let part = (-3.0 * simulation.time()).exp() as f32;
    let particles = simulation.particles();
    for (velocity, &id) in particles.velocities.iter().zip(&particles.ids) {
        let exact = [0.1 * id as f32, 1.0, -0.5].map(|before| part * before);
        assert!(velocity.iter().zip(exact).all(|(got, exact)| (got - exact).abs() < 1e-5), "{velocity:?}");
    }
}

#[test]
fn rain_falls_with_gravity_over_rate() {
    let mut simulation = apart(DVec3::new(0.0, -9.81, 0.0), 20.0).unwrap();
    while simulation.time() < 1.0 {
        simulation.step().unwrap();
    }
    // Gravity acts once a step, of 2 ms at most: by half of 2 ms x 20 / s more.
    let fall = simulation.particles().velocities.iter().map(|velocity| f64::from(-velocity[1]));
    assert!(fall.into_iter().all(|speed| (speed * 20.0 / 9.81 - 1.0).abs() < 0.03));
}

#[test]
fn a_damping_that_cannot_be_is_refused() {
    for rate in [-1.0, f64::NAN, f64::INFINITY] {
        let error = apart(DVec3::ZERO, rate).err().unwrap().to_string();
        assert!(error.starts_with("forces.damping.rate: "), "{error}");
    }
}
