//! The simulation: its state, and a step as Algorithm 1 of Band et al. 2018 writes it.

mod turns;

use crate::blocks::TooDense;
use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::boundary::pressed::Pinched;
use crate::boundary::pressure::{self, Extrapolation, WallPressure};
use crate::cells::Cells;
use crate::channels::Channels;
use crate::compression::Compression;
use crate::coupling;
use crate::discretization::Discretization;
use crate::emitter::Emitter;
use crate::error::Error;
use crate::fields::{self, Fields};
use crate::forces::{Force, ForceStep, Forces, Solved};
use crate::fused;
use crate::neighbours::{Neighbours, Sought};
use crate::pairs::Quad;
use crate::pairs::table::MOST;
use crate::particles::{CHUNK, Particles};
use crate::plane;
use crate::pressure::{Solve, forces_on_bodies, to_correct};
use crate::report::SolveReport;
use crate::response::Response;
use crate::room::{self, Room};
use crate::settings::{FluidSettings, SolveSettings, SolverSettings, World};
use crate::setup::Setup;
use crate::stages::Stages;
use crate::strays::{self, Strays};
use crate::time_step::{part_of, time_step};
use rayon::prelude::*;
use turns::Turns;
use volmap_formats::text::number;
use volmap_runtime::DVec3;

/// A fluid, the bodies around it, and the time.
pub struct Simulation {
    world: World,
    fluid: FluidSettings,
    solver: SolverSettings,
    domain: [DVec3; 2],
    pub(crate) particles: Particles,
    pub(crate) emitters: Vec<Emitter>,
    pub(crate) bodies: Bodies,
    pub(crate) time: f64,
    pub(crate) step: u64,
    /// Largest speed of a body where it touched the fluid in the last step, m/s.
    pub(crate) body_speed: f64,
    /// Force and torque of the fluid on each body in the last step.
    body_forces: Vec<[DVec3; 2]>,
    cells: Cells,
    order: Vec<u32>,
    /// Room to put particles into another order.
    spare: Particles,
    neighbours: Neighbours,
    boundary: Boundary,
    discretization: Discretization,
    /// See [`World::jacobi_relaxation`].
    relaxation: f64,
    extrapolation: Extrapolation,
    pub(crate) fields: Fields,
    forces: Forces,
    stages: Stages,
}

/// What a solve is for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Goal {
    Divergence,
    Density,
}

impl Goal {
    fn settings(self, solver: &SolverSettings) -> &SolveSettings {
        match self {
            Goal::Divergence => &solver.divergence,
            Goal::Density => &solver.density,
        }
    }
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
    /// The solves of implicit forces, as that of [viscosity](crate::forces::implicit_viscosity): iterations of all,
    /// the largest error.
    pub viscosity: SolveReport,
    /// How often viscosity and density were solved for, in turns; 1 where they aren't.
    pub passes: u32,
    /// Largest speed at its beginning, m/s, that of bodies where they touch the fluid included.
    pub max_speed: f64,
    /// How much denser than at rest the fluid was at its beginning: after the step before, and with what emitters have
    /// added since.
    pub compression: Compression,
    /// Particles that came from emitters.
    pub emitted: usize,
    /// Particles that emitters should have given, and there was no room for.
    pub held: usize,
    /// Particles that left the domain and were removed.
    pub removed: usize,
    /// Particles whose centres were in a body.
    pub inside: usize,
    /// Particles that walls press together with no way out, and the worst place.
    pub pinched: Pinched,
    /// Particles that a body is near.
    pub near_bodies: usize,
    /// Wall-clock times.
    pub stages: Stages,
}

/// What forces change.
struct Changed<'a> {
    velocities: &'a mut [Quad],
    accelerations: &'a mut [Quad],
    channels: &'a mut Channels,
}

impl Simulation {
    /// A simulation at time 0.
    ///
    /// # Errors
    /// As [`Boundary::new`]; factors of the solver out of their range, a free body that is too light; a force whose
    /// settings can't be used, or that needs a channel of another force.
    pub fn new(setup: Setup) -> Result<Simulation, Error> {
        plane::check(&setup)?;
        setup.check()?;
        let domain = setup.domain_or_default();
        let Setup { world, fluid, solver, mut particles, emitters, bodies, forces, own_forces, .. } = setup;
        let forces = Forces::new(&world, &fluid, &solver, &forces, own_forces);
        prepare(&forces, &mut particles)?;
        let densities = vec![1.0; particles.len()];
        let boundary = Boundary::new(&world, &fluid, &bodies)?;
        Ok(Simulation {
            domain,
            discretization: Discretization::new(&world, &fluid),
            relaxation: world.jacobi_relaxation(&fluid, solver.relaxation),
            world,
            fluid,
            solver,
            particles,
            emitters,
            bodies,
            time: 0.0,
            step: 0,
            body_speed: 0.0,
            body_forces: Vec::new(),
            cells: Cells::default(),
            order: Vec::new(),
            spare: Particles::default(),
            neighbours: Neighbours::default(),
            boundary,
            extrapolation: Extrapolation::default(),
            fields: Fields { densities, ..Fields::default() },
            forces,
            stages: Stages::default(),
        })
    }

    /// One step: PERFORM SIMULATION of Algorithm 1, and the bodies.
    ///
    /// # Errors
    /// [`Error::Simulation`] when what is computed is no fluid any more; the state is then of no use.
    pub fn step(&mut self) -> Result<StepReport, Error> {
        // All on one of rayon's threads: from outside, each parallel loop would put this thread to sleep and wake it
        // again.
        rayon::scope(|_| self.perform(None))
    }

    /// One step of those that end exactly at `target`, seconds, which must be later than now: none is longer than
    /// [`Simulation::step`] would make it, and they share what is left evenly, so that none is tiny.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn step_towards(&mut self, target: f64) -> Result<StepReport, Error> {
        rayon::scope(|_| self.perform(Some(target)))
    }

    fn perform(&mut self, target: Option<f64>) -> Result<StepReport, Error> {
        self.stages.begin();
        self.body_forces.clear();
        self.body_forces.resize(self.bodies.posed().len(), [DVec3::ZERO; 2]);
        let [emitted, held] = self.emit();
        let max_speed = self.max_speed();
        let mut dt = self.time_step(max_speed)?;
        let mut end = self.time + dt;
        if let Some(target) = target.filter(|target| *target > self.time) {
            let left = target - self.time;
            dt = part_of(left, dt);
            // The last of them: no rounding of sums.
            end = if dt == left { target } else { self.time + dt };
        }
        self.find_neighbourhoods(dt)?;
        self.compute_density();
        let compression = Compression::of(&self.fields.densities, &self.particles.positions);
        let pinched = Pinched::of(&self.boundary, &self.particles.positions);
        let divergence = self.correct_divergence_error(dt);
        let Turns { passes, viscosity, density, .. } = match self.is_in_turns(dt) {
            true => self.solve_in_turns(dt),
            false => {
                let viscosity = self.add_non_pressure(dt);
                Turns { passes: 1, viscosity, density: self.correct_density_error(dt), ..Turns::default() }
            }
        };
        self.advance(dt);
        let removed = strays::remove_outside(&mut self.particles, &mut self.fields.densities, self.domain);
        self.stages.end(|stages| &mut stages.advance);
        self.bodies.step(dt)?;
        self.stages.end(|stages| &mut stages.rigid);
        self.time = end;
        self.step += 1;
        Ok(StepReport {
            dt,
            density,
            divergence,
            viscosity,
            passes,
            max_speed,
            compression,
            emitted,
            held,
            removed,
            inside: self.boundary.inside().count(),
            pinched,
            near_bodies: self.boundary.of_particle.iter().filter(|wall| wall.density != 0.0).count(),
            stages: self.stages,
        })
    }

    /// Adds what the emitters give; how many particles that are, and for how many more there is no room.
    fn emit(&mut self) -> [usize; 2] {
        let before = self.particles.len();
        let held = |emitters: &[Emitter]| emitters.iter().map(|emitter| emitter.state.held).sum::<u64>();
        let held_before = held(&self.emitters);
        let spacing = self.world.rest_spacing(&self.fluid);
        let Simulation { emitters, particles, bodies, fields, .. } = self;
        for emitter in emitters.iter_mut() {
            let (positions, densities) = (&particles.positions, &fields.densities);
            let room = |layer: &[DVec3]| Room::near(layer, positions, densities, bodies, spacing);
            let places = emitter.emit(self.time, room);
            let velocity = emitter.velocity().as_vec3().to_array();
            particles.add(&places, &vec![velocity; places.len()]);
            let waiting = emitter.waiting();
            if !waiting.is_empty() {
                room::clear(&waiting, emitter.velocity(), particles, spacing);
            }
        }
        [self.particles.len() - before, (held(&self.emitters) - held_before) as usize]
    }

    fn time_step(&self, max_speed: f64) -> Result<f64, Error> {
        let settings = &self.solver.time_step;
        let smallest = if settings.adaptive { settings.min } else { settings.initial };
        let way = max_speed * smallest;
        if way.is_nan() || way > self.world.support_radius {
            return Err(self.stopped(format!(
                "the largest speed is {} m/s: a particle crosses the support radius of {} m in the smallest \
                 time step, {} s; allow smaller steps (solver.time_step), or look for fluid that begins in a \
                 body or on top of other fluid",
                number(max_speed),
                self.world.support_radius,
                number(smallest)
            )));
        }
        let first = self.step == 0 && settings.adaptive;
        let longest = self.forces.longest_step();
        let dt = time_step(settings, self.world.particle_radius, max_speed, longest);
        Ok(if first { dt.min(settings.initial) } else { dt })
    }

    fn stopped(&self, reason: String) -> Error {
        Error::Simulation { step: self.step, time: self.time, reason }
    }

    fn find_neighbourhoods(&mut self, dt: f64) -> Result<(), Error> {
        self.sort();
        self.part_fused(dt);
        self.fields.place(&self.particles, self.world.support_radius);
        self.stages.end(|stages| &mut stages.sort);
        let bends = self.forces.iter().any(Force::needs_bends);
        let sought = Sought { with: self.discretization, bends };
        let Fields { places, neighbourhoods, .. } = &mut self.fields;
        let found = self.neighbours.find(&self.cells, places, sought, neighbourhoods);
        found.map_err(|dense| self.too_dense(dense))?;
        self.stages.end(|stages| &mut stages.neighbours);
        Ok(())
    }

    fn too_dense(&self, TooDense { particle }: TooDense) -> Error {
        let DVec3 { x, y, z } = self.particles.positions[particle];
        self.stopped(format!(
            "more than {MOST} particles are near each other at ({x:.4}, {y:.4}, {z:.4}): look for fluid that \
             begins on top of other fluid, or is pressed together by bodies"
        ))
    }

    fn compute_density(&mut self) {
        self.boundary.sample(&self.bodies, &self.particles.positions, &self.neighbours);
        self.body_speed = self.boundary.max_speed();
        self.stages.end(|stages| &mut stages.boundary);
        self.fields.compute_density(&self.boundary);
        self.stages.end(|stages| &mut stages.density);
        let fluid = pressure::Fluid {
            cells: &self.cells,
            positions: &self.particles.positions,
            densities: &self.fields.densities,
            with: self.discretization,
            gravity: self.world.gravity,
        };
        self.extrapolation.find(self.solver.boundary_pressure, &mut self.boundary, fluid);
        self.stages.end(|stages| &mut stages.boundary);
    }

    fn correct_divergence_error(&mut self, dt: f64) -> SolveReport {
        let report = self.correct(Goal::Divergence, dt);
        self.stages.end(|stages| &mut stages.divergence);
        report
    }

    /// All other forces: explicit ones, then implicit ones.
    fn add_non_pressure(&mut self, dt: f64) -> SolveReport {
        self.add_explicit(dt);
        let solved = self.solve_implicit(dt);
        self.push(&solved.on_bodies);
        self.stages.end(|stages| &mut stages.non_pressure);
        solved.report
    }

    fn add_explicit(&mut self, dt: f64) {
        self.with_forces(dt, |forces, step, work| {
            forces.accelerate(step, work.velocities, work.channels, work.accelerations);
            fields::accelerate(work.velocities, work.accelerations, dt);
        });
    }

    fn solve_implicit(&mut self, dt: f64) -> Solved {
        self.with_forces(dt, |forces, step, work| forces.solve(step, work.velocities, work.channels))
    }

    /// Forces, what they see of a step, and what they change.
    fn with_forces<T>(&mut self, dt: f64, work: impl FnOnce(&mut Forces, &ForceStep, Changed) -> T) -> T {
        let with = self.discretization;
        let particle_mass = self.particle_mass();
        let Particles { positions, channels, .. } = &mut self.particles;
        let Fields { places, densities, velocities, accelerations, .. } = &mut self.fields;
        let step = ForceStep {
            dt,
            world: &self.world,
            with,
            particle_mass,
            neighbours: &self.neighbours,
            boundary: &self.boundary,
            bodies: &self.bodies,
            positions,
            places,
            densities,
        };
        work(&mut self.forces, &step, Changed { velocities, accelerations, channels })
    }

    fn correct_density_error(&mut self, dt: f64) -> SolveReport {
        let report = self.correct(Goal::Density, dt);
        self.stages.end(|stages| &mut stages.pressure);
        report
    }

    /// A solve, and what its pressures do to fluid and bodies.
    fn correct(&mut self, goal: Goal, dt: f64) -> SolveReport {
        if !goal.settings(&self.solver).enabled {
            return SolveReport::default();
        }
        let mut fields = std::mem::take(&mut self.fields);
        let solve = self.solve(goal, dt);
        let report = match goal {
            Goal::Divergence => fields.correct_divergence(&solve),
            Goal::Density => {
                fields.set_pressures(&self.particles.pressures, self.solver.warm_start as f32);
                fields.correct_density(&solve)
            }
        };
        if solve.wall.is_more_than_own() {
            let error = |density| if goal == Goal::Density { to_correct(density) } else { 0.0 };
            fields.bound_energy(&solve, error);
        }
        let forces = forces_on_bodies(&self.bodies, &fields, &solve, self.particle_mass());
        fields::accelerate(&mut fields.velocities, &fields.accelerations, dt);
        if goal == Goal::Density {
            self.particles.pressures.copy_from_slice(&fields.pressures);
        }
        self.fields = fields;
        self.push(&forces);
        report
    }

    fn push(&mut self, forces: &[[DVec3; 2]]) {
        coupling::push(&mut self.bodies, forces);
        for (sum, force) in self.body_forces.iter_mut().zip(forces) {
            sum[0] += force[0];
            sum[1] += force[1];
        }
    }

    fn solve(&self, goal: Goal, dt: f64) -> Solve<'_> {
        // By then the fluid's velocities have been changed by gravity and the first solve, the bodies' not yet.
        let after_gravity = goal == Goal::Density;
        let kind = self.solver.boundary_pressure;
        Solve {
            with: self.discretization,
            neighbours: &self.neighbours,
            boundary: &self.boundary,
            response: Response::new(&self.bodies, &self.boundary, self.particle_mass(), after_gravity),
            settings: goal.settings(&self.solver),
            wall: WallPressure::new(kind, &self.boundary, &self.extrapolation, after_gravity),
            relaxation: self.relaxation as f32,
            dt,
        }
    }

    /// New velocities and places; particles in bodies move out.
    fn advance(&mut self, dt: f64) {
        let Particles { positions, velocities, .. } = &mut self.particles;
        let all = positions.par_iter_mut().zip(velocities).zip(&self.fields.velocities).with_min_len(CHUNK);
        all.for_each(|((position, velocity), &[x, y, z, _])| {
            *velocity = [x, y, z];
            *position += dt * DVec3::new(x.into(), y.into(), z.into());
        });
        let shifts = positions.par_iter_mut().zip(&self.fields.shifts).with_min_len(CHUNK);
        shifts.for_each(|(position, &[x, y, z, _])| *position += DVec3::new(x.into(), y.into(), z.into()));
        let (particle_radius, particle_mass) = (self.world.particle_radius, self.particle_mass());
        let Simulation { bodies, body_forces, boundary, particles, .. } = self;
        strays::ease(particles, boundary.pressed(), particle_radius);
        let mut strays = Strays { bodies, body_forces, particle_radius, particle_mass, dt };
        strays.bring_back(particles, boundary.inside());
    }

    fn sort(&mut self) {
        self.cells.sort(&self.particles.positions, self.world.support_radius, &mut self.order);
        self.particles.reorder(&self.order, &mut self.spare);
    }

    /// Parts particles that lie in each other, now and then.
    fn part_fused(&mut self, dt: f64) {
        if !fused::is_due(self.step) {
            return;
        }
        let spacing = self.world.rest_spacing(&self.fluid);
        let Simulation { bodies, cells, particles, world, .. } = self;
        let pairs = fused::Pairs { cells, bodies, spacing, dimension: world.dimension };
        if pairs.part(particles, dt) > 0 {
            self.sort();
        }
    }

    fn max_speed(&self) -> f64 {
        let square = |v: &[f32; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        // Not a number must not be overlooked.
        let larger = |a: f32, b: f32| if a.is_nan() || a > b { a } else { b };
        let fluid = self.particles.velocities.par_iter().map(square).reduce(|| 0.0, larger);
        if fluid.is_nan() { f64::NAN } else { f64::from(fluid.sqrt()).max(self.body_speed) }
    }

    /// Volume V of a particle, m^3; in two dimensions area, m^2.
    pub fn particle_volume(&self) -> f64 {
        self.world.particle_volume(&self.fluid)
    }

    /// Mass of a particle, kg; in two dimensions kg/m.
    pub fn particle_mass(&self) -> f64 {
        self.fluid.rest_density * self.particle_volume()
    }

    /// Time simulated, seconds.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// The fluid.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// What it touches.
    pub fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// The fluid's force (N) on each body in the last step, and its torque (N m) about the centre of mass; if no body
    /// is free, by drag alone.
    pub fn body_forces(&self) -> &[[DVec3; 2]] {
        &self.body_forces
    }

    /// Boundary particles of all bodies; none where there are maps.
    pub fn boundary_particles(&self) -> usize {
        self.boundary.particle_count()
    }

    /// Mean number of neighbours in the last step.
    pub fn mean_neighbours(&self) -> f64 {
        self.neighbours.entries() as f64 / self.particles.len().max(1) as f64
    }

    /// Relative densities D = rho / rho_0 at the beginning of the last step; 1 before the first.
    pub fn densities(&self) -> &[f32] {
        &self.fields.densities
    }

    /// Pressures of the density solve, Pa; see [`World::pressure_scale`].
    pub fn pressures(&self) -> Vec<f32> {
        let density = (self.fluid.rest_density * self.world.pressure_scale(&self.fluid)) as f32;
        let all = self.particles.pressures.iter().zip(&self.fields.densities);
        all.map(|(pressure, relative)| density * relative * relative * pressure).collect()
    }

    /// What the particles saw of the bodies in the last step.
    pub fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    /// Puts the particles elsewhere: from a particle's name to its position (metres) and velocity (m/s).
    pub fn place(&mut self, at: impl Fn(u32) -> (DVec3, [f32; 3])) {
        let Particles { positions, velocities, ids, .. } = &mut self.particles;
        for ((position, velocity), &id) in positions.iter_mut().zip(velocities).zip(&*ids) {
            (*position, *velocity) = at(id);
        }
    }

    /// What adds to the fluid.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Largest speed of a body where it touched the fluid in the last step, m/s.
    pub fn body_speed(&self) -> f64 {
        self.body_speed
    }

    /// Lowest and highest corner of the box that particles must not leave, metres.
    pub fn domain(&self) -> [DVec3; 2] {
        self.domain
    }

    pub(crate) fn is_in_domain(&self, x: DVec3) -> bool {
        strays::is_within(x, self.domain)
    }

    /// Bytes held by particles and lists.
    pub fn memory_bytes(&self) -> usize {
        let lists =
            self.neighbours.memory_bytes() + self.extrapolation.memory_bytes() + self.forces.memory_bytes();
        lists + self.boundary.memory_bytes() + 2 * self.particles.memory_bytes() + self.fields.memory_bytes()
    }
}

/// Checks the forces, and gives the particles the channels that they need.
fn prepare(forces: &Forces, particles: &mut Particles) -> Result<(), Error> {
    for force in forces.iter() {
        let refuse =
            |key: &str, reason| Error::Setup { place: format!("forces.{}{key}", force.name()), reason };
        force.check().map_err(|defect| refuse(&format!(".{}", defect.key), defect.reason))?;
        for channel in force.channels() {
            let count = particles.len();
            particles.channels.declare(channel, count).map_err(|reason| refuse("", reason))?;
        }
    }
    Ok(())
}
