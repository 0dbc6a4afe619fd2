//! The examples do what they say, and a force of a program's own goes on from a state with the same bits.

#[allow(dead_code)]
#[path = "../examples/step_by_step.rs"]
mod step_by_step;
#[allow(dead_code)]
#[path = "../examples/vortex_force.rs"]
mod vortex_force;

use vortex_force::{Vortices, mean_spin, shear};

#[test]
fn a_ball_falls_into_the_water() {
    let mut simulation = step_by_step::tank_with_ball().unwrap();
    assert_eq!(simulation.particles().len(), 10 * 6 * 10);
    for _ in 0..5 {
        step_by_step::tenth_of_a_second(&mut simulation).unwrap();
    }
    // It fell 0.27 m to the water and is carried by it.
    let ball = simulation.bodies().state(1).centre.y;
    assert!((0.3..0.75).contains(&ball), "{ball}");
    assert!(simulation.body_forces()[1][0].y > 10.0);
}

#[test]
fn spins_come_to_half_of_the_curl() {
    let text = vortex_force::run(100).unwrap();
    let mut simulation = shear(vec![Box::new(Vortices::new(0.05, 1e-3))]).unwrap();
    for _ in 0..100 {
        simulation.step().unwrap();
    }
    let spin = mean_spin(&simulation);
    // Particles at the surface see a part of the curl.
    assert!((-1.0..-0.6).contains(&spin), "{spin}: {text}");
}

#[test]
fn a_state_keeps_the_channels() {
    let simulation = || shear(vec![Box::new(Vortices::new(0.05, 1e-3))]).unwrap();
    let (mut straight, mut saved, mut restored) = (simulation(), simulation(), simulation());
    for step in 0..40 {
        straight.step().unwrap();
        if step < 20 {
            saved.step().unwrap();
        }
    }
    restored.restore(saved.state().unwrap()).unwrap();
    for _ in 20..40 {
        restored.step().unwrap();
    }
    assert!(mean_spin(&straight) != 0.0);
    assert!(straight.particles() == restored.particles());
    // A simulation without the force has no room for what it keeps.
    assert!(shear(Vec::new()).unwrap().restore(saved.state().unwrap()).is_err());
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    let error = shear(vec![Box::new(Vortices::new(0.05, 0.0))]).err().unwrap().to_string();
    assert!(error.starts_with("forces.vortices.inertia: "), "{error}");
    let twice: Vec<_> = (0..2).map(|_| Box::new(Vortices::new(0.05, 1e-3)) as _).collect();
    assert!(shear(twice).is_ok(), "of one kind, they share their channel");
}
