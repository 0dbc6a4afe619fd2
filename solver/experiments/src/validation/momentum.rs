//! Two blobs of fluid and a body that float without gravity and collide: nothing outside gives or takes momentum.
//!
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 4.3: what a particle gets from a body,
//! the body gets from it, with the opposite sign.

use super::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::{Bodies, FreeBody, Motion, Weight};
use volmap_fluid::lattice::fill_box;
use volmap_fluid::observe::{kinetic_energy, momenta, velocities};
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{FluidSettings, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{Shape, baked, ball};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{DVec3, KernelKind};

/// Conservation without gravity.
pub const EXPERIMENT: Experiment = Experiment {
    name: "momentum",
    title: "two blobs of fluid and a free ball collide without gravity",
    about: "Momentum of fluid and ball together is conserved to rounding, and energy never grows",
    run,
};

const RADIUS: f64 = 0.025;
/// Radius of the ball, metres.
const BALL: f64 = 0.2;
/// Speed of the blobs, m/s.
const SPEED: f64 = 1.0;
/// Positions of the blobs at the start: beside the ball, and off its middle.
const AWAY: DVec3 = DVec3::new(0.55, 0.1, 0.05);

/// Momentum, angular momentum about the origin, and kinetic energy; of fluid and ball together, and of the ball.
pub(super) struct State {
    time: f64,
    momentum: DVec3,
    angular: DVec3,
    energy: f64,
    ball: DVec3,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    for (case, viscosity) in [("viscous", 0.01), ("inviscid", 0.0)].into_iter().take(run.pick(1, 2)) {
        (run.progress)(&format!("momentum: {case}"));
        let states = collide(run, &mut outcome, case, viscosity, (KernelKind::CubicSpline, 4.0))?;
        outcome.chart(format!("momentum_{case}.png"), picture(&states));
    }
    outcome.notes.push(
        "momentum is compared with the sum of the particles' m |v| at the start, angular momentum with that times 1 m"
            .into(),
    );
    Ok(outcome)
}

/// A collision with a viscosity (m^2/s), and a kernel of a support radius (rp).
pub(super) fn collide(
    run: &Run,
    outcome: &mut Outcome,
    case: &str,
    viscosity: f64,
    kernel: (KernelKind, f64),
) -> Result<Vec<State>, Error> {
    let shape = baked(ball(BALL, 4), kernel.1 * RADIUS, false)?;
    let mut simulation = simulation(&shape, viscosity, kernel)?;
    let speeds: f64 = velocities(&simulation).map(DVec3::length).sum();
    let scale = speeds * simulation.particle_mass();
    let mut states = vec![state(&simulation)];
    let [mut touched, mut inside] = [0, 0];
    run.until(&mut simulation, run.pick(0.6, 2.0), &mut |simulation, report| {
        states.push(state(simulation));
        touched = touched.max(report.near_bodies);
        inside += report.inside;
    })?;
    outcome
        .rows
        .push(Row::new(case, "particles that touch the ball, most", "", touched as f64).at_least(50.0));
    outcome.rows.push(Row::new(case, "particles found in the ball", "", inside as f64));
    outcome.rows.extend(rows(case, &states, scale));
    Ok(states)
}

fn simulation(
    shape: &Shape,
    viscosity: f64,
    (kernel, support): (KernelKind, f64),
) -> Result<Simulation, Error> {
    let world = World {
        particle_radius: RADIUS,
        support_radius: support * RADIUS,
        kernel,
        gravity: DVec3::ZERO,
        ..World::default()
    };
    let mut particles = Particles::default();
    for side in [-1.0, 1.0] {
        let centre = side * AWAY;
        let corners = [centre - 0.25, centre + 0.25];
        let inside = |x: &DVec3| x.distance(centre) < 0.25;
        let blob: Vec<DVec3> = fill_box(corners, 2.0 * RADIUS).filter(inside).collect();
        // The second is slower: the sum isn't zero.
        let speed = if side < 0.0 { SPEED } else { -0.6 * SPEED };
        particles.add(&blob, &vec![[speed as f32, 0.0, 0.0]; blob.len()]);
    }
    let free = FreeBody { weight: Weight::Density(500.0), ..FreeBody::default() };
    let bodies = Bodies::new(vec![shape.body("ball", DVec3::ZERO, Motion::Free(free))], world.gravity)?;
    Simulation::new(Setup {
        fluid: FluidSettings { viscosity, ..FluidSettings::default() },
        domain: Some([DVec3::splat(-20.0), DVec3::splat(20.0)]),
        ..Setup::new(world, particles, bodies)
    })
}

fn state(simulation: &Simulation) -> State {
    let [momentum, angular] = momenta(simulation);
    let body = simulation.bodies().totals();
    State {
        time: simulation.time(),
        momentum: momentum + body.momentum,
        angular: angular + body.angular_momentum,
        energy: kinetic_energy(simulation) + body.kinetic_energy,
        ball: body.momentum,
    }
}

fn rows(case: &str, states: &[State], scale: f64) -> Vec<Row> {
    let first = &states[0];
    let most = |value: &dyn Fn(&State) -> f64| states.iter().map(value).fold(0.0, f64::max);
    let momentum = most(&|state| (state.momentum - first.momentum).length()) / scale;
    let angular = most(&|state| (state.angular - first.angular).length()) / scale;
    let grown = states.windows(2).map(|pair| pair[1].energy - pair[0].energy).fold(0.0, f64::max);
    vec![
        Row::new(case, "momentum that the ball took, most", "", most(&|state| state.ball.length()) / scale)
            .at_least(0.01),
        Row::new(case, "momentum, largest error", "", momentum).at_most(1e-6),
        Row::new(case, "angular momentum, largest drift", "", angular),
        Row::new(case, "energy, most", "of the first", most(&|state| state.energy) / first.energy)
            .at_most(1.000_001),
        Row::new(case, "energy, largest growth in a step", "of the first", grown / first.energy)
            .at_most(1e-3),
        Row::new(case, "energy, at the end", "of the first", states[states.len() - 1].energy / first.energy),
    ]
}

fn picture(states: &[State]) -> volmap_figures::picture::Chart {
    let first = &states[0];
    let length = first.momentum.length();
    let of = |value: &dyn Fn(&State) -> f64| states.iter().map(|state| [state.time, value(state)]).collect();
    let series = vec![
        curve("momentum, all", DISTINCT[0], of(&|state| state.momentum.x / length)),
        curve("momentum, ball", DISTINCT[1], of(&|state| state.ball.x / length)),
        curve("kinetic energy, all", DISTINCT[2], of(&|state| state.energy / first.energy)),
    ];
    chart("Momentum and energy of two blobs and a ball", ["time", "s"], ["in parts of the first", ""], series)
}
