//! Water in a ball that spins: Band et al. 2018, *MLS Pressure Boundaries for Divergence-Free and Viscous SPH Fluids*,
//! Fig. 4. A wall without friction that moves along itself must not move the water.

use super::flow::{GRAVITY, lattice, water};
use super::{Experiment, Outcome, Row, Run, chart, curve};
use std::f64::consts::PI;
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::{Motion, Path, Spin};
use volmap_fluid::observe::{momenta, rms_speed};
use volmap_fluid::shapes::{Shape, baked_adaptively, ball};
use volmap_runtime::{ClosureKind, DVec3};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "sphere",
    title: "Spinning ball",
    about: "A hollow ball half full of water spins at 7 rpm; without friction the water must stay at rest",
    run,
};

/// Radius of the ball, metres.
const RADIUS: f64 = 0.5;
/// Speed of the ball, rpm.
const SPEED: f64 = 7.0;

/// Means over the last half of a run.
#[derive(Clone, Copy, Default)]
struct Calm {
    rms: f64,
    /// Kinetic energy over the potential energy m g R.
    energy: f64,
    /// Angular momentum about the axis, over that of water that turns with the ball.
    carried: f64,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let radius = run.pick(0.025, 0.0125);
    // Cells as in scenes for bodies that turn.
    let hollow = baked_adaptively(ClosureKind::Mirror, ball(RADIUS, 6), 4.0 * radius, true)?;
    let level = Spin { axis: DVec3::X, centre: DVec3::ZERO, speed: SPEED * PI / 30.0 };
    let spins = [
        ("at rest", None),
        ("level axis", Some(level)),
        ("upright axis", Some(Spin { axis: DVec3::Y, ..level })),
    ];
    let mut curves = Vec::new();
    let mut rest = Calm::default();
    for ((case, spin), colour) in spins.into_iter().zip(DISTINCT) {
        (run.progress)(&format!("sphere: {case}"));
        let (calm, points) = spinning(run, &hollow, radius, spin)?;
        let rows = &mut outcome.rows;
        rows.push(Row::new(case, "rms speed", "m/s", calm.rms));
        rows.push(Row::new(case, "kinetic energy over m g R", "", calm.energy));
        if let Some(spin) = spin {
            let wall = spin.speed * RADIUS;
            let more = (calm.rms - rest.rms) / wall;
            rows.push(Row::new(case, "rms speed more than at rest, over the wall's", "", more).at_most(0.02));
            rows.push(
                Row::new(case, "part of the spin that the water took", "", calm.carried).between(-0.02, 0.02),
            );
        } else {
            rest = calm;
        }
        curves.push(curve(case, colour, points));
    }
    let axes = [["Time", "s"], ["Root mean square of the speed", "m/s"]];
    outcome.chart("sphere.png", chart("Water in a spinning ball", axes[0], axes[1], curves));
    Ok(outcome)
}

/// Rms speed over time, and the means.
fn spinning(
    run: &Run,
    hollow: &Shape,
    radius: f64,
    spin: Option<Spin>,
) -> Result<(Calm, Vec<[f64; 2]>), Error> {
    let motion = spin.map_or(Motion::Static, |spin| Motion::Prescribed(Path::Spin(spin)));
    let places = lattice(DVec3::splat(-RADIUS), DVec3::new(RADIUS, 0.0, RADIUS), radius);
    let places: Vec<DVec3> = places.into_iter().filter(|x| x.length() < RADIUS - 0.9 * radius).collect();
    let mut simulation = water(radius, &places, 0.001, vec![hollow.body("ball", DVec3::ZERO, motion)])?;
    let (mut points, mut sum, mut time) = (Vec::new(), Calm::default(), 0.0);
    let end = run.pick(1.0, 4.0);
    let axis = spin.map_or(DVec3::Y, |spin| spin.axis);
    run.until(&mut simulation, end, &mut |simulation, report| {
        let rms = rms_speed(simulation);
        points.push([simulation.time(), rms]);
        if simulation.time() > 0.5 * end {
            let positions = &simulation.particles().positions;
            let inertia: f64 = positions.iter().map(|x| x.reject_from(axis).length_squared()).sum();
            let whole = SPEED * PI / 30.0 * inertia * simulation.particle_mass();
            sum.rms += report.dt * rms;
            sum.energy += report.dt * 0.5 * rms * rms / (GRAVITY * RADIUS);
            sum.carried += report.dt * momenta(simulation)[1].dot(axis) / whole;
            time += report.dt;
        }
    })?;
    let mean = Calm { rms: sum.rms / time, energy: sum.energy / time, carried: sum.carried / time };
    Ok((mean, points))
}
