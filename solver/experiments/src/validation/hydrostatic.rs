//! Water at rest in a tank: where the layers lie, how calm they are, what pressure they have. Pressure of a fluid at
//! rest is rho g times the depth; the first layer of particles belongs half a spacing, rp, from floor and walls.
//!
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 4.3: the boundary's density, Eq. 14,
//! and force, Eq. 15.

pub(super) mod column;

use super::{Experiment, Outcome, Row, Run, chart, curve};
use column::{Column, HALF_WIDTH, Rest};
use volmap_figures::picture::colours::{DISTINCT, INK};
use volmap_figures::picture::{Data, Series};
use volmap_fluid::Error;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure};
use volmap_fluid::shapes::{Shape, baked_for, cuboid};
use volmap_runtime::{ClosureKind, DVec3, KernelKind};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "hydrostatic",
    title: "Water at rest in a tank, with every closure",
    about: "Layers belong 1 rp from floor and walls, pressure is rho g h within 2 %, and nothing moves",
    run,
};

/// Particle radius, metres; one case has half of it.
const RADIUS: f64 = 0.025;
const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1000.0;

pub(super) struct Case {
    pub name: String,
    pub column: Column,
    /// Whether the figures have targets: with the default closure and its own pressure.
    pub judged: bool,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let mut done = Vec::new();
    for case in cases(run) {
        (run.progress)(&format!("hydrostatic: {}, {} s", case.name, case.column.end));
        match case.column.settle(run, &tank(&case.column)?) {
            Ok(rest) => {
                outcome.rows.extend(rows(run, &case, &rest));
                done.push((case, rest));
            }
            Err(Error::Simulation { time, reason, .. }) => {
                outcome.rows.push(Row::new(&case.name, "stopped at", "s", time).target("never", false));
                outcome.notes.push(format!("{}: {reason}", case.name));
            }
            Err(other) => return Err(other),
        }
    }
    outcome.chart("hydrostatic_energy.png", energies(run, &done));
    outcome.chart("hydrostatic_pressure.png", pressures(&done));
    Ok(outcome)
}

/// A tank of 1 x 1.2 x 1 m, baked for the column's closure.
pub(super) fn tank(column: &Column) -> Result<Shape, Error> {
    let size = DVec3::new(HALF_WIDTH, 1.2, HALF_WIDTH);
    let hollow = cuboid(DVec3::new(-size.x, 0.0, -size.z), size);
    baked_for(column.closure, hollow, column.support_radius(), true)
}

/// The block that SPlisHSPlasH makes of [-0.45, 0.05, -0.45] to [0.45, 0.6, 0.45]: 2,890 particles.
const BLOCK: [DVec3; 2] = [DVec3::new(-0.425, 0.075, -0.425), DVec3::new(0.425, 0.575, 0.425)];

/// The tank filled from wall to wall, and the block, which spreads first: with particles of (2 rp)^3, as SPlisHSPlasH
/// has them from 2.19 on, and once with particles of 0.8 of that.
fn cases(run: &Run) -> Vec<Case> {
    let filled = |closure, end| Column { closure, end, largest_step: 0.005, ..filled(0.5) };
    let spread = |closure, end| Column { block: BLOCK, ..filled(closure, end) };
    let mirror = ClosureKind::Mirror;
    if run.short {
        return vec![Case { name: "mirror, block".into(), column: spread(mirror, 3.5), judged: true }];
    }
    let mut all = Vec::new();
    let mut add = |name: String, column: Column, judged| all.push(Case { name, column, judged });
    for closure in ClosureKind::ALL {
        let judged = closure == mirror;
        add(format!("{closure}"), filled(closure, 10.0), judged);
        add(format!("{closure}, block"), spread(closure, 8.0), judged);
    }
    add("mirror, 2 ms".into(), Column { largest_step: 0.002, ..filled(mirror, 10.0) }, true);
    add("mirror, block, 2 ms".into(), Column { largest_step: 0.002, ..spread(mirror, 8.0) }, true);
    add("mirror, block, 0.8".into(), Column { volume_factor: 0.8, ..spread(mirror, 8.0) }, true);
    add("mirror, rp / 2".into(), Column { radius: 0.5 * RADIUS, ..filled(mirror, 4.0) }, true);
    for closure in [mirror, ClosureKind::Calibrated] {
        add(
            format!("{closure}, Eq. 15"),
            Column { pressure: BoundaryPressure::Mirror, ..filled(closure, 4.0) },
            false,
        );
    }
    all
}

/// Water of this height (metres) from wall to wall, with the defaults, for 10 s.
pub(super) fn filled(height: f64) -> Column {
    Column {
        radius: RADIUS,
        kernel: (KernelKind::CubicSpline, 4.0),
        closure: ClosureKind::Mirror,
        volume_factor: 1.0,
        boundary: BoundaryMethod::VolumeMap,
        pressure: BoundaryPressure::Own,
        largest_step: 0.002,
        block: [DVec3::new(-HALF_WIDTH, 0.0, -HALF_WIDTH), DVec3::new(HALF_WIDTH, height, HALF_WIDTH)],
        end: 10.0,
    }
}

/// The short form ends before all is calm, and is judged by what it reaches until then.
pub(super) fn rows(run: &Run, case: &Case, rest: &Rest) -> Vec<Row> {
    let told = |quantity: &str, unit, value| Row::new(&case.name, quantity, unit, value);
    let judged = |row: Row, judge: &dyn Fn(Row) -> Row| if case.judged { judge(row) } else { row };
    let [floor, slope] = rest.line;
    let expected = DENSITY * GRAVITY * rest.true_height;
    let percent = |value: f64, of: f64| 100.0 * (value / of - 1.0);
    let [y, pressure] = rest.pressures.first().copied().unwrap_or([f64::NAN; 2]);
    let first = percent(pressure, expected - DENSITY * GRAVITY * y);
    let two = |row: Row| row.between(-2.0, 2.0);
    let [floor_error, slope_error] = run.pick([5.0, 8.0], [2.0, 2.0]);
    vec![
        told("particles", "", rest.count as f64),
        judged(told("first layer above the floor", "rp", rest.layer[0]), &|row| row.between(0.9, 1.1)),
        judged(told("first layer at the walls", "rp", rest.layer[1]), &|row| row.between(0.9, 1.1)),
        told("particles in the first layer", "", rest.in_layer as f64),
        told("height, true", "m", rest.true_height),
        judged(told("height of the water", "m", rest.top), &|row| {
            row.between(0.95 * rest.true_height, 1.05 * rest.true_height)
        }),
        judged(told("rms speed", "m/s", rest.speed), &|row| row.at_most(run.pick(0.015, 0.003))),
        told("largest speed in the first half second", "m/s", rest.first_speed),
        told("rms speed of the first layer", "m/s", rest.layer_speed[0]),
        told("rms speed above it", "m/s", rest.layer_speed[1]),
        judged(told("drift of the centre of mass", "rp", rest.drift / case.column.radius), &|row| {
            row.at_most(0.1)
        }),
        told("largest density", "rho_0", rest.density),
        judged(told("pressure at the floor, error", "%", percent(floor, expected)), &|row| {
            row.between(-floor_error, floor_error)
        }),
        judged(
            told(
                "pressure in the middle, error",
                "%",
                percent(floor + 0.5 * slope * rest.true_height, 0.5 * expected),
            ),
            &two,
        ),
        judged(told("slope of the pressure, error", "%", percent(slope, -DENSITY * GRAVITY)), &|row| {
            row.between(-slope_error, slope_error)
        }),
        told("pressure of the first layer, error", "%", first),
        told("iterations, density", "a step", rest.iterations[0]),
        told("iterations, divergence", "a step", rest.iterations[1]),
        judged(told("found in the wall", "", rest.inside as f64), &|row| row.at_most(run.pick(30.0, 0.0))),
        told("lost", "", rest.lost as f64).at_most(0.0),
    ]
}

/// Kinetic energy of the filled tank over time; in the short form, of what there is.
fn energies(run: &Run, done: &[(Case, Rest)]) -> volmap_figures::picture::Chart {
    let is_filled = |case: &Case| case.column.block != BLOCK && case.column.largest_step > 0.004;
    let shown = done.iter().filter(|(case, _)| run.short || is_filled(case));
    let series = shown.zip(DISTINCT.iter().cycle()).map(|((case, rest), &colour)| {
        // A point per 50 ms.
        let every = (rest.energies.len() / 200).max(1);
        let mean = |points: &[[f64; 2]]| {
            let energy = points.iter().map(|point| point[1]).sum::<f64>() / points.len() as f64;
            [points[points.len() - 1][0], energy]
        };
        let dashed = case.column.pressure == BoundaryPressure::Mirror;
        let points: Vec<[f64; 2]> = rest.energies.chunks(every).map(mean).collect();
        let data = if dashed { Data::Dashes(points) } else { Data::Curve(points) };
        Series { name: case.name.clone(), colour, data }
    });
    let mut chart =
        chart("Kinetic energy of water at rest", ["time", "s"], ["energy", "J"], series.collect());
    chart.y.log = true;
    chart
}

/// Pressure over the height, of the default closure.
fn pressures(done: &[(Case, Rest)]) -> volmap_figures::picture::Chart {
    let mut series = Vec::new();
    for ((case, rest), &colour) in done.iter().filter(|(case, _)| case.judged).zip(&DISTINCT) {
        series.push(curve(&case.name, colour, rest.pressures.clone()));
        let floor = DENSITY * GRAVITY * rest.true_height;
        let ideal = Data::Dashes(vec![[0.0, floor], [rest.true_height, 0.0]]);
        series.push(Series { name: String::new(), colour: INK, data: ideal });
    }
    chart("Pressure over the height; dashes: rho g h", ["height", "m"], ["pressure", "Pa"], series)
}
