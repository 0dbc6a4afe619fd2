//! The simulation: its state, and a step as Algorithm 1 of Band et al. 2018 writes it.

use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::cells::Cells;
use crate::neighbours::{CHUNK, Neighbours};
use crate::pairs::Pairs;
use crate::particles::Particles;
use crate::pressure::{Discretization, Fields, Solve, SolveReport};
use crate::settings::{FluidSettings, SolverSettings, World};
use crate::time_step::time_step;
use rayon::prelude::*;
use std::time::{Duration, Instant};
use volmap_runtime::{Closure, DVec3, Kernel};

/// A fluid, the bodies around it, and the time.
pub struct Simulation {
    /// Particle radius, support radius, gravity.
    pub world: World,
    /// What the fluid is.
    pub fluid: FluidSettings,
    /// How it is solved.
    pub solver: SolverSettings,
    /// The fluid.
    pub particles: Particles,
    /// What it touches.
    pub bodies: Bodies,
    /// Seconds since the beginning.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    closure: Closure,
    cells: Cells,
    order: Vec<u32>,
    neighbours: Neighbours,
    /// t
    pub boundary: Boundary,
    /// t
    pub fields: Fields,
    stages: Stages,
}

/// Wall-clock time of each stage of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stages {
    /// Sorting the particles by cells.
    pub sort: Duration,
    /// Lists of neighbours.
    pub neighbours: Duration,
    /// Asking the maps.
    pub boundary: Duration,
    /// Density and factor.
    pub density: Duration,
    /// The divergence solve.
    pub divergence: Duration,
    /// Viscosity and gravity.
    pub non_pressure: Duration,
    /// The density solve.
    pub pressure: Duration,
    /// New velocities and places.
    pub advance: Duration,
    /// Bodies.
    pub rigid: Duration,
}

/// What a step was like.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepReport {
    /// Its length, seconds.
    pub dt: f64,
    /// The density solve.
    pub density: SolveReport,
    /// The divergence solve.
    pub divergence: SolveReport,
    /// Largest speed, m/s.
    pub max_speed: f64,
    /// Particles whose centres were in a body.
    pub inside: usize,
    /// Time of each stage.
    pub stages: Stages,
}

impl Simulation {
    /// t
    pub fn new(world: World, fluid: FluidSettings, solver: SolverSettings, bodies: Bodies) -> Simulation {
        let closure = Closure::new(world.closure, Kernel::new(world.kernel, world.support_radius), world.particle_radius);
        Simulation {
            world,
            fluid,
            solver,
            particles: Particles::default(),
            bodies,
            time: 0.0,
            step: 0,
            closure,
            cells: Cells::default(),
            order: Vec::new(),
            neighbours: Neighbours::default(),
            boundary: Boundary::default(),
            fields: Fields::default(),
            stages: Stages::default(),
        }
    }

    /// Volume V of a particle, m^3.
    pub fn particle_volume(&self) -> f64 {
        self.fluid.volume_factor * (2.0 * self.world.particle_radius).powi(3)
    }

    /// One step: PERFORM SIMULATION of Algorithm 1.
    pub fn step(&mut self) -> StepReport {
        self.stages = Stages::default();
        let max_speed = self.max_speed();
        let dt = time_step(&self.solver.time_step, self.world.particle_radius, max_speed);
        self.find_neighbourhoods();
        self.compute_density();
        let divergence = self.correct_divergence_error(dt);
        self.add_non_pressure(dt);
        let density = self.correct_density_error(dt);
        self.advance(dt);
        self.bodies.step(dt);
        self.time += dt;
        self.step += 1;
        let inside = self.boundary.inside().count();
        StepReport { dt, density, divergence, max_speed, inside, stages: self.stages }
    }

    fn discretization(&self) -> Discretization {
        Discretization {
            kernel: self.world.kernel,
            support_radius: self.world.support_radius,
            volume: self.particle_volume(),
        }
    }

    fn find_neighbourhoods(&mut self) {
        let start = Instant::now();
        self.cells.sort(&self.particles.positions, self.world.support_radius, &mut self.order);
        self.particles.reorder(&self.order);
        self.stages.sort = start.elapsed();
        let start = Instant::now();
        self.fields.place(&self.particles, self.world.support_radius);
        self.neighbours.find(&self.cells, &self.particles.positions, &self.fields.places);
        self.stages.neighbours = start.elapsed();
    }

    fn compute_density(&mut self) {
        let start = Instant::now();
        self.boundary.sample(&self.bodies, &self.closure, &self.particles.positions);
        self.stages.boundary = start.elapsed();
        let start = Instant::now();
        let with = self.discretization();
        self.fields.compute_density(with, &self.neighbours, &self.boundary);
        self.stages.density = start.elapsed();
    }

    fn correct_divergence_error(&mut self, dt: f64) -> SolveReport {
        let start = Instant::now();
        let mut report = SolveReport::default();
        if self.solver.divergence.enabled {
            self.fields.set_pressures(&self.particles.divergence_pressures, self.solver.warm_start as f32);
            report = self.solve(dt, Fields::correct_divergence);
            self.fields.get_pressures(&mut self.particles.divergence_pressures);
            self.fields.accelerate_by_pressure(dt);
            self.push_bodies();
        }
        self.stages.divergence = start.elapsed();
        report
    }

    fn add_non_pressure(&mut self, dt: f64) {
        let start = Instant::now();
        let (fluid, gravity) = (&self.fluid, self.world.gravity.as_vec3().to_array());
        let with = self.discretization();
        self.fields.add_viscosity_and_gravity(with, &self.neighbours, fluid, gravity, dt);
        self.stages.non_pressure = start.elapsed();
    }

    fn correct_density_error(&mut self, dt: f64) -> SolveReport {
        let start = Instant::now();
        let mut report = SolveReport::default();
        if self.solver.density.enabled {
            self.fields.set_pressures(&self.particles.pressures, self.solver.warm_start as f32);
            report = self.solve(dt, Fields::correct_density);
            self.fields.get_pressures(&mut self.particles.pressures);
            self.fields.accelerate_by_pressure(dt);
            self.push_bodies();
        }
        self.stages.pressure = start.elapsed();
        report
    }

    fn solve(&mut self, dt: f64, solve: fn(&mut Fields, &Solve) -> SolveReport) -> SolveReport {
        let settings = if solve as usize == Fields::correct_density as usize {
            &self.solver.density
        } else {
            &self.solver.divergence
        };
        let with = Discretization {
            kernel: self.world.kernel,
            support_radius: self.world.support_radius,
            volume: self.particle_volume(),
        };
        let input = Solve {
            with,
            neighbours: &self.neighbours,
            boundary: &self.boundary,
            settings,
            relaxation: self.solver.relaxation as f32,
            dt,
        };
        solve(&mut self.fields, &input)
    }

    /// The fluid pushes the bodies as they push the fluid.
    fn push_bodies(&mut self) {}

    fn advance(&mut self, dt: f64) {
        let start = Instant::now();
        let velocities = &self.fields.velocities;
        let particles = &mut self.particles;
        let chunks = particles.positions.par_chunks_mut(CHUNK).zip(particles.velocities.par_chunks_mut(CHUNK));
        chunks.zip(velocities.par_chunks(CHUNK)).for_each(|((positions, out), velocities)| {
            for ((position, out), &[x, y, z, _]) in positions.iter_mut().zip(out).zip(velocities) {
                *out = [x, y, z];
                *position += dt * DVec3::new(x.into(), y.into(), z.into());
            }
        });
        self.stages.advance = start.elapsed();
    }

    fn max_speed(&self) -> f64 {
        let gravity = self.world.gravity.as_vec3() * self.solver.time_step.max as f32 * 0.0;
        let square = |v: &[f32; 3]| (glam::Vec3::from_array(*v) + gravity).length_squared();
        let max = self.particles.velocities.par_iter().map(square).reduce(|| 0.0, f32::max);
        f64::from(max.sqrt())
    }
}

impl Fields {
    fn place(&mut self, particles: &Particles, support_radius: f64) {
        let origin = particles.positions.first().copied().unwrap_or_default();
        let per = 1.0 / support_radius;
        let place = |&x: &DVec3| {
            let [x, y, z] = ((x - origin) * per).as_vec3().to_array();
            [x, y, z, 0.0]
        };
        particles.positions.par_iter().map(place).collect_into_vec(&mut self.places);
        self.places.push([1e6, 1e6, 1e6, 0.0]);
        particles.velocities.par_iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect_into_vec(&mut self.velocities);
        self.velocities.push([0.0; 4]);
    }

    fn set_pressures(&mut self, pressures: &[f32], part: f32) {
        for (place, pressure) in self.places.iter_mut().zip(pressures) {
            place[3] = part * pressure;
        }
    }

    fn get_pressures(&self, pressures: &mut [f32]) {
        for (place, pressure) in self.places.iter().zip(pressures) {
            *pressure = place[3];
        }
    }

    fn accelerate_by_pressure(&mut self, dt: f64) {
        let dt = dt as f32;
        self.velocities.par_chunks_mut(CHUNK).zip(self.accelerations.par_chunks(CHUNK)).for_each(|(v, a)| {
            for (v, a) in v.iter_mut().zip(a) {
                for axis in 0..3 {
                    v[axis] += dt * a[axis];
                }
            }
        });
    }

    fn add_viscosity_and_gravity(
        &mut self,
        with: Discretization,
        neighbours: &Neighbours,
        fluid: &FluidSettings,
        gravity: [f32; 3],
        dt: f64,
    ) {
        let pairs = Pairs {
            kernel: with.kernel,
            support_radius: with.support_radius,
            volume: with.volume,
            places: &self.places,
        };
        let (dt, nu, xsph) = (dt as f32, fluid.viscosity as f32, fluid.xsph as f32);
        let velocities = &self.velocities;
        self.accelerations.resize(velocities.len(), [0.0; 4]);
        self.accelerations.par_chunks_mut(CHUNK).zip(neighbours.chunks()).for_each(|(out, lists)| {
            let mut sums = [[[0.0; 3]; 2]; CHUNK];
            let sums = &mut sums[..lists.len()];
            pairs.viscosity(lists, velocities, sums);
            for (out, [laplacian, mean]) in out.iter_mut().zip(sums) {
                for axis in 0..3 {
                    out[axis] = gravity[axis] + nu * laplacian[axis] + xsph / dt * mean[axis];
                }
            }
        });
        self.accelerate_by_pressure(dt.into());
    }
}
