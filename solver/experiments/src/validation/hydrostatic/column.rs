//! A column of water: simulated, then measured at rest. All lengths are metres unless they say rp.

use crate::validation::Run;
use volmap_fluid::Error;
use volmap_fluid::bodies::{Bodies, Motion};
use volmap_fluid::lattice::fill_box;
use volmap_fluid::observe::{centre, kinetic_energy, line, percentile, velocities};
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, FluidSettings, SolverSettings, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::Shape;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{ClosureKind, DVec3, KernelKind};

/// Half of the tank's edge.
pub const HALF_WIDTH: f64 = 0.5;
/// Time at the end over which figures are averaged, seconds.
const WINDOW: f64 = 1.0;

/// Time in which what begins at rest must not move, seconds.
const FIRST: f64 = 0.5;

/// A simulation of a column.
#[derive(Clone, Debug)]
pub struct Column {
    /// Particle radius rp.
    pub radius: f64,
    /// Kernel of the sums over neighbours, and its support radius in rp.
    pub kernel: (KernelKind, f64),
    /// Closure of the boundary.
    pub closure: ClosureKind,
    /// Volume of a particle in parts of (2 rp)^3.
    pub volume_factor: f64,
    /// How the fluid sees the tank.
    pub boundary: BoundaryMethod,
    /// The boundary's pressure.
    pub pressure: BoundaryPressure,
    /// Largest time step, seconds.
    pub largest_step: f64,
    /// Where the particles begin: lowest and highest corner, metres.
    pub block: [DVec3; 2],
    /// End of the simulation, seconds.
    pub end: f64,
}

/// Measurements at rest.
#[derive(Clone, Debug, Default)]
pub struct Rest {
    /// Particles.
    pub count: usize,
    /// Volume of the water over the tank's floor: how high it should stand.
    pub true_height: f64,
    /// Distances of the first layer from the floor and from the walls, in rp.
    pub layer: [f64; 2],
    /// Particles in the first layer above the floor.
    pub in_layer: usize,
    /// 99th percentile of the height, and rp: the top of the water.
    pub top: f64,
    /// Root mean square of the speeds in the last second, m/s.
    pub speed: f64,
    /// The same of the first layer above the floor and of the rest.
    pub layer_speed: [f64; 2],
    /// Largest relative density of a particle in the last second.
    pub density: f64,
    /// Height and mean pressure (Pa) of slices as thick as a layer, in the last second.
    pub pressures: Vec<[f64; 2]>,
    /// Pressure at the floor (Pa) and its slope with the height (Pa/m), of the line through `pressures` without the
    /// first layer and the last, which have a wall or nothing beside them.
    pub line: [f64; 2],
    /// Time and kinetic energy (J).
    pub energies: Vec<[f64; 2]>,
    /// Drift of the centre of mass in the second half.
    pub drift: f64,
    /// Means per step of the iterations of the density and the divergence solve in the last second.
    pub iterations: [f64; 2],
    /// Largest speed of a particle in the first half second, m/s.
    pub first_speed: f64,
    /// Particles found in the wall, over all steps.
    pub inside: usize,
    /// Particles that were lost.
    pub lost: usize,
}

impl Column {
    /// Simulates and measures.
    ///
    /// # Errors
    /// As [`Run::until`].
    pub fn settle(&self, run: &Run, tank: &Shape) -> Result<Rest, Error> {
        let mut simulation = self.simulation(tank)?;
        let mut rest = Rest { count: simulation.particles().len(), ..Rest::default() };
        rest.true_height = rest.count as f64 * simulation.particle_volume() / (2.0 * HALF_WIDTH).powi(2);
        let mut last = Window::new(simulation.particles().len());
        let mut half = None;
        run.until(&mut simulation, self.end, &mut |simulation, report| {
            rest.energies.push([simulation.time(), kinetic_energy(simulation)]);
            rest.inside += report.inside;
            if simulation.time() < FIRST {
                rest.first_speed = rest.first_speed.max(report.max_speed);
            }
            rest.lost += report.removed;
            if simulation.time() > 0.5 * self.end {
                half.get_or_insert_with(|| centre(simulation));
            }
            if simulation.time() > self.end - WINDOW {
                last.add(simulation, [report.density.iterations, report.divergence.iterations]);
            }
        })?;
        rest.drift = half.map_or(0.0, |half| (centre(&simulation) - half).length());
        rest.place(&simulation.particles().positions, self.radius);
        last.finish(&mut rest, &simulation, self.radius);
        Ok(rest)
    }

    /// Metres.
    pub fn support_radius(&self) -> f64 {
        self.kernel.1 * self.radius
    }

    fn simulation(&self, tank: &Shape) -> Result<Simulation, Error> {
        let world = World {
            particle_radius: self.radius,
            support_radius: self.support_radius(),
            kernel: self.kernel.0,
            boundary: self.boundary,
            closure: self.closure,
            ..World::default()
        };
        let mut solver = SolverSettings { boundary_pressure: self.pressure, ..SolverSettings::default() };
        solver.time_step.max = self.largest_step;
        let positions: Vec<DVec3> = fill_box(self.block, 2.0 * self.radius).collect();
        let mut particles = Particles::default();
        particles.add(&positions, &vec![[0.0; 3]; positions.len()]);
        let bodies = vec![tank.body("tank", DVec3::ZERO, Motion::Static)];
        let bodies = Bodies::new(bodies, world.gravity)?;
        Simulation::new(Setup {
            fluid: FluidSettings { volume_factor: self.volume_factor, ..FluidSettings::default() },
            solver,
            ..Setup::new(world, particles, bodies)
        })
    }
}

impl Rest {
    fn place(&mut self, positions: &[DVec3], radius: f64) {
        let heights: Vec<f64> = positions.iter().map(|x| x.y).collect();
        let to_walls = |x: &DVec3| [x.x, -x.x, x.z, -x.z].map(|side| HALF_WIDTH - side);
        let walls: Vec<f64> = positions.iter().flat_map(to_walls).collect();
        let (floor, wall) = (first_layer(&heights, radius), first_layer(&walls, radius));
        self.layer = [floor.0 / radius, wall.0 / radius];
        self.in_layer = floor.1;
        self.top = percentile(&heights, 0.99) + radius;
    }
}

/// Median distance of the layer nearest to a wall, and how many it has: those up to rp farther than the nearest few.
fn first_layer(distances: &[f64], radius: f64) -> (f64, usize) {
    let mut sorted = distances.to_vec();
    sorted.sort_by(f64::total_cmp);
    let few = &sorted[..sorted.len().min(20)];
    let limit = few.iter().sum::<f64>() / few.len().max(1) as f64 + radius;
    sorted.truncate(sorted.partition_point(|&distance| distance < limit));
    (percentile(&sorted, 0.5), sorted.len())
}

/// Sums over the last steps, for each particle by its id.
struct Window {
    steps: usize,
    /// Height, pressure, square of the speed.
    sums: Vec<[f64; 3]>,
    density: f64,
    iterations: [u64; 2],
}

impl Window {
    fn new(count: usize) -> Window {
        Window { steps: 0, sums: vec![[0.0; 3]; count], density: 0.0, iterations: [0; 2] }
    }

    fn add(&mut self, simulation: &Simulation, iterations: [u32; 2]) {
        let (particles, pressures) = (simulation.particles(), simulation.pressures());
        let speeds = velocities(simulation).map(DVec3::length_squared);
        for (i, speed) in speeds.enumerate() {
            let sum = &mut self.sums[particles.ids[i] as usize];
            let values = [particles.positions[i].y, pressures[i].into(), speed];
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
        let density = simulation.densities().iter().copied().fold(0.0, f32::max);
        self.density = self.density.max(density.into());
        self.iterations[0] += u64::from(iterations[0]);
        self.iterations[1] += u64::from(iterations[1]);
        self.steps += 1;
    }

    fn finish(&self, rest: &mut Rest, simulation: &Simulation, radius: f64) {
        let steps = self.steps.max(1) as f64;
        let means: Vec<[f64; 3]> = (simulation.particles().ids.iter())
            .map(|&id| self.sums[id as usize].map(|sum| sum / steps))
            .collect();
        let limit = (rest.layer[0] + 1.0) * radius;
        let speed = |keep: &dyn Fn(f64) -> bool| {
            let squares: Vec<f64> = means.iter().filter(|mean| keep(mean[0])).map(|mean| mean[2]).collect();
            (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
        };
        rest.speed = speed(&|_| true);
        rest.layer_speed = [speed(&|height| height < limit), speed(&|height| height >= limit)];
        rest.density = self.density;
        rest.iterations = self.iterations.map(|sum| sum as f64 / steps);
        rest.pressures = slices(&means, radius);
        let inner = 3.0 * radius..rest.true_height - 3.0 * radius;
        let inner: Vec<[f64; 2]> =
            rest.pressures.iter().copied().filter(|slice| inner.contains(&slice[0])).collect();
        rest.line = line(&inner);
    }
}

/// Mean height and pressure of slices of 2 rp.
fn slices(means: &[[f64; 3]], radius: f64) -> Vec<[f64; 2]> {
    let slice = |height: f64| (height / (2.0 * radius)).max(0.0) as usize;
    let count = means.iter().map(|mean| slice(mean[0]) + 1).max().unwrap_or(0);
    let mut sums = vec![[0.0; 3]; count];
    for &[height, pressure, _] in means {
        let sum = &mut sums[slice(height)];
        *sum = [sum[0] + height, sum[1] + pressure, sum[2] + 1.0];
    }
    // Slices of a few particles hold splashes.
    let full = sums.into_iter().filter(|sum| sum[2] >= 20.0);
    full.map(|[height, pressure, count]| [height / count, pressure / count]).collect()
}
