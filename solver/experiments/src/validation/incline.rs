//! Single particles slide down a plane: Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, Fig. 7. On
//! boundaries made of particles they are bumped to the sides; on a smooth one they go straight, with g sin(slope).

use super::flow::{GRAVITY, water};
use super::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::{BodyDescription, Motion};
use volmap_fluid::shapes::{Shape, baked, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{DQuat, DVec3, Pose};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "incline",
    title: "Inclined plane",
    about: "Single particles dropped on a turned box slide straight down, as fast as g sin(slope) says",
    run,
};

/// Particle radius, metres.
pub const RP: f64 = 0.025;
/// Particles along each side of the grid that is dropped.
const SIDE: i32 = 8;

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let plane = baked(cuboid(DVec3::new(-3.5, -0.3, -1.5), DVec3::new(3.5, 0.0, 1.5)), 4.0 * RP, false)?;
    let mut curves = Vec::new();
    for (&degrees, colour) in run.pick(&[30.0][..], &[15.0, 30.0, 45.0]).iter().zip(DISTINCT) {
        (run.progress)(&format!("incline: {degrees} degrees"));
        let points = slide(run, &mut outcome, &plane, degrees)?;
        curves.push(curve(format!("{degrees} degrees"), colour, points));
    }
    let axes = [["Time", "s"], ["Mean way down over g sin(slope) t^2 / 2", ""]];
    outcome.chart("incline.png", chart("Particles on a slope", axes[0], axes[1], curves));
    Ok(outcome)
}

/// The plane as a body, and its own axes in the world: up the slope, out of it, along it.
pub fn turned(plane: &Shape, degrees: f64) -> (BodyDescription, DQuat) {
    // About an axis that is none of the map's axes.
    let rotation = DQuat::from_rotation_y(0.3) * DQuat::from_rotation_z(f64::to_radians(degrees));
    let body = BodyDescription {
        pose: Pose { rotation, ..Pose::default() },
        ..plane.body("plane", DVec3::ZERO, Motion::Static)
    };
    (body, rotation)
}

/// Positions at the start in the plane's axes, around `up` metres on the slope. They are farther apart than their
/// support radius, so that each particle is alone, and in steps that meet all parts of a cell.
pub fn starts(up: f64) -> Vec<DVec3> {
    let (step, half) = (4.3 * RP, SIDE / 2);
    let at = |n: i32| DVec3::new(f64::from(n % SIDE - half), 0.0, f64::from(n / SIDE - half));
    (0..SIDE * SIDE).map(|n| DVec3::new(up, 1.2 * RP, 0.0) + step * at(n)).collect()
}

fn slide(run: &Run, outcome: &mut Outcome, plane: &Shape, degrees: f64) -> Result<Vec<[f64; 2]>, Error> {
    let (body, rotation) = turned(plane, degrees);
    let starts = starts(2.0);
    let places: Vec<DVec3> = starts.iter().map(|&x| rotation * x).collect();
    let mut simulation = water(RP, &places, 0.0, vec![body])?;
    let acceleration = GRAVITY * degrees.to_radians().sin();
    let end = (2.0f64 * 3.0 / acceleration).sqrt();
    let (mut points, mut highest, mut lowest) = (Vec::new(), 0.0f64, f64::INFINITY);
    let mut late = Vec::new();
    run.until(&mut simulation, end, &mut |simulation, _| {
        let time = simulation.time();
        let ways = ways(simulation, rotation, &starts);
        let down = -ways.iter().map(|slid| slid.way.x).sum::<f64>() / ways.len() as f64;
        points.push([time, down / (0.5 * acceleration * time * time)]);
        for Slid { height, .. } in &ways {
            lowest = lowest.min(*height);
            if time > 0.3 * end {
                highest = highest.max(*height);
            }
        }
        late = ways;
    })?;
    rows(outcome, degrees, &late, acceleration * simulation.time().powi(2) / 2.0);
    let case = format!("{degrees} degrees");
    outcome
        .rows
        .push(Row::new(&case, "greatest height after 30 % of the time", "rp", highest / RP).at_most(1.5));
    outcome.rows.push(Row::new(&case, "least height", "rp", lowest / RP).at_least(0.0));
    Ok(points)
}

/// A particle in the plane's axes, metres.
struct Slid {
    /// From its start.
    way: DVec3,
    height: f64,
}

fn ways(simulation: &Simulation, rotation: DQuat, starts: &[DVec3]) -> Vec<Slid> {
    let particles = simulation.particles();
    let own = particles.positions.iter().map(|&x| rotation.conjugate() * x);
    own.zip(&particles.ids).map(|(x, &id)| Slid { way: x - starts[id as usize], height: x.y }).collect()
}

fn rows(outcome: &mut Outcome, degrees: f64, ways: &[Slid], ideal: f64) {
    let case = format!("{degrees} degrees");
    let count = ways.len() as f64;
    let mean = -ways.iter().map(|slid| slid.way.x).sum::<f64>() / count;
    let spread = (ways.iter().map(|slid| (slid.way.x + mean).powi(2)).sum::<f64>() / count).sqrt();
    let aside = ways.iter().map(|slid| slid.way.z.abs()).fold(0.0, f64::max);
    let rows = &mut outcome.rows;
    rows.push(Row::new(&case, "way down over g sin(slope) t^2 / 2", "", mean / ideal).between(0.99, 1.01));
    rows.push(Row::new(&case, "spread of the ways down, over the way", "", spread / mean).at_most(0.01));
    rows.push(Row::new(&case, "farthest to the side, over the way", "", aside / mean).at_most(0.01));
}
