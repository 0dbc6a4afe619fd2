//! Every boundary method with every boundary pressure, in one small tank: where layers rest, how dense the fluid is
//! at the wall, how calm, what got into the wall on the way, and the largest stable step.

use super::methods::{Method, PRESSURES, Scenery, fixed_step, largest_step, median, pressure_name, survives};
use crate::validation::flow::{GRAVITY, lattice};
use crate::validation::{Experiment, Outcome, Row, Run, chart};
use volmap_figures::picture::colours::DISTINCT;
use volmap_figures::picture::{Chart, Data, Quantity, Series};
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::observe::{percentile, rms_speed};
use volmap_fluid::settings::{BoundaryMethod, SolverSettings};
use volmap_fluid::shapes::{Shape, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{ClosureKind, DVec3};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "combinations",
    title: "All boundary methods with all boundary pressures",
    about: "512 particles fall into a tank of 10 x 10 particles and come to rest, and again in ever longer steps",
    run,
};

/// Particle radius, metres.
const RADIUS: f64 = 0.05;
/// Half of the tank's width.
const HALF_WIDTH: f64 = 0.5;
/// Time over which the fluid at rest is averaged, seconds.
const WINDOW: f64 = 1.0;
/// Height of the fluid at the start, metres.
const TOP: f64 = 0.9;
/// First length of a step that is tried, seconds.
const FIRST_STEP: f64 = 0.008;

/// Results of a run.
#[derive(Clone, Debug, Default)]
struct Rest {
    /// Distances of the first layer from floor and walls, rp.
    layers: [f64; 2],
    /// Height of the fluid over the true one.
    height: f64,
    /// Mean of |D - 1| of the particles within r of floor and walls in the last second.
    density: f64,
    /// The same of the other particles.
    density_inside: f64,
    /// Rms speed, m/s.
    speed: f64,
    /// Part of centres in the wall, over all particles and steps.
    penetration: f64,
    lost: usize,
    /// Iterations of both solves a step, and median time of a step, in the last second.
    iterations: f64,
    time: f64,
    /// Time at which the simulation failed.
    stopped: Option<f64>,
    /// Largest stable step, seconds.
    largest_step: f64,
    /// Bytes of the map, and of contacts and boundary particles.
    memory: [usize; 2],
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let mut all = Vec::new();
    for view in views(run) {
        let tank = view.shape(tank_mesh(), RADIUS, true)?;
        for pressure in PRESSURES {
            let method = Method { pressure, ..view };
            (run.progress)(&format!("combinations: {}", method.name()));
            let rest = rest(run, method, &tank)?;
            outcome.rows.extend(rows(&method, &rest));
            all.push(rest);
        }
    }
    let floor = Quantity::new("Distance of the first layer from the floor", "rp");
    let layers = bars(&floor, &all, |rest| rest.layers[0]);
    outcome.chart("combinations-layers.png", layers);
    let steps = bars(&Quantity::new("Largest stable step", "ms"), &all, |rest| 1e3 * rest.largest_step);
    outcome.chart("combinations-steps.png", steps);
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    rp = 5 cm, r = 4 rp, nu = 0.01 m^2/s, steps of at most 2.8 ms. The fluid falls by one spacing, away from the \
    walls. The largest stable step is that of the same fall in equal steps for 2 s, tried in ratios of 2^(1/4): at \
    the end nothing is lost or deeper than rp in the wall, less than 1 % of centres were in the wall, and no speed \
    was more than twice that of a free fall from the top. The solver corrects only densities that are too large, so \
    errors of the density indicate gaps. Times are medians on a machine with other load. Numbers in the charts: \
    closures 1 mirror, 2 lattice, 3 wedge, 4 calibrated, 5 offset, 6 paper; 7 density map, 8 tube map, 9 particles.";

fn views(run: &Run) -> Vec<Method> {
    let own = PRESSURES[0];
    let mut all: Vec<Method> =
        ClosureKind::ALL.iter().rev().map(|&closure| Method::maps(closure, own)).collect();
    all.extend(
        [BoundaryMethod::DensityMap, BoundaryMethod::TubeMap].map(|boundary| Method::of(boundary, own)),
    );
    all.push(Method::of(BoundaryMethod::Particles, own));
    if run.short {
        all.retain(|view| {
            view.boundary == BoundaryMethod::Particles || *view == Method::maps(ClosureKind::Mirror, own)
        });
    }
    all
}

fn tank_mesh() -> volmap_formats::mesh::TriangleMesh {
    cuboid(DVec3::new(-HALF_WIDTH, 0.0, -HALF_WIDTH), DVec3::new(HALF_WIDTH, 1.2, HALF_WIDTH))
}

/// The scene without the fluid.
fn scenery(tank: &Shape) -> Scenery {
    let mut solver = SolverSettings::default();
    solver.time_step.max *= (RADIUS / 0.025_f64).sqrt();
    let bodies = vec![tank.body("tank", DVec3::ZERO, Motion::Static)];
    Scenery { radius: RADIUS, bodies, solver, ..Scenery::default() }
}

fn rest(run: &Run, method: Method, tank: &Shape) -> Result<Rest, Error> {
    let places = lattice(DVec3::new(-0.4, 0.1, -0.4), DVec3::new(0.4, TOP, 0.4), RADIUS);
    let scenery = Scenery { places, ..scenery(tank) };
    let mut simulation = method.simulation(&scenery)?;
    let end = run.pick(2.0, 6.0);
    let mut rest = Rest::default();
    let (mut particle_steps, mut window, mut times) = (0, 0.0, Vec::new());
    rest.stopped = survives(run, &mut simulation, end, &mut |simulation, report| {
        particle_steps += simulation.particles().len();
        rest.penetration += report.inside as f64;
        rest.lost += report.removed;
        if simulation.time() > end - WINDOW {
            window += 1.0;
            let [wall, inner] = density_errors(simulation);
            rest.density += wall;
            rest.density_inside += inner;
            rest.speed += rms_speed(simulation).powi(2);
            rest.iterations += f64::from(report.density.iterations + report.divergence.iterations);
            times.push(report.stages.total().as_secs_f64());
        }
    })?;
    rest.penetration /= particle_steps.max(1) as f64;
    rest.density /= window;
    rest.density_inside /= window;
    rest.speed = (rest.speed / window).sqrt();
    rest.iterations /= window;
    rest.time = median(&times);
    place(&mut rest, &simulation);
    rest.memory = [tank.map.memory_bytes(), simulation.boundary().memory_bytes()];
    let steps = (0..16).map(|n| FIRST_STEP * 2_f64.powf(0.25 * f64::from(n)));
    let steps = steps.filter(|step| !run.short || *step > 0.015);
    rest.largest_step = largest_step(steps, |dt| is_stable(run, method, &scenery, dt))?;
    Ok(rest)
}

/// Mean of |D - 1| within a support radius of floor and walls, and elsewhere below the surface.
fn density_errors(simulation: &Simulation) -> [f64; 2] {
    let [mut sums, mut counts] = [[0.0; 2], [0.0; 2]];
    let surface = percentile(&heights(simulation), 0.99) - 3.0 * RADIUS;
    for (x, &density) in simulation.particles().positions.iter().zip(simulation.densities()) {
        if x.y < surface {
            let at_wall = usize::from(to_walls(*x).min(x.y) > 4.0 * RADIUS);
            sums[at_wall] += (f64::from(density) - 1.0).abs();
            counts[at_wall] += 1.0;
        }
    }
    [sums[0] / f64::max(counts[0], 1.0), sums[1] / f64::max(counts[1], 1.0)]
}

fn heights(simulation: &Simulation) -> Vec<f64> {
    simulation.particles().positions.iter().map(|x| x.y).collect()
}

fn to_walls(x: DVec3) -> f64 {
    HALF_WIDTH - x.x.abs().max(x.z.abs())
}

fn place(rest: &mut Rest, simulation: &Simulation) {
    let heights = heights(simulation);
    let walls: Vec<f64> = simulation.particles().positions.iter().map(|x| to_walls(*x)).collect();
    rest.layers = [&heights, &walls].map(|distances| first_layer(distances) / RADIUS);
    let level = heights.len() as f64 * simulation.particle_volume() / (2.0 * HALF_WIDTH).powi(2);
    rest.height = (percentile(&heights, 0.99) + RADIUS) / level;
}

/// Median distance of the particles up to rp farther than the 5th percentile.
fn first_layer(distances: &[f64]) -> f64 {
    let limit = percentile(distances, 0.05) + RADIUS;
    let near: Vec<f64> = distances.iter().copied().filter(|&distance| distance < limit).collect();
    median(&near)
}

/// Whether the same fall is stable in equal steps: see the notes.
fn is_stable(run: &Run, method: Method, scenery: &Scenery, dt: f64) -> Result<bool, Error> {
    let solver = fixed_step(scenery.solver.clone(), dt);
    let mut simulation = method.simulation(&Scenery { solver, ..scenery.clone() })?;
    let (mut steps, mut inside, mut lost, mut fastest) = (0.0, 0, 0, 0.0_f64);
    let stopped = survives(run, &mut simulation, 2.0, &mut |_, report| {
        inside += report.inside;
        lost += report.removed;
        fastest = fastest.max(report.max_speed);
        steps += 1.0;
    })?;
    let most = 0.01 * scenery.places.len() as f64 * steps;
    let deep = |x: &DVec3| to_walls(*x).min(x.y) < -RADIUS;
    let escaped = simulation.particles().positions.iter().any(deep);
    let allowed = 2.0 * (2.0 * GRAVITY * TOP).sqrt();
    Ok(stopped.is_none() && lost == 0 && !escaped && (inside as f64) < most && fastest < allowed)
}

fn rows(method: &Method, rest: &Rest) -> Vec<Row> {
    let case = method.name();
    let told = |quantity: &str, unit, value| Row::new(&case, quantity, unit, value);
    let mut rows = vec![
        told("first layer above the floor", "rp", rest.layers[0]),
        told("first layer at the walls", "rp", rest.layers[1]),
        told("height over the true one", "", rest.height),
        told("density at floor and walls, error", "%", 100.0 * rest.density),
        told("density elsewhere, error", "%", 100.0 * rest.density_inside),
        told("rms speed", "m/s", rest.speed),
        told("centres in the wall", "%", 100.0 * rest.penetration),
        told("lost", "", rest.lost as f64),
        told("largest stable step", "ms", 1e3 * rest.largest_step),
        told("iterations", "a step", rest.iterations),
        told("time of a step", "ms", 1e3 * rest.time),
        told("memory of the map", "KiB", rest.memory[0] as f64 / 1024.0),
        told("memory of contacts and boundary particles", "KiB", rest.memory[1] as f64 / 1024.0),
    ];
    if let Some(time) = rest.stopped {
        rows.push(told("stopped at", "s", time));
    }
    rows
}

/// A group of bars for each boundary method, a colour for each pressure.
fn bars(quantity: &Quantity, all: &[Rest], value: impl Fn(&Rest) -> f64) -> Chart {
    let mut series: Vec<Series> = PRESSURES
        .iter()
        .zip(DISTINCT)
        .map(|(&pressure, colour)| Series {
            name: pressure_name(pressure).into(),
            colour,
            data: Data::Bars(Vec::new()),
        })
        .collect();
    for (n, rest) in all.iter().enumerate() {
        let (group, place) = (n / PRESSURES.len(), n % PRESSURES.len());
        let left = group as f64 + 0.6 + 0.2 * place as f64;
        if let Data::Bars(bars) = &mut series[place].data {
            bars.push([left, left + 0.18, value(rest)]);
        }
    }
    let Quantity { name, unit } = quantity;
    chart(name, ["Method, by the numbers of the note", ""], [name, unit], series)
}
