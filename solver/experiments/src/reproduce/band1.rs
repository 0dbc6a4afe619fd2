//! Iterations and time by the length of the step: Band et al. 2018, Table 1, a breaking dam in a flat cylinder.

use super::methods::{CLEARANCE, Method, Scenery, fixed_step};
use super::prism::{circle, prism};
use crate::validation::flow::lattice;
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, FluidSettings, SolverSettings};
use volmap_fluid::shapes::{Shape, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{ClosureKind, DVec3};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "band1",
    title: "Iterations by step, Band Table 1",
    about: "A dam breaks in a flat cylinder, in four fixed steps (scaled: 1 m for 3 m, 25 mm for 8 mm)",
    run,
};

/// Radius and half length of the cylinder, metres: a third of the paper's.
const RADIUS: f64 = 0.5;
const HALF_LENGTH: f64 = 0.25 / 3.0;
/// Spacing of the particles, metres; the paper's is 8 mm.
const SPACING: f64 = 0.025;
/// Position of the gate that holds the water until it rests, metres.
const GATE: f64 = -0.11 * RADIUS;
/// A run that loses more particles is not counted.
const MOST_LOST: f64 = 10.0;
/// The paper's steps, seconds.
const STEPS: [f64; 4] = [0.25e-3, 0.5e-3, 1e-3, 1.5e-3];

/// A method, and what the paper has for it.
struct Case {
    method: Method,
    paper: Option<PaperCosts>,
}

/// The paper's figures for each of [`STEPS`].
#[derive(Clone, Copy)]
struct PaperCosts {
    /// Iterations of both solves in a step.
    iterations: [f64; 4],
    /// Milliseconds of a step.
    times: [f64; 4],
}

fn cases() -> [Case; 6] {
    let particles = |pressure, paper| Case { method: Method::of(BoundaryMethod::Particles, pressure), paper };
    let maps = |closure, pressure| Case { method: Method::maps(closure, pressure), paper: None };
    let paper = |iterations, times| Some(PaperCosts { iterations, times });
    [
        particles(BoundaryPressure::Mirror, paper([4.0, 5.7, 12.0, 14.9], MIRRORING)),
        particles(BoundaryPressure::Sph, paper([4.0, 5.7, 12.2, 16.0], [120.0, 192.0, 467.0, 618.0])),
        particles(BoundaryPressure::Mls, paper([4.0, 5.6, 11.8, 14.9], [123.0, 192.0, 462.0, 587.0])),
        particles(BoundaryPressure::Own, None),
        maps(ClosureKind::Mirror, BoundaryPressure::Own),
        maps(ClosureKind::Mirror, BoundaryPressure::Mls),
    ]
}

/// Cost of a run.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    steps: f64,
    density: f64,
    divergence: f64,
    /// Wall-clock time, seconds.
    time: f64,
    /// Time at which the simulation failed.
    stopped: Option<f64>,
    /// Particles in the wall or beyond at the end, removed ones included.
    lost: f64,
    removed: usize,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let mut curves = vec![Vec::new(); cases().len()];
    let dams =
        cases().into_iter().map(|case| settled(run, case.method)).collect::<Result<Vec<Dam>, Error>>()?;
    for (n, step) in STEPS.into_iter().enumerate() {
        if run.short && n % 2 == 0 {
            continue;
        }
        (run.progress)(&format!("band1: steps for the paper's {} ms", 1e3 * step));
        let costs = costs(run, &dams, step * scale())?;
        for (m, Case { method, paper }) in cases().into_iter().enumerate() {
            let case = format!("{} ms: {}", 1e3 * step, method.name());
            let paper = paper.map(|paper| [paper.iterations[n], paper.times[n] / MIRRORING[n]]);
            outcome.rows.extend(rows(&case, costs[m], costs[0], paper));
            if costs[m].is_fluid() {
                curves[m].push([1e3 * step, (costs[m].density + costs[m].divergence) / costs[m].steps]);
            }
        }
    }
    let series = cases().into_iter().zip(curves).zip(DISTINCT);
    let series = series.map(|((case, points), colour)| curve(case.method.name(), colour, points)).collect();
    let axes = [["The paper's step", "ms"], ["Iterations", "a step"]];
    outcome.chart("band1-iterations.png", chart("Iterations by step", axes[0], axes[1], series));
    outcome.notes.push(format!(
        "\
         Scaled: a cylinder of 1 m x 0.17 m with {SPACING} m between particles, for one of 3 m x 0.5 m with 8 mm. \
         Steps are {:.2} times the paper's: water that falls by the cylinder's height then crosses the same part of \
         a spacing. 1.2 s for 10 s, after the water has come to rest behind a gate. As in the paper, errors are 0.1 \
         %, iterations begin at zero, and each solve has two at least. The methods take turns step by step, so that \
         other load on the machine slows all of them alike.",
        scale()
    ));
    Ok(outcome)
}

/// The paper's milliseconds of a step with mirroring.
const MIRRORING: [f64; 4] = [116.0, 186.0, 448.0, 559.0];

/// Ratio of our steps to the paper's: of the spacings, over the root of the heights' ratio.
fn scale() -> f64 {
    SPACING / 0.008 * (3.0 / (2.0 * RADIUS)).sqrt()
}

impl Cost {
    fn is_fluid(&self) -> bool {
        self.stopped.is_none() && self.lost <= MOST_LOST
    }
}

/// A method, its cylinder, and the water behind the dam.
struct Dam {
    method: Method,
    cylinder: Shape,
    water: Vec<DVec3>,
}

/// Runs all methods with steps of `dt` (s), in turns.
fn costs(run: &Run, dams: &[Dam], dt: f64) -> Result<Vec<Cost>, Error> {
    let mut solver = fixed_step(SolverSettings::default(), dt);
    solver.warm_start = 0.0;
    for solve in [&mut solver.density, &mut solver.divergence] {
        solve.max_error = 1e-3;
        solve.min_iterations = 2;
    }
    let end = run.pick(0.2, 1.2);
    let mut all = Vec::new();
    for dam in dams {
        all.push((dam.simulation(&dam.water, None, solver.clone())?, Cost::default()));
    }
    while all.iter().any(|(simulation, cost)| cost.stopped.is_none() && simulation.time() < end) {
        for (simulation, cost) in &mut all {
            if cost.stopped.is_none() && simulation.time() < end {
                run.watch.check()?;
                advance(simulation, cost)?;
            }
        }
    }
    let count = |(simulation, cost): (Simulation, Cost)| Cost {
        lost: outside(&simulation) + cost.removed as f64,
        ..cost
    };
    Ok(all.into_iter().map(count).collect())
}

fn advance(simulation: &mut Simulation, cost: &mut Cost) -> Result<(), Error> {
    match simulation.step() {
        Ok(report) => {
            cost.steps += 1.0;
            cost.density += f64::from(report.density.iterations);
            cost.divergence += f64::from(report.divergence.iterations);
            cost.time += report.stages.total().as_secs_f64();
            cost.removed += report.removed;
        }
        Err(Error::Simulation { time, .. }) => cost.stopped = Some(time),
        Err(other) => return Err(other),
    }
    Ok(())
}

impl Dam {
    fn simulation(
        &self,
        places: &[DVec3],
        gate: Option<&Shape>,
        solver: SolverSettings,
    ) -> Result<Simulation, Error> {
        let mut bodies = vec![self.cylinder.body("cylinder", DVec3::ZERO, Motion::Static)];
        bodies.extend(gate.map(|gate| gate.body("gate", DVec3::ZERO, Motion::Static)));
        let fluid = FluidSettings { viscosity: 0.001, ..FluidSettings::default() };
        self.method.simulation(&Scenery {
            radius: 0.5 * SPACING,
            places: places.to_vec(),
            bodies,
            fluid,
            solver,
        })
    }
}

/// Water at rest in the left part of the lying cylinder: 43 % of it, which follows from the paper's particle count.
fn settled(run: &Run, method: Method) -> Result<Dam, Error> {
    (run.progress)(&format!("band1: {} comes to rest", method.name()));
    let radius = 0.5 * SPACING;
    let cylinder = method.shape(prism(&circle(RADIUS, 96), HALF_LENGTH), radius, true)?;
    let half = DVec3::new(RADIUS, RADIUS, HALF_LENGTH - (CLEARANCE - 1.0) * radius);
    let gate = method.shape(
        cuboid(DVec3::new(GATE, -0.6, -0.3), DVec3::new(GATE + 0.1, 0.6, 0.3)),
        radius,
        false,
    )?;
    let mut places = lattice(-half, half, radius);
    places.retain(|x| x.x < GATE - CLEARANCE * radius && x.truncate().length() < RADIUS - CLEARANCE * radius);
    let calm = Method { pressure: BoundaryPressure::Own, ..method };
    let calm = Dam { method: calm, cylinder, water: Vec::new() };
    let mut solver = SolverSettings::default();
    solver.time_step.max = 0.0005;
    solver.time_step.min = 1e-5;
    let mut simulation = calm.simulation(&places, Some(&gate), solver)?;
    run.until(&mut simulation, run.pick(0.15, 0.6), &mut |_, _| ())?;
    Ok(Dam { method, water: simulation.particles().positions.clone(), ..calm })
}

/// Particles that were lost, or are deeper in the wall than rp.
fn outside(simulation: &Simulation) -> f64 {
    let limit = 0.5 * SPACING;
    let out = |x: &&DVec3| x.truncate().length() > RADIUS + limit || x.z.abs() > HALF_LENGTH + limit;
    simulation.particles().positions.iter().filter(out).count() as f64
}

fn rows(case: &str, cost: Cost, mirroring: Cost, paper: Option<[f64; 2]>) -> Vec<Row> {
    let told = |quantity: &str, unit, value| Row::new(case, quantity, unit, value);
    if let Some(time) = cost.stopped {
        return vec![told("stopped at", "s", time)];
    }
    let lost = told("lost or in the wall", "", cost.lost);
    if !cost.is_fluid() {
        return vec![lost];
    }
    let iterations =
        told("iterations of both solves", "a step", (cost.density + cost.divergence) / cost.steps);
    let time = cost.time / cost.steps;
    let mirroring = if mirroring.is_fluid() { mirroring.time / mirroring.steps } else { f64::NAN };
    let over = told("time of a step over mirroring's", "", time / mirroring);
    let [iterations, over] = match paper {
        Some([count, ratio]) => [iterations.paper(count), over.paper(ratio)],
        None => [iterations, over],
    };
    let mut rows = vec![iterations, told("of these for the density", "a step", cost.density / cost.steps)];
    rows.extend(mirroring.is_finite().then_some(over));
    rows.push(told("time of a step", "ms", 1e3 * time));
    rows
}
