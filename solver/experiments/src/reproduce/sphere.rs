//! Water in a ball that turns: Band et al. 2018, Fig. 4. Boundaries without friction must not move it; where unsuitable
//! pressures do, that is artificial viscosity.

use super::methods::{CLEARANCE, Method, Scenery, fixed_step, survives};
use crate::validation::flow::lattice;
use crate::validation::{Experiment, Outcome, Row, Run, chart};
use std::f64::consts::PI;
use volmap_figures::picture::colours::DISTINCT;
use volmap_figures::picture::{Data, Series};
use volmap_fluid::Error;
use volmap_fluid::bodies::{Motion, Path, Spin};
use volmap_fluid::observe::{kinetic_energy, momenta, rms_speed};
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, FluidSettings, SolverSettings};
use volmap_fluid::shapes::{Shape, ball};
use volmap_runtime::{ClosureKind, DVec3};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "sphere",
    title: "Rotating sphere, Band Fig. 4",
    about: "A hollow ball half full of water turns about a level axis; the water should rest (scaled: 0.5 m for 3 m)",
    run,
};

/// Radius of the ball, metres; the paper's is 3.
const RADIUS: f64 = 0.5;
/// Speed of the ball, rpm. It makes as many turns as the paper's 7 rpm in the time of a fall through the ball.
const SPEED: f64 = 7.0 * 2.449;
/// The paper's steps, seconds.
const STEP: f64 = 0.001;

/// The paper's three methods, two of them on blue noise as well, and ours.
const METHODS: [Method; 9] = [
    Method::blue_noise(BoundaryPressure::Mirror),
    Method::blue_noise(BoundaryPressure::Mls),
    Method::of(BoundaryMethod::Particles, BoundaryPressure::Mirror),
    Method::of(BoundaryMethod::Particles, BoundaryPressure::Sph),
    Method::of(BoundaryMethod::Particles, BoundaryPressure::Mls),
    Method::of(BoundaryMethod::Particles, BoundaryPressure::Own),
    Method::maps(ClosureKind::Mirror, BoundaryPressure::Own),
    Method::maps(ClosureKind::Mirror, BoundaryPressure::Mls),
    Method::maps(ClosureKind::Calibrated, BoundaryPressure::Own),
];

/// Which of [`METHODS`] a short run has.
const SHORT: [usize; 3] = [1, 4, 6];

/// Means over the last half of a run.
#[derive(Clone, Copy, Default)]
struct Calm {
    /// Root of the mean square of the speeds, over the wall's.
    speed: f64,
    /// Kinetic energy, relative to water that turns with the ball.
    energy: f64,
    /// Angular momentum about the axis, relative to the same water.
    carried: f64,
    /// Mean time of a step, seconds.
    time: f64,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let radius = run.pick(0.05, 0.025);
    let mut curves = Vec::new();
    for (n, method) in METHODS.into_iter().enumerate() {
        if run.short && !SHORT.contains(&n) {
            continue;
        }
        (run.progress)(&format!("sphere: {}", method.name()));
        let hollow = method.shape(ball(RADIUS, 6), radius, true)?;
        let (still, _) = turn(run, &method, &hollow, radius, 0.0)?;
        let (turning, points) = turn(run, &method, &hollow, radius, SPEED)?;
        outcome.rows.extend(rows(&method, still, turning));
        let (name, colour) = (method.name(), DISTINCT[n % DISTINCT.len()]);
        let data = if n < 6 { Data::Dashes(points) } else { Data::Curve(points) };
        curves.push(Series { name, colour, data });
    }
    let mut chart = chart("Water in a turning ball", ["Time", "s"], ["Kinetic energy", "J"], curves);
    chart.y.log = true;
    outcome.chart("sphere-energy.png", chart);
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    Scaled: the ball's radius is 0.5 m instead of 3 m, 17.1 rpm instead of 7 (the same wall speed over sqrt(g R)), 3 \
    s for 10 s. The spacing of 5 cm, steps of 1 ms and ten iterations without a divergence solve are the paper's. \
    The paper shows speeds in colours and gives no figures.";

/// Means, and kinetic energy over time, of water in the ball. The particles' radius is in metres, the ball's speed in
/// rpm, the end in seconds.
fn turn(
    run: &Run,
    method: &Method,
    hollow: &Shape,
    radius: f64,
    speed: f64,
) -> Result<(Calm, Vec<[f64; 2]>), Error> {
    let spin = Spin { axis: DVec3::X, centre: DVec3::ZERO, speed: speed * PI / 30.0 };
    let motion = if speed == 0.0 { Motion::Static } else { Motion::Prescribed(Path::Spin(spin)) };
    let mut places = lattice(DVec3::splat(-RADIUS), DVec3::new(RADIUS, 0.0, RADIUS), radius);
    places.retain(|x| x.length() < RADIUS - CLEARANCE * radius);
    let mut simulation = method.simulation(&Scenery {
        radius,
        places,
        bodies: vec![hollow.body("ball", DVec3::ZERO, motion)],
        fluid: FluidSettings { viscosity: 0.001, ..FluidSettings::default() },
        solver: ten_iterations(),
    })?;
    let (mut points, mut sum, mut steps) = (Vec::new(), Calm::default(), 0.0);
    let turned = SPEED * PI / 30.0;
    let end = run.pick(1.0, 3.0);
    let stopped = survives(run, &mut simulation, end, &mut |simulation, report| {
        points.push([simulation.time(), kinetic_energy(simulation)]);
        if simulation.time() > 0.5 * end {
            let positions = &simulation.particles().positions;
            let squares: f64 = positions.iter().map(|x| x.reject_from(DVec3::X).length_squared()).sum();
            let inertia = squares * simulation.particle_mass();
            sum.speed += rms_speed(simulation).powi(2);
            sum.energy += kinetic_energy(simulation) / (0.5 * inertia * turned * turned);
            sum.carried += momenta(simulation)[1].x / (inertia * turned);
            sum.time += report.stages.total().as_secs_f64();
            steps += 1.0;
        }
    })?;
    let scale = if stopped.is_some() { f64::NAN } else { 1.0 / steps };
    let mean = Calm {
        speed: (sum.speed * scale).sqrt() / (turned * RADIUS),
        energy: sum.energy * scale,
        carried: sum.carried * scale,
        time: sum.time * scale,
    };
    Ok((mean, points))
}

/// The paper's solver: ten iterations from zero, and no divergence solve.
fn ten_iterations() -> SolverSettings {
    let mut solver = fixed_step(SolverSettings::default(), STEP);
    solver.density.min_iterations = 10;
    solver.density.max_iterations = 10;
    solver.divergence.enabled = false;
    solver.warm_start = 0.0;
    solver
}

fn rows(method: &Method, still: Calm, turning: Calm) -> Vec<Row> {
    let case = method.name();
    let told = |quantity: &str, unit, value| Row::new(&case, quantity, unit, value);
    let percent = |part: f64| 100.0 * part;
    vec![
        told("kinetic energy, of water that turns with the ball", "%", percent(turning.energy)),
        told("kinetic energy in a ball at rest", "%", percent(still.energy)),
        told("kinetic energy that turning adds", "%", percent(turning.energy - still.energy)),
        told("rms speed over the wall's", "%", percent(turning.speed)),
        told("rms speed in a ball at rest", "%", percent(still.speed)),
        told("angular momentum, of water that turns", "%", percent(turning.carried)),
        told("time of a step", "ms", 1e3 * turning.time),
    ]
}
