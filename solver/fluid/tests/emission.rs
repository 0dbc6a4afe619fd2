//! Nozzles under water and in each other: no particle comes on top of another, and what couldn't be given is counted.

use volmap_fluid::bodies::{Bodies, Motion};
use volmap_fluid::emitter::{Emitter, Jet};
use volmap_fluid::lattice::fill_box;
use volmap_fluid::observe::percentile;
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::World;
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{baked, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

const SPACING: f64 = 0.05;

/// A square nozzle of 0.2 m at a place, for a second.
fn nozzle(at: DVec3, direction: DVec3, speed: f64) -> Emitter {
    let right = direction.any_orthonormal_vector();
    let up = right.cross(direction);
    let place = |n: u32| {
        let [x, y] = [n % 4, n / 4].map(|n| SPACING * (f64::from(n) - 1.5));
        at + x * right + y * up
    };
    let layers = vec![(0..16).map(place).collect()];
    let jet = Jet {
        direction,
        speed,
        layers,
        spacing: SPACING,
        start: 0.0,
        stop: Some(1.0),
        max_particles: 10_000,
    };
    Emitter::new(jet)
}

fn nearest(places: &[DVec3]) -> f64 {
    let from = |n: usize| places[..n].iter().map(|x| x.distance(places[n])).fold(f64::INFINITY, f64::min);
    (1..places.len()).map(from).fold(f64::INFINITY, f64::min)
}

/// Water 0.3 m deep in a tank of 0.6 m x 0.6 m, with a nozzle in its middle that points upwards.
fn under_water(at: DVec3, speed: f64) -> Simulation {
    let world = World::default();
    let [low, high] = [DVec3::new(-0.3, 0.0, -0.3), DVec3::new(0.3, 0.6, 0.3)];
    let tank = baked(cuboid(low, high), world.support_radius, true).unwrap();
    let places: Vec<DVec3> = fill_box([low, high.with_y(0.3)], SPACING).collect();
    let mut particles = Particles::default();
    particles.add(&places, &vec![[0.0; 3]; places.len()]);
    let bodies = Bodies::new(vec![tank.body("tank", DVec3::ZERO, Motion::Static)], world.gravity).unwrap();
    let emitters = vec![nozzle(at, DVec3::Y, speed)];
    Simulation::new(Setup { emitters, ..Setup::new(world, particles, bodies) }).unwrap()
}

/// Height of the water, metres: half a spacing above the highest layer.
fn level(simulation: &Simulation) -> f64 {
    let heights: Vec<f64> = simulation.particles().positions.iter().map(|x| x.y).collect();
    percentile(&heights, 0.97) + 0.5 * SPACING
}

#[test]
fn a_nozzle_under_water_raises_the_level_by_what_it_says() {
    // Beside the water's lattice, and with a place on each of its points; the part of the flow that is given.
    for (at, speed, least) in
        [(DVec3::new(0.01, 0.13, 0.02), 0.1, 0.9), (DVec3::new(0.0, 0.15, 0.0), 1.0, 0.5)]
    {
        let mut simulation = under_water(at, speed);
        let mut densest = 0.0_f64;
        while simulation.time() < 3.0 {
            densest = densest.max(simulation.step().unwrap().compression.largest);
        }
        let state = &simulation.emitters()[0].state;
        // What is given and what isn't is all that is due, to a layer.
        let due = 16.0 * speed / SPACING;
        let told = (state.particles + state.held) as f64;
        assert!((told - due).abs() <= 16.0, "{told} of {due}");
        assert!(state.particles as f64 > least * told, "{state:?}");
        // A particle alone between others at rest makes 1.32 of them; they were up to 1.7 once.
        assert!(densest < 0.45, "{densest}");
        let expected = 0.3 + state.particles as f64 * simulation.particle_volume() / 0.36;
        let level = level(&simulation);
        assert!((level / expected - 1.0).abs() < 0.04, "{level} m instead of {expected} m");
    }
}

#[test]
fn nozzles_in_each_other_wait_for_each_other() {
    let world = World { gravity: DVec3::ZERO, ..World::default() };
    let emitters = vec![nozzle(DVec3::ZERO, DVec3::Y, 1.0), nozzle(DVec3::ZERO, DVec3::Y, 1.0)];
    let bodies = Bodies::new(Vec::new(), world.gravity).unwrap();
    let mut simulation =
        Simulation::new(Setup { emitters, ..Setup::new(world, Particles::default(), bodies) }).unwrap();
    let (mut count, mut closest) = (0, f64::INFINITY);
    while simulation.time() < 0.5 {
        let report = simulation.step().unwrap();
        // Looked at where they come; what the flow does with them later is another matter.
        if report.emitted > 0 {
            closest = closest.min(nearest(&simulation.particles().positions));
        }
        count += report.emitted;
    }
    assert!(closest > 0.4 * SPACING, "{closest} m");
    let states = [0, 1].map(|n| simulation.emitters()[n].state.clone());
    assert_eq!(states[0].particles + states[1].particles, count as u64);
    assert!(states[1].held > 0, "{states:?}");
}

#[test]
fn what_waits_is_in_a_checkpoint() {
    let at = DVec3::new(0.01, 0.13, 0.02);
    let mut whole = under_water(at, 1.0);
    while whole.emitters()[0].state.waiting.is_empty() {
        whole.step().unwrap();
    }
    let mut restored = under_water(at, 1.0);
    restored.restore(whole.state().unwrap()).unwrap();
    for _ in 0..150 {
        whole.step().unwrap();
        restored.step().unwrap();
        assert_eq!(whole.particles(), restored.particles());
    }
    assert_eq!(whole.emitters()[0].state, restored.emitters()[0].state);
    let mut foreign = whole.state().unwrap();
    foreign.emitters[0].waiting = vec![16];
    assert!(restored.restore(foreign).unwrap_err().contains("nozzle"));
}
