//! What must hold in any scene, step by step.

use crate::scene::{RP, Scene};
use std::panic::{AssertUnwindSafe, catch_unwind};
use volmap_fluid::observe::{kinetic_energy, momenta, velocities};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

/// Energy may grow by so much in a step, and in all, in parts of [`Scene::energy`]: with the boundary's default
/// pressure, whose forces are the gradient of what is kept; and with the others, which aren't and are bounded. Of
/// 3,000 scenes the worst of the first had 0.09 and 0.6 %; without the bound the others had 16 and 35 %.
const GROWTH: [f64; 2] = [1e-3, 1e-2];
const GROWTH_BY_OTHERS: [f64; 2] = [2e-2, 5e-2];
/// A fluid that was pressed together by some per cent lost energy by it, and gets a part of it back in so many steps:
/// growth is what goes beyond the highest energy of these.
const RECENT: usize = 16;
/// So much more in a step for so many steps after a particle was found in a body: it is put out among others, which are
/// pressed together by it and part again.
const GROWTH_BY_STRAYS: f64 = 5e-3;
/// Momentum is kept to this, in parts of what moves. In a fall every step may round the velocities of all particles
/// alike: half a unit in their last place. So much of what viscosity exchanges is rounded, too.
const MOMENTUM: f64 = 1e-6;
const ROUNDING: f64 = 6e-8;

/// Mass, momentum and energy of fluid and free bodies.
struct Sums {
    momentum: DVec3,
    energy: f64,
    /// Sum of all m |v|.
    motion: f64,
    mass: f64,
    fastest: f64,
}

impl Sums {
    fn of(simulation: &Simulation, gravity: DVec3) -> Sums {
        let (mass, bodies) = (simulation.particle_mass(), simulation.bodies());
        let totals = bodies.totals();
        let [momentum, _] = momenta(simulation);
        let height: f64 = simulation.particles().positions.iter().map(|x| -gravity.dot(*x)).sum();
        let free = (0..bodies.posed().len()).filter_map(|body| Some((body, bodies.mass(body)?.mass)));
        let moving = |(body, mass): (usize, f64)| mass * bodies.state(body).velocity.length();
        let speeds: Vec<f64> = velocities(simulation).map(DVec3::length).collect();
        Sums {
            momentum: momentum + totals.momentum,
            energy: kinetic_energy(simulation)
                + mass * height
                + totals.kinetic_energy
                + totals.potential_energy,
            motion: mass * speeds.iter().sum::<f64>() + free.clone().map(moving).sum::<f64>(),
            mass: mass * simulation.particles().len() as f64 + free.map(|(_, mass)| mass).sum::<f64>(),
            fastest: speeds.into_iter().fold(0.0, f64::max),
        }
    }
}

/// What a scene shows that must not be; none if all is well.
pub fn faults(seed: u64) -> Vec<String> {
    let found = catch_unwind(AssertUnwindSafe(|| match Scene::new(seed) {
        Ok(scene) => (scene.words.clone(), run(scene)),
        Err(error) => (String::new(), vec![format!("it can't begin: {error}")]),
    }));
    match found {
        Ok((words, faults)) => faults.into_iter().map(|fault| format!("{seed}: {fault} ({words})")).collect(),
        Err(_) => vec![format!("{seed}: a panic")],
    }
}

fn run(mut scene: Scene) -> Vec<String> {
    let (mut faults, gravity) = (Vec::new(), scene.gravity);
    let first = Sums::of(&scene.simulation, gravity);
    let begun = scene.simulation.particles().len();
    let mut since_stray = RECENT;
    let (mut recent, mut lowest, mut count) = ([first.energy; RECENT], first.energy, begun);
    let [mut motion, mut worst_step, mut worst, mut lost, mut fastest] = [0.0_f64; 5];
    motion = motion.max(first.motion);
    for _ in 0..scene.steps {
        let report = match scene.simulation.step() {
            Ok(report) => report,
            Err(error) => {
                faults.push(format!("it ends: {error}"));
                break;
            }
        };
        count += report.emitted;
        let now = Sums::of(&scene.simulation, gravity);
        motion = motion.max(now.motion + now.mass * gravity.length() * report.dt);
        fastest = fastest.max(now.fastest);
        if report.removed > 0 || now.mass.is_nan() || scene.simulation.particles().len() != count {
            faults.push("particles are lost".into());
            break;
        }
        let highest = recent.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // What is found in a body is put out of it, against gravity too.
        let lifted = 2.0 * RP * scene.simulation.particle_mass() * gravity.length() * report.inside as f64;
        lowest = lowest.min(highest) + lifted;
        since_stray = if report.inside > 0 { 0 } else { since_stray + 1 };
        let allowed = if since_stray < RECENT { GROWTH_BY_STRAYS } else { 0.0 };
        worst_step = worst_step.max((now.energy - highest - lifted) / scene.energy - allowed);
        recent[scene.simulation.steps() as usize % RECENT] = now.energy;
        worst = worst.max((now.energy - lowest) / scene.energy);
        let expected = first.momentum + scene.simulation.time() * first.mass * gravity;
        lost = lost.max(now.momentum.distance(expected) / motion);
    }
    let growth = if scene.has_default_pressure { GROWTH } else { GROWTH_BY_OTHERS };
    let most = scene.most_speed();
    if !scene.is_driven && worst_step > growth[0] {
        faults.push(format!("energy grows by {:.3} % in a step", 100.0 * worst_step));
    }
    if !scene.is_driven && worst > growth[1] {
        faults.push(format!("energy grows by {:.3} % in all", 100.0 * worst));
    }
    let fall = if gravity == DVec3::ZERO { 0.0 } else { scene.steps as f64 };
    let rounding = ROUNDING * (fall + scene.stiffness);
    if !scene.has_ground && !scene.emits && lost > MOMENTUM + rounding {
        faults.push(format!("{lost:.1e} of the momentum are lost"));
    }
    if fastest.is_nan() || fastest > most {
        faults.push(format!("a particle has {fastest:.1} m/s, more than {most:.1}"));
    }
    faults
}
