//! The largest stable step in a drum that turns fast: Band et al. 2018, section 5.5.

use super::methods::{CLEARANCE, Method, Scenery, fixed_step, largest_step, survives};
use super::prism::{drum, prism};
use crate::validation::flow::{GRAVITY, lattice};
use crate::validation::{Experiment, Outcome, Row, Run, chart};
use std::f64::consts::PI;
use volmap_figures::picture::colours::DISTINCT;
use volmap_figures::picture::{Data, Series};
use volmap_fluid::Error;
use volmap_fluid::bodies::{Motion, Path, Spin};
use volmap_fluid::observe::rms_speed;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, SolverSettings};
use volmap_fluid::shapes::Shape;
use volmap_runtime::{ClosureKind, DVec3};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "washing",
    title: "Washing drum, Band 5.5",
    about: "Water in a drum that turns at 45 rpm: the largest fixed step at which nothing explodes or leaks",
    run,
};

/// Inner radius and half of the length of the drum, metres.
const RADIUS: f64 = 0.4;
const HALF_LENGTH: f64 = 0.15;
/// Its paddles: how many, how high and how thick, metres.
const PADDLES: u32 = 3;
const PADDLE_HEIGHT: f64 = 0.12;
const PADDLE_WIDTH: f64 = 0.06;
/// Turns per minute.
const SPEED: f64 = 45.0;
/// Steps that are tried, in ratios of 2^(1/4), seconds.
const FIRST_STEP: f64 = 0.002;
const STEPS: i32 = 20;

fn methods() -> Vec<Method> {
    use BoundaryPressure::{Mirror, Mls, Own, Sph};
    let particles = [Mirror, Sph, Mls, Own].map(|pressure| Method::of(BoundaryMethod::Particles, pressure));
    let mirror = [Own, Mirror, Mls].map(|pressure| Method::maps(ClosureKind::Mirror, pressure));
    let calibrated = [Own, Mls].map(|pressure| Method::maps(ClosureKind::Calibrated, pressure));
    particles.into_iter().chain(mirror).chain(calibrated).collect()
}

/// Results of a run with one length of the steps.
#[derive(Clone, Copy, Debug, Default)]
struct Wash {
    /// Largest root of the mean square of the speeds, m/s.
    rms: f64,
    /// Largest speed of all, m/s.
    fastest: f64,
    /// Part of centres in the drum's wall, over all particles and steps.
    inside: f64,
    /// Particles that are lost at the end, or deeper in the wall than rp.
    leaked: usize,
    stopped: Option<f64>,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let radius = run.pick(0.03, 0.02);
    let (mut mirroring, mut curves) = (f64::NAN, Vec::new());
    for (n, method) in methods().into_iter().enumerate() {
        if run.short && !(n == 0 || n == 2 || n == 4) {
            continue;
        }
        (run.progress)(&format!("washing: {}", method.name()));
        let section = drum(RADIUS, PADDLES, PADDLE_HEIGHT, PADDLE_WIDTH);
        let shape = method.shape(prism(&section, HALF_LENGTH), radius, true)?;
        let first = run.pick(4.0 * FIRST_STEP, FIRST_STEP);
        let (mut last, mut points) = (Wash::default(), Vec::new());
        let steps = (0..STEPS).map(|n| first * 2_f64.powf(0.25 * f64::from(n)));
        let largest = largest_step(steps, |dt| {
            last = wash(run, &method, &shape, radius, dt)?;
            points.push([1e3 * dt, last.fastest]);
            Ok(last.is_stable())
        })?;
        if n == 0 {
            mirroring = largest;
        }
        outcome.rows.extend(rows(&method, largest, mirroring, last));
        let data = if n < DISTINCT.len() { Data::Curve(points) } else { Data::Dashes(points) };
        curves.push(Series { name: method.name(), colour: DISTINCT[n % DISTINCT.len()], data });
    }
    let mut chart = chart("Largest speed by step", ["Step", "ms"], ["Largest speed", "m/s"], curves);
    chart.x.log = true;
    chart.y.log = true;
    outcome.chart("washing-speed.png", chart);
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    Scaled: a drum of 0.8 m x 0.3 m without holes and without spheres, spacing 4 cm, a third full, 45 rpm (the \
    wall's acceleration is 0.9 g), 2 s. A step is stable if the run ends, no particle is lost or deeper than rp in \
    the wall at its end, less than 1 % of centres are in the wall, and no speed is larger than twice the sum of the \
    wall's speed and that of a fall through the drum. The paper's factor of two is of an adaptive step.";

impl Wash {
    fn is_stable(&self) -> bool {
        let allowed = 2.0 * ((4.0 * GRAVITY * RADIUS).sqrt() + wall_speed());
        self.stopped.is_none() && self.leaked == 0 && self.inside < 0.01 && self.fastest < allowed
    }
}

fn wall_speed() -> f64 {
    SPEED * PI / 30.0 * RADIUS
}

/// A run of particles of a radius (metres) in steps of `dt` (seconds).
fn wash(run: &Run, method: &Method, shape: &Shape, radius: f64, dt: f64) -> Result<Wash, Error> {
    let spin = Spin { axis: DVec3::Z, centre: DVec3::ZERO, speed: SPEED * PI / 30.0 };
    let half = DVec3::new(RADIUS, RADIUS, HALF_LENGTH);
    let mut places = lattice(-half, half, radius);
    let clear = |x: &DVec3| x.y < -0.1 && shape.map.values(*x).distance > CLEARANCE * radius;
    places.retain(clear);
    let mut simulation = method.simulation(&Scenery {
        radius,
        places,
        bodies: vec![shape.body("drum", DVec3::ZERO, Motion::Prescribed(Path::Spin(spin)))],
        solver: fixed_step(SolverSettings::default(), dt),
        ..Scenery::default()
    })?;
    let count = simulation.particles().len();
    let (mut wash, mut steps) = (Wash::default(), 0.0);
    wash.stopped = survives(run, &mut simulation, run.pick(1.0, 2.0), &mut |simulation, report| {
        wash.rms = wash.rms.max(rms_speed(simulation));
        wash.fastest = wash.fastest.max(report.max_speed);
        wash.inside += report.inside as f64;
        steps += 1.0;
    })?;
    wash.inside /= steps * count as f64;
    let drum = &simulation.bodies().posed()[0];
    let deep = |x: &&DVec3| drum.map.values(drum.pose.to_map(**x)).distance < -radius;
    let positions = &simulation.particles().positions;
    wash.leaked = count - positions.len() + positions.iter().filter(deep).count();
    Ok(wash)
}

fn rows(method: &Method, largest: f64, mirroring: f64, next: Wash) -> Vec<Row> {
    let case = method.name();
    let told = |quantity: &str, unit, value| Row::new(&case, quantity, unit, value);
    let over = told("over mirroring's on particles", "", largest / mirroring);
    let is_mls = method.boundary == BoundaryMethod::Particles && method.pressure == BoundaryPressure::Mls;
    let mut rows = vec![
        told("largest stable step", "ms", 1e3 * largest),
        if is_mls { over.paper(2.0) } else { over },
        told("next: largest speed", "m/s", next.fastest),
        told("next: centres in the wall", "%", 100.0 * next.inside),
        told("next: lost or deep in the wall", "", next.leaked as f64),
    ];
    if let Some(time) = next.stopped {
        rows.push(told("next: stopped at", "s", time));
    }
    rows
}
