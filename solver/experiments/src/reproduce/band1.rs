//! Iterations and time by the length of the step: Band et al. 2018, Table 1, a breaking dam in a flat cylinder.

use super::methods::{CLEARANCE, Method, Scenery, fixed_step};
use super::prism::{circle, prism};
use crate::validation::flow::lattice;
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::observe::until;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, FluidSettings, SolverSettings};
use volmap_fluid::shapes::{Shape, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{ClosureKind, DVec3};

/// It.
pub const EXPERIMENT: Experiment = Experiment {
    name: "band1",
    title: "Iterations by step, Band Table 1",
    about: "A dam breaks in a flat cylinder at four fixed steps (scaled: 1 m for 3 m, spacing 25 mm for 8, steps 5.41 times as long)",
    run,
};

/// Of the cylinder, metres: a third of the paper's.
const RADIUS: f64 = 0.5;
const HALF_LENGTH: f64 = 0.25 / 3.0;
/// Spacing of the particles, metres; the paper's is 8 mm.
const SPACING: f64 = 0.025;
/// Where the gate stands that holds the water until it rests.
const GATE: f64 = -0.11 * RADIUS;
/// With more particles lost than these, a run is none.
const MOST_LOST: f64 = 10.0;
/// The paper's steps, seconds.
const STEPS: [f64; 4] = [0.25e-3, 0.5e-3, 1e-3, 1.5e-3];

/// A method, the paper's iterations, and its milliseconds a step.
type Case = (Method, Option<([f64; 4], [f64; 4])>);

fn cases() -> [Case; 6] {
    let particles = |pressure, paper| (Method::of(BoundaryMethod::Particles, pressure), paper);
    let maps = |closure, pressure| (Method::maps(closure, pressure), None);
    [
        particles(BoundaryPressure::Mirror, Some(([4.0, 5.7, 12.0, 14.9], [116.0, 186.0, 448.0, 559.0]))),
        particles(BoundaryPressure::Sph, Some(([4.0, 5.7, 12.2, 16.0], [120.0, 192.0, 467.0, 618.0]))),
        particles(BoundaryPressure::Mls, Some(([4.0, 5.6, 11.8, 14.9], [123.0, 192.0, 462.0, 587.0]))),
        particles(BoundaryPressure::Own, None),
        maps(ClosureKind::Mirror, BoundaryPressure::Own),
        maps(ClosureKind::Mirror, BoundaryPressure::Mls),
    ]
}

/// Of a run.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    steps: f64,
    density: f64,
    divergence: f64,
    /// Seconds.
    time: f64,
    /// When it stopped being a fluid.
    stopped: Option<f64>,
    /// Particles in the wall or beyond at the end, removed ones among them.
    lost: f64,
    removed: usize,
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let mut curves = vec![Vec::new(); cases().len()];
    let scenes =
        cases().into_iter().map(|(method, _)| settled(run, method)).collect::<Result<Vec<Scene>, Error>>()?;
    for (n, step) in STEPS.into_iter().enumerate() {
        if run.short && n % 2 == 0 {
            continue;
        }
        (run.progress)(&format!("band1: steps for the paper's {} ms", 1e3 * step));
        let costs = costs(&scenes, step * scale(), run.pick(0.2, 1.2))?;
        for (m, (method, paper)) in cases().into_iter().enumerate() {
            let case = format!("{} ms: {}", 1e3 * step, method.name());
            let paper = paper.map(|(iterations, times)| [iterations[n], times[n] / MIRRORING[n]]);
            outcome.rows.extend(rows(&case, costs[m], costs[0], paper));
            if costs[m].is_fluid() {
                curves[m].push([1e3 * step, (costs[m].density + costs[m].divergence) / costs[m].steps]);
            }
        }
    }
    let series = cases().into_iter().zip(curves).zip(DISTINCT);
    let series = series.map(|(((method, _), points), colour)| curve(method.name(), colour, points)).collect();
    let axes = [["The paper's step", "ms"], ["Iterations", "a step"]];
    outcome.chart("band1-iterations.png", chart("Iterations by step", axes[0], axes[1], series));
    outcome.notes.push(format!(
        "Scaled: a cylinder of 1 m x 0.17 m with {SPACING} m between particles for 3 m x 0.5 m with 8 mm; steps are {:.2} times the \
         paper's, so that water as fast as its height allows crosses the same part of a spacing; 1.2 s for 10 s, after \
         the water has come to rest behind a gate. As the paper, errors \
         of 0.1 % and iterations that begin at zero, two at least in each solve. The methods take turns step by step, so that \
         what else the machine does slows all.",
        scale()
    ));
    Ok(outcome)
}

/// The paper's milliseconds by mirroring.
const MIRRORING: [f64; 4] = [116.0, 186.0, 448.0, 559.0];

/// Of the steps: spacings over the root of the heights.
fn scale() -> f64 {
    SPACING / 0.008 * (3.0 / (2.0 * RADIUS)).sqrt()
}

impl Cost {
    fn is_fluid(&self) -> bool {
        self.stopped.is_none() && self.lost <= MOST_LOST
    }
}

/// A method, its cylinder, and its dam.
struct Scene {
    method: Method,
    cylinder: Shape,
    dam: Vec<DVec3>,
}

/// All methods at one step (s), in turns, until a time (s).
fn costs(scenes: &[Scene], dt: f64, end: f64) -> Result<Vec<Cost>, Error> {
    let mut solver = fixed_step(SolverSettings::default(), dt);
    solver.warm_start = 0.0;
    for solve in [&mut solver.density, &mut solver.divergence] {
        solve.max_error = 1e-3;
        solve.min_iterations = 2;
    }
    let mut all = Vec::new();
    for scene in scenes {
        all.push((scene.simulation(&scene.dam, None, solver.clone())?, Cost::default()));
    }
    while all.iter().any(|(simulation, cost)| cost.stopped.is_none() && simulation.time() < end) {
        for (simulation, cost) in &mut all {
            if cost.stopped.is_none() && simulation.time() < end {
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

impl Scene {
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

/// Water at rest in the left part of the cylinder, which lies: 43 % of it, as the paper's number of particles says.
fn settled(run: &Run, method: Method) -> Result<Scene, Error> {
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
    let scene = Scene { method: calm, cylinder, dam: Vec::new() };
    let mut solver = SolverSettings::default();
    solver.time_step.max = 0.0005;
    solver.time_step.min = 1e-5;
    let mut simulation = scene.simulation(&places, Some(&gate), solver)?;
    until(&mut simulation, run.pick(0.15, 0.6), &mut |_, _| ())?;
    Ok(Scene { method, dam: simulation.particles().positions.clone(), ..scene })
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
