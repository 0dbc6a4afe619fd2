//! A puck slides and spins on a plane without friction: in place of the elastic cubes of Bender et al. 2020, *Implicit
//! Frictional Boundary Handling for SPH*, Figs. 8 and 9. A plane made of particles is bumpy: it brakes, turns and
//! shifts the puck; a map must not.

use super::boundaries::{BLUE_NOISE, DENSITY_MAP, Named, PAPER_MAP, PARTICLES, VOLUME_MAP};
use super::rigid::Rigid;
use crate::validation::flow::GRAVITY;
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use std::f64::consts::PI;
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::observe::{centre, momenta};
use volmap_fluid::settings::ViscosityMethod;
use volmap_fluid::shapes::{Shape, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{DQuat, DVec3};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "puck",
    title: "Puck without friction",
    about: "A rigid puck of particles spins on a plane and slides down a slope: loss of spin and speed, drift",
    run,
};

const RP: f64 = 0.025;
/// Radius of the puck, metres (nine particles across), and its number of layers.
const PUCK: f64 = 0.225;
const LAYERS: u32 = 4;
/// Angular velocity at the start, rad/s.
const SPIN: f64 = 5.1;
/// Angle of the slope.
const DEGREES: f64 = 20.0;
/// A puck that leaves the middle of the plane is put back by this, metres; and half the plane's width.
const PERIOD: f64 = 1.0;
const HALF: f64 = 1.0;
/// Viscosity of the puck as a fluid, m^2/s.
const THICK: f64 = 50.0;
/// Height of the lowest layer at the start, rp (on the paper's map it rests at more than 2), and the time in which the
/// puck comes to rest, seconds.
const START: f64 = 3.5;
const REST: f64 = 1.0;

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let [mut spins, mut ways, mut speeds] = [const { Vec::new() }; 3];
    let methods = run.pick(
        &[BLUE_NOISE, PARTICLES, VOLUME_MAP][..],
        &[BLUE_NOISE, PARTICLES, DENSITY_MAP, PAPER_MAP, VOLUME_MAP],
    );
    for (method, colour) in methods.iter().zip(DISTINCT) {
        let plane =
            method.baked(cuboid(DVec3::new(-HALF, -0.15, -HALF), DVec3::new(HALF, 0.0, HALF)), RP, false)?;
        (run.progress)(&format!("puck: {}, spins", method.name));
        let spin = spin(run, method, &plane)?;
        spin.spin_rows(&mut outcome, method);
        spins.push(curve(method.name, colour, spin.points(|at| [at.time, at.spin / SPIN])));
        ways.push(curve(method.name, colour, spin.points(|at| [at.place.x / PUCK, at.place.z / PUCK])));
        (run.progress)(&format!("puck: {}, slides", method.name));
        let slide = slide(run, method, &plane)?;
        slide.slide_rows(&mut outcome, method.name);
        let whole = GRAVITY * DEGREES.to_radians().sin();
        speeds.push(curve(method.name, colour, slide.points(|at| [at.time, at.speed / (whole * at.time)])));
        (run.progress)(&format!("puck: {}, thick fluid", method.name));
        fluid_rows(run, &mut outcome, method, &plane)?;
    }
    let axes = [["Time", "s"], ["Spin over that of the start", ""]];
    outcome.chart("puck-spin.png", chart("A puck that spins on a plane", axes[0], axes[1], spins));
    let axes = [["Drift", "puck radii"], ["Drift across", "puck radii"]];
    outcome.chart("puck-drift.png", chart("Where a spinning puck drifts", axes[0], axes[1], ways));
    let axes = [["Time", "s"], ["Speed over g sin(slope) t", ""]];
    outcome.chart("puck-slide.png", chart("A puck that slides down a slope", axes[0], axes[1], speeds));
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    The paper's cubes are elastic; the puck is rigid. Of what a step does to its particles it keeps momentum and \
    angular momentum, as an elastic body would, and it never deforms. It has four layers, nine particles across, of \
    rp = 25 mm, which came to rest for 1 s before. The plane is 2 m wide: a puck that leaves its middle is put back \
    by 1 m, on the same plane. As a fluid of 50 m^2/s it sinks by g dt per second, whatever the viscosity: pressures \
    act for a step before the viscous solve sees their effect. So it turns for 2 s only.";

/// State of the puck at a time; units are seconds, metres, m/s and rad/s.
#[derive(Clone, Copy)]
struct At {
    time: f64,
    place: DVec3,
    speed: f64,
    spin: f64,
    /// Angle between its axis and the vertical, degrees.
    tilt: f64,
}

struct Track {
    /// Height of the lowest layer at the start, metres.
    height: f64,
    all: Vec<At>,
    /// Particles found in the plane, summed over steps.
    inside: usize,
}

/// Spins on the level plane, with no force but gravity.
fn spin(run: &Run, method: &Named, plane: &Shape) -> Result<Track, Error> {
    let (mut rigid, mut simulation) = puck(run, method, plane, DVec3::NEG_Y * GRAVITY)?;
    rigid.angular_velocity = DVec3::Y * SPIN;
    track(run, &mut rigid, &mut simulation, run.pick(4.0, 100.0))
}

/// Slides down a slope. The plane is level and gravity is inclined.
fn slide(run: &Run, method: &Named, plane: &Shape) -> Result<Track, Error> {
    let tilted = DQuat::from_rotation_z(DEGREES.to_radians()) * DVec3::NEG_Y;
    let (mut rigid, mut simulation) = puck(run, method, plane, GRAVITY * tilted)?;
    rigid.velocity = DVec3::ZERO;
    rigid.angular_velocity = DVec3::ZERO;
    track(run, &mut rigid, &mut simulation, run.pick(1.0, 3.0))
}

/// The puck as a fluid so thick that it hardly sinks.
fn fluid_rows(run: &Run, outcome: &mut Outcome, method: &Named, plane: &Shape) -> Result<(), Error> {
    let (mut rigid, _) = puck(run, method, plane, DVec3::NEG_Y * GRAVITY)?;
    rigid.angular_velocity = DVec3::Y * SPIN;
    let mut setup = method.setup(RP, vec![plane.body("plane", DVec3::ZERO, Motion::Static)])?;
    setup.fluid.viscosity = THICK;
    setup.fluid.viscosity_method = ViscosityMethod::Implicit;
    let (places, velocities) = rigid.particles();
    setup.particles.add(&places, &velocities);
    let mut simulation = Simulation::new(setup)?;
    let about_centre = |simulation: &Simulation| {
        let ([momentum, angular], at) = (momenta(simulation), centre(simulation));
        (angular - at.cross(momentum)).y
    };
    let (before, start) = (about_centre(&simulation), centre(&simulation));
    let mut iterations = 0;
    run.until(&mut simulation, run.pick(1.0, 2.0), &mut |_, report| {
        iterations += report.viscosity.iterations
    })?;
    let case = format!("{}, thick fluid", method.name);
    let rows = &mut outcome.rows;
    let loss = 1.0 - about_centre(&simulation) / before;
    rows.push(Row::new(&case, "part of the angular momentum that was lost", "", loss));
    let drift = (centre(&simulation) - start).with_y(0.0).length() / PUCK;
    rows.push(Row::new(&case, "drift at the end", "puck radii", drift));
    let sunk = 1.0 - centre(&simulation).y / start.y;
    rows.push(Row::new(&case, "part of its height that was lost", "", sunk));
    let mean = f64::from(iterations) / simulation.steps() as f64;
    rows.push(Row::new(&case, "viscous iterations, mean of steps", "", mean));
    Ok(())
}

/// The puck's particles, higher above y = 0 than they rest with any method.
fn places() -> Vec<DVec3> {
    let side = (PUCK / RP) as i32;
    let across = |n: i32| 2.0 * RP * f64::from(n - side / 2);
    let layer = (0..side * side).map(|n| DVec3::new(across(n % side), 0.0, across(n / side)));
    let layer: Vec<DVec3> = layer.filter(|x| x.length() < PUCK).collect();
    let at = |y: u32| DVec3::Y * RP * (START + f64::from(2 * y));
    (0..LAYERS).flat_map(|y| layer.iter().map(move |&x| x + at(y))).collect()
}

/// A puck at rest on a plane. Until it rests, gravity acts across the plane only.
fn puck(run: &Run, method: &Named, plane: &Shape, gravity: DVec3) -> Result<(Rigid, Simulation), Error> {
    let mut rigid = Rigid::new(&places(), DVec3::ZERO, DVec3::ZERO);
    let mut setup = method.setup(RP, vec![plane.body("plane", DVec3::ZERO, Motion::Static)])?;
    setup.world.gravity = gravity;
    let (places, velocities) = rigid.particles();
    setup.particles.add(&places, &velocities);
    let mut simulation = Simulation::new(setup)?;
    while simulation.time() < REST {
        run.watch.check()?;
        rigid.step(&mut simulation)?;
        // It may move only up and down, and slowly.
        rigid.velocity = DVec3::Y * 0.9 * rigid.velocity.y;
        rigid.angular_velocity = DVec3::ZERO;
        rigid.centre = DVec3::Y * rigid.centre.y;
        rigid.place(&mut simulation);
    }
    Ok((rigid, simulation))
}

fn track(run: &Run, rigid: &mut Rigid, simulation: &mut Simulation, end: f64) -> Result<Track, Error> {
    let (start, mut travelled, mut inside) = (simulation.time(), DVec3::ZERO, 0);
    rigid.place(simulation);
    let begin = rigid.centre;
    let height = begin.y - f64::from(LAYERS - 1) * RP;
    let mut all = Vec::new();
    while simulation.time() < start + end - 1e-9 {
        run.watch.check()?;
        inside += rigid.step(simulation)?.inside;
        let back = PERIOD * (rigid.centre / PERIOD).round().with_y(0.0);
        if back != DVec3::ZERO {
            rigid.centre -= back;
            travelled += back;
            rigid.place(simulation);
        }
        let up = rigid.rotation * DVec3::Y;
        all.push(At {
            time: simulation.time() - start,
            place: rigid.centre + travelled - begin,
            speed: rigid.velocity.with_y(0.0).length(),
            spin: rigid.angular_velocity.y,
            tilt: up.y.clamp(-1.0, 1.0).acos() * 180.0 / PI,
        });
    }
    Ok(Track { height, all, inside })
}

impl Track {
    /// Thins a curve to some hundred points.
    fn points(&self, pick: impl Fn(&At) -> [f64; 2]) -> Vec<[f64; 2]> {
        self.all.iter().step_by(self.all.len() / 500 + 1).map(pick).collect()
    }

    fn most(&self, of: impl Fn(&At) -> f64) -> f64 {
        self.all.iter().map(of).fold(0.0, f64::max)
    }

    fn spin_rows(&self, outcome: &mut Outcome, method: &Named) {
        let Some(last) = self.all.last() else { return };
        let case = format!("{}, spins", method.name);
        let loss = Row::new(&case, "part of the spin that was lost", "", 1.0 - last.spin / SPIN);
        let rows = &mut outcome.rows;
        rows.push(match method.name {
            name if name == BLUE_NOISE.name => loss.paper(0.9),
            name if name == PARTICLES.name => loss,
            name if name == DENSITY_MAP.name => loss,
            _ => loss.paper(0.01).between(-0.01, 0.01),
        });
        let drift = |at: &At| at.place.with_y(0.0).length() / PUCK;
        rows.push(Row::new(&case, "drift at the end", "puck radii", drift(last)));
        rows.push(Row::new(&case, "farthest drift", "puck radii", self.most(drift)));
        self.rest_rows(outcome, &case);
    }

    fn slide_rows(&self, outcome: &mut Outcome, name: &str) {
        let Some(last) = self.all.last() else { return };
        let case = format!("{name}, slides");
        let rows = &mut outcome.rows;
        let ideal = GRAVITY * DEGREES.to_radians().sin() * last.time;
        rows.push(Row::new(&case, "speed over g sin(slope) t", "", last.speed / ideal));
        let aside = last.place.z.abs() / last.place.x.abs();
        rows.push(Row::new(&case, "to the side, over the way", "", aside));
        rows.push(Row::new(&case, "angular velocity that it got", "rad/s", last.spin.abs()));
        self.rest_rows(outcome, &case);
    }

    fn rest_rows(&self, outcome: &mut Outcome, case: &str) {
        let rows = &mut outcome.rows;
        rows.push(Row::new(case, "lowest layer over the plane", "rp", self.height / RP));
        rows.push(Row::new(case, "largest tilt", "degrees", self.most(|at| at.tilt)));
        rows.push(Row::new(case, "largest jump", "rp", self.most(|at| at.place.y) / RP));
        rows.push(Row::new(
            case,
            "particles in the plane, mean of steps",
            "",
            self.inside as f64 / self.all.len() as f64,
        ));
    }
}
