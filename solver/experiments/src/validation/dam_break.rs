//! A column of water collapses: Martin and Moyce 1952, *An Experimental Study of the Collapse of Liquid Columns on a
//! Rigid Horizontal Plane*, Phil. Trans. R. Soc. A 244, 312-324; columns of width a and height n^2 a.

use super::flow::{GRAVITY, lattice, water};
use super::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_figures::picture::colours::DISTINCT;
use volmap_figures::picture::{Data, Series};
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::observe::percentile;
use volmap_fluid::shapes::{baked, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "dam_break",
    title: "Dam break",
    about: "Front and height of a collapsing column against the measurements of Martin and Moyce 1952",
    run,
};

/// Width a of the column: 2.25 inches, metres.
const WIDTH: f64 = 0.05715;
/// n^2, the ratio of height to width.
const ASPECT: f64 = 2.0;

/// Table 2, n^2 = 2, a = 2.25 inches: T = t n sqrt(g / a), Z = z / a, z the position of the front.
const FRONT: [[f64; 2]; 15] = [
    [0.41, 1.11],
    [0.84, 1.22],
    [1.19, 1.44],
    [1.43, 1.67],
    [1.63, 1.89],
    [1.83, 2.11],
    [1.98, 2.33],
    [2.20, 2.56],
    [2.32, 2.78],
    [2.51, 3.00],
    [2.65, 3.22],
    [2.83, 3.44],
    [2.98, 3.67],
    [3.11, 3.89],
    [3.33, 4.11],
];

/// Table 6, the same column: tau = t sqrt(g / a), H = height at the wall / (n^2 a).
const HEIGHT: [[f64; 2]; 15] = [
    [0.56, 0.94],
    [0.77, 0.89],
    [0.93, 0.83],
    [1.08, 0.78],
    [1.28, 0.72],
    [1.46, 0.67],
    [1.66, 0.61],
    [1.84, 0.56],
    [2.00, 0.50],
    [2.21, 0.44],
    [2.45, 0.39],
    [2.70, 0.33],
    [3.06, 0.28],
    [3.44, 0.22],
    [4.20, 0.17],
];

/// Percentile of the particles' positions that counts as the front, so that splashes don't.
const FRONT_PART: f64 = 0.995;

/// Measured curves, in the units of the tables.
#[derive(Default)]
struct Measured {
    front: Vec<[f64; 2]>,
    height: Vec<[f64; 2]>,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let mut charts =
        [vec![dots("Martin and Moyce 1952", &FRONT)], vec![dots("Martin and Moyce 1952", &HEIGHT)]];
    // The short form is too coarse for the targets of the long one, and has its own.
    for (&across, colour) in run.pick(&[12][..], &[20, 40]).iter().zip(&DISTINCT[1..]) {
        (run.progress)(&format!("dam_break: {across} particles across the column"));
        let case = format!("a = {across} particles");
        let measured = collapse(run, across)?;
        let front = deviations(&measured.front, &FRONT);
        let height = deviations(&measured.height, &HEIGHT);
        let rows = &mut outcome.rows;
        rows.push(Row::new(&case, "front, rms deviation", "a", front.rms).at_most(run.pick(0.25, 0.2)));
        rows.push(
            Row::new(&case, "front, largest deviation", "a", front.largest).at_most(run.pick(0.42, 0.35)),
        );
        rows.push(Row::new(&case, "front, mean deviation", "a", front.mean));
        rows.push(Row::new(&case, "front, rms after the gate's delay", "a", front.rms_shifted).at_most(0.1));
        rows.push(Row::new(&case, "the gate's delay", "sqrt(a / g) / n", front.shift));
        rows.push(
            Row::new(&case, "height, rms deviation", "n^2 a", height.rms).at_most(run.pick(0.07, 0.05)),
        );
        rows.push(
            Row::new(&case, "height, largest deviation", "n^2 a", height.largest)
                .at_most(run.pick(0.12, 0.08)),
        );
        charts[0].push(curve(&case, *colour, measured.front));
        charts[1].push(curve(&case, *colour, measured.height));
    }
    let [front, height] = charts;
    let axes = (["t n sqrt(g / a)", ""], ["Front / a", ""]);
    outcome.chart("dam_break-front.png", chart("Front of a dam break", axes.0, axes.1, front));
    let axes = (["t sqrt(g / a)", ""], ["Height at the wall / (n^2 a)", ""]);
    outcome.chart("dam_break-height.png", chart("Height of a dam break", axes.0, axes.1, height));
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    The front is the position that 99.5 % of the particles haven't reached, plus a particle radius. The height is \
    the 98th percentile in the layer of 2 spacings at the wall, plus a radius. In the measurement a paper gate, \
    which was burnt away, held the column; here it comes to rest in a box and is free at once. The delay is the \
    shift of time that fits best.";

/// Inviscid water; the column is as deep as ten particles, between walls.
fn collapse(run: &Run, across: u32) -> Result<Measured, Error> {
    let radius = 0.5 * WIDTH / f64::from(across);
    let depth = 10.0 * 2.0 * radius;
    let tank = |width: f64| {
        let mesh = cuboid(DVec3::ZERO, DVec3::new(width, 1.4 * ASPECT * WIDTH, depth));
        Ok::<_, Error>(baked(mesh, 4.0 * radius, true)?.body("tank", DVec3::ZERO, Motion::Static))
    };
    let places = lattice(DVec3::ZERO, DVec3::new(WIDTH, ASPECT * WIDTH, depth), radius);
    // The lattice isn't quite at rest where walls meet.
    let mut column = water(radius, &places, 0.01, vec![tank(WIDTH)?])?;
    run.until(&mut column, 6.0 * (WIDTH / GRAVITY).sqrt(), &mut |_, _| ())?;
    let mut simulation = water(radius, &column.particles().positions, 0.0, vec![tank(5.5 * WIDTH)?])?;
    let unit = (WIDTH / GRAVITY).sqrt();
    let mut measured = Measured { front: vec![[0.0, 1.0]], height: vec![[0.0, 1.0]] };
    run.until(&mut simulation, run.pick(3.4, 4.3) * unit, &mut |simulation, _| {
        let time = simulation.time() / unit;
        let front = percentile(&along(simulation, |x| Some(x.x)), FRONT_PART) + radius;
        let at_wall = along(simulation, |x| (x.x < 4.0 * radius).then_some(x.y));
        measured.front.push([time * ASPECT.sqrt(), front / WIDTH]);
        measured.height.push([time, (percentile(&at_wall, 0.98) + radius) / (ASPECT * WIDTH)]);
    })?;
    Ok(measured)
}

fn along(simulation: &Simulation, pick: impl Fn(&DVec3) -> Option<f64>) -> Vec<f64> {
    simulation.particles().positions.iter().filter_map(pick).collect()
}

/// Deviations of a curve from points.
struct Deviations {
    mean: f64,
    rms: f64,
    largest: f64,
    /// Shift of the curve's times with which it fits best.
    shift: f64,
    rms_shifted: f64,
}

fn deviations(curve: &[[f64; 2]], points: &[[f64; 2]]) -> Deviations {
    let end = curve.last().map_or(0.0, |point| point[0]);
    let all = |shift: f64| {
        let known = points.iter().filter(move |[time, _]| *time <= end);
        known.map(move |[time, value]| at(curve, time - shift) - value).collect::<Vec<f64>>()
    };
    let rms = |all: &[f64]| (all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64).sqrt();
    let shifts = (0..=50).map(|n| 0.01 * f64::from(n));
    let (shift, rms_shifted) = shifts
        .map(|shift| (shift, rms(&all(shift))))
        .fold((0.0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
    let all = all(0.0);
    Deviations {
        mean: all.iter().sum::<f64>() / all.len() as f64,
        rms: rms(&all),
        largest: all.iter().fold(0.0, |largest, d| d.abs().max(largest)),
        shift,
        rms_shifted,
    }
}

/// A curve's value at a time; beyond an end, that of the end.
fn at(curve: &[[f64; 2]], time: f64) -> f64 {
    let next = curve.partition_point(|point| point[0] < time).clamp(1, curve.len() - 1);
    let [a, b] = [curve[next - 1], curve[next]];
    a[1] + ((time - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0) * (b[1] - a[1])
}

fn dots(name: &str, points: &[[f64; 2]]) -> Series {
    Series { name: name.into(), colour: DISTINCT[0], data: Data::Dashes(points.to_vec()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_curve_is_found_late() {
        let curve: Vec<[f64; 2]> = (0..=100).map(|n| 0.05 * f64::from(n)).map(|t| [t, 1.0 + t]).collect();
        let points = [[1.0, 1.8], [2.0, 2.8], [3.0, 3.8]];
        let found = deviations(&curve, &points);
        assert!((found.mean - 0.2).abs() < 1e-12 && (found.rms - 0.2).abs() < 1e-12);
        assert!((found.shift - 0.2).abs() < 1e-9 && found.rms_shifted < 1e-9);
    }
}
