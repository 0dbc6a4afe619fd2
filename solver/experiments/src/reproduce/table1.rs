//! Times of a step for particles, density maps and volume maps: Bender et al. 2020, *Implicit Frictional Boundary
//! Handling for SPH*, Table 1, its double dam break with fewer particles.

use super::boundaries::{DENSITY_MAP, Named, PAPER_MAP, PARTICLES, VOLUME_MAP};
use crate::validation::flow::lattice;
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use rayon::prelude::*;
use std::time::{Duration, Instant};
use volmap_bake::plan::GridChoice;
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::observe::percentile;
use volmap_fluid::settings::{BoundaryMethod, FluidSettings};
use volmap_fluid::shapes::{baked_by, cuboid};
use volmap_fluid::simulation::{Simulation, StepReport};
use volmap_runtime::{ClosureKind, DVec3, Sample, SurfaceWithGradient};

/// Points per query of a map.
const AT_ONCE: usize = 512;
/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "table1",
    title: "Times of a step",
    about: "Double dam break: times of a step for boundary particles, density maps and volume maps",
    run,
};

/// The paper's times for 3 million particles, ms: search, pressure, non-pressure, all.
const PAPER: [[f64; 4]; 3] =
    [[411.0, 1090.0, 357.0, 1858.0], [379.0, 1054.0, 339.0, 1715.0], [369.0, 1078.0, 342.0, 1789.0]];
/// The paper's particles, millions.
const PAPER_PARTICLES: f64 = 3.0;
const STAGES: [&str; 4] = ["neighbour search", "pressure", "non-pressure", "total"];

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let (radius, end) = run.pick((0.05, 0.3), (0.025, 0.5));
    let methods = [PARTICLES, DENSITY_MAP, PAPER_MAP, VOLUME_MAP];
    let mut racers = Vec::new();
    for method in methods {
        (run.progress)(&format!("table1: {}, made", method.name));
        racers.push(Racer::new(method, radius)?);
    }
    // The simulation that is behind does the next step, so that other load on the machine slows all alike.
    loop {
        let next = racers.iter_mut().min_by(|a, b| a.simulation.time().total_cmp(&b.simulation.time()));
        let Some(next) = next.filter(|next| next.simulation.time() < end) else { break };
        run.watch.check()?;
        next.step()?;
        if next.steps % 50 == 0 {
            let [time, name] = [format!("{:.2} s", next.simulation.time()), next.view.name.into()];
            (run.progress)(&format!("table1: {name}, {time}"));
        }
    }
    let first = racers[0].milliseconds();
    for (racer, paper) in racers.iter().zip([Some(0), Some(1), Some(2), None]) {
        racer.rows(&mut outcome, first, paper.map(|n: usize| PAPER[n]));
    }
    let curves = racers.into_iter().zip(DISTINCT);
    let curves = curves.map(|(racer, colour)| curve(racer.view.name, colour, racer.points)).collect();
    let axes = [["Time", "s"], ["Time of a step without map queries of particles", "ms"]];
    outcome.chart("table1.png", chart("Times of a step", axes[0], axes[1], curves));
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    61,250 particles instead of 3 million (short: 6,912). Medians over steps in ms per million particles; the \
    paper's means divided by 3. With fewer particles, more of them are near a wall. Neighbour search is sorting and \
    the lists of fluid neighbours, with boundary particles also their contacts. Pressure is both solves, with maps \
    also their queries. Non-pressure is viscosity, gravity and new positions. With boundary particles the solver \
    queries the maps as well, to find particles inside bodies; these queries are timed separately after each step \
    and subtracted. The four simulations take turns, step by step. Maps have cells of r / 2; that of the default \
    closure is a narrow one with cells of r / 8.";

/// A simulation and its times.
struct Racer {
    view: Named,
    simulation: Simulation,
    steps: u32,
    /// Of each step, seconds: search, pressure, non-pressure, all, and the boundary's part of these.
    times: [Vec<f64>; 5],
    iterations: u32,
    points: Vec<[f64; 2]>,
    map_bytes: usize,
}

impl Racer {
    fn new(view: Named, radius: f64) -> Result<Racer, Error> {
        // The scene of data/scenes/double_dam_break.toml.
        let tank = cuboid(DVec3::new(-1.55, 0.0, -1.55), DVec3::new(1.55, 3.1, 1.55));
        // Maps have cells of r / 2, which bake fast, but for the narrow one of the default.
        let support_radius = 4.0 * radius;
        let mut baking = view.method.baking(support_radius, true);
        if view.method.closure != ClosureKind::Mirror || view.method.boundary != BoundaryMethod::VolumeMap {
            baking.grid = GridChoice::CellSize(0.5 * support_radius);
        }
        let tank = baked_by(tank, baking)?;
        let map_bytes = tank.map.memory_bytes();
        let mut setup = view.setup(radius, vec![tank.body("tank", DVec3::Y * -0.05, Motion::Static)])?;
        setup.fluid = FluidSettings::default();
        let low = 0.2 + radius;
        let blocks = [(-1.5 + radius, -low), (low, 1.5 - radius)];
        for (from, to) in blocks {
            let places = lattice(DVec3::new(from, radius, from), DVec3::new(to, 2.5 - radius, to), radius);
            setup.particles.add(&places, &vec![[0.0; 3]; places.len()]);
        }
        let simulation = Simulation::new(setup)?;

        Ok(Racer {
            view,
            simulation,
            steps: 0,
            times: Default::default(),
            iterations: 0,
            points: Vec::new(),
            map_bytes,
        })
    }

    fn step(&mut self) -> Result<(), Error> {
        let StepReport { stages, density, divergence, .. } = self.simulation.step()?;
        let mut boundary = stages.boundary;
        let mut times = [
            stages.sort + stages.neighbours,
            stages.density + stages.divergence + stages.pressure,
            stages.non_pressure + stages.advance,
        ];
        if self.view.method.boundary == BoundaryMethod::Particles {
            boundary = boundary.saturating_sub(self.map_queries());
            times[0] += boundary;
        } else {
            times[1] += boundary;
        }
        let total = times.iter().sum();
        for (list, time) in self.times.iter_mut().zip(times.into_iter().chain([total, boundary])) {
            list.push(time.as_secs_f64());
        }
        self.steps += 1;
        self.iterations += density.iterations + divergence.iterations;
        self.points.push([self.simulation.time(), 1e3 * total.as_secs_f64()]);
        Ok(())
    }

    /// The time in which the solver finds particles in bodies, with as many points per query as a block has.
    fn map_queries(&self) -> Duration {
        let start = Instant::now();
        let chunks = self.simulation.particles().positions.par_chunks(AT_ONCE);
        chunks.for_each_init(Vec::<Sample<SurfaceWithGradient>>::new, |samples, positions| {
            for body in self.simulation.bodies().posed() {
                body.sample_batch(positions, samples);
                std::hint::black_box(&samples);
            }
        });
        start.elapsed()
    }

    /// Medians of [`Racer::times`], ms per million particles.
    fn milliseconds(&self) -> [f64; 5] {
        let millions = self.simulation.particles().len() as f64 / 1e6;
        std::array::from_fn(|n| 1e3 * percentile(&self.times[n], 0.5) / millions)
    }

    fn rows(&self, outcome: &mut Outcome, first: [f64; 5], paper: Option<[f64; 4]>) {
        let (case, rows) = (self.view.name, &mut outcome.rows);
        let times = self.milliseconds();
        for (n, (stage, time)) in STAGES.into_iter().zip(times).enumerate() {
            let of_paper = |row: Row, value: fn([f64; 4], usize) -> f64| match paper {
                Some(paper) => row.paper(value(paper, n)),
                None => row,
            };
            let row = Row::new(case, stage, "ms", time);
            rows.push(of_paper(row, |paper, n| paper[n] / PAPER_PARTICLES));
            if self.view.method.boundary != BoundaryMethod::Particles {
                let row = Row::new(case, format!("{stage} over that of particles"), "", time / first[n]);
                rows.push(of_paper(row, |paper, n| paper[n] / PAPER[0][n]));
            }
        }
        rows.push(Row::new(case, "boundary's part of it", "ms", times[4]));
        let iterations = f64::from(self.iterations) / f64::from(self.steps);
        rows.push(Row::new(case, "iterations of both solves in a step", "", iterations));
        let pressure = times[1] / iterations;
        rows.push(Row::new(case, "pressure in an iteration", "ms", pressure));
        rows.push(Row::new(case, "steps", "", self.steps.into()));
        rows.push(Row::new(case, "boundary particles", "", self.simulation.boundary_particles() as f64));
        let needed = if self.view.method.boundary == BoundaryMethod::Particles { 0 } else { self.map_bytes };
        rows.push(Row::new(case, "map", "MB", 1e-6 * needed as f64));
        rows.push(Row::new(case, "particles and lists", "MB", 1e-6 * self.simulation.memory_bytes() as f64));
    }
}
