//! Fluid that begins at rest without a lattice: its particles are spread until the density is that of rest everywhere,
//! up to walls and bodies, and then let settle until the pressures are those of their depth.
//!
//! Both are done by the solver itself, with the scene's own method and settings, before time 0, bodies held where they
//! are:
//!
//! - [`spread`]: without gravity. Velocities are set to 0 after each step, so that what moves is only what is too
//!   dense, into what is not dense enough. The particles must be as many as the space holds; then nothing is left
//!   empty. If that was estimated too high, the densest are left out until all are at rest.
//! - [`settle`]: with gravity. Only what gravity moves in a single step is let happen, until the pressures change no
//!   more. A solve stops at its tolerance, so a fluid without pressures takes tens of steps to build them, in which it
//!   falls and its bodies with it.
//!
//! Nothing is left to chance: the same particles give the same bits, on any number of threads.

use crate::bodies::{Bodies, BodyDescription, Motion};
use crate::compression::Compression;
use crate::error::Error;
use crate::particles::Particles;
use crate::settings::{FluidSettings, SolverSettings, ViscosityMethod, World};
use crate::setup::Setup;
use crate::simulation::Simulation;
use std::ops::Range;
use volmap_bake::watch::Watch;
use volmap_runtime::DVec3;

/// What particles are packed by.
#[derive(Clone, Copy)]
pub struct Packing<'a> {
    /// The scene's world; its gravity counts for [`settle`] only.
    pub world: &'a World,
    /// The fluid.
    pub fluid: &'a FluidSettings,
    /// The scene's solver.
    pub solver: &'a SolverSettings,
    /// Stops it.
    pub watch: &'a Watch,
}

/// What came of it.
#[derive(Clone, Debug, Default)]
pub struct Packed {
    /// Which of the particles that were given are left, in ascending order.
    pub kept: Vec<u32>,
    /// Their places, metres.
    pub positions: Vec<DVec3>,
    /// [`Particles::pressures`]; 0 after [`spread`].
    pub pressures: Vec<f32>,
    /// How much denser than at rest it is.
    pub compression: Compression,
    /// Steps taken.
    pub steps: u32,
}

/// Steps of each part at most.
const MOST_SPREADING: u32 = 800;
const MOST_SETTLING: u32 = 300;
/// Particles are at rest when they are too dense by this part, in the mean and at most.
const AT_REST: [f64; 2] = [5e-4, 1e-2];
/// Particles that aren't at rest after so many steps are too many.
const PATIENCE: u32 = 100;
/// The solve of a step of spreading goes so far: a shell that has to be filled is a small part of all.
const SPREADING_ERROR: f64 = 1e-5;
const SPREADING_ITERATIONS: [u32; 2] = [8, 40];
/// Pressures are those of the depth when their sum changes by less than this part in so many steps.
const STEADY: f64 = 5e-3;
const WINDOW: u32 = 20;

/// Spreads particles over the space between bodies that are held.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::step`].
pub fn spread(packing: Packing, bodies: Vec<BodyDescription>, positions: &[DVec3]) -> Result<Packed, Error> {
    let mut solver = SolverSettings { warm_start: 0.0, ..packing.solver.clone() };
    solver.divergence.enabled = false;
    solver.density.enabled = true;
    solver.density.max_error = SPREADING_ERROR;
    [solver.density.min_iterations, solver.density.max_iterations] = SPREADING_ITERATIONS;
    let world = World { gravity: DVec3::ZERO, ..packing.world.clone() };
    let mut simulation = begin(packing, world, solver, bodies, positions)?;
    let (mut steps, mut since) = (0, 0);
    while steps < MOST_SPREADING {
        let found = step(packing, &mut simulation)?;
        (steps, since) = (steps + 1, since + 1);
        if found.mean <= AT_REST[0] && found.largest <= AT_REST[1] {
            break;
        }
        if since >= PATIENCE {
            let excess = found.mean * simulation.particles().len() as f64;
            leave_out_densest(&mut simulation, excess.ceil() as usize);
            since = PATIENCE / 2;
        }
    }
    Ok(packed(&simulation, steps))
}

/// Removes so many particles, the densest ones; of equal ones those that came first.
fn leave_out_densest(simulation: &mut Simulation, count: usize) {
    let (densities, ids) = (simulation.densities(), &simulation.particles().ids);
    let mut order: Vec<usize> = (0..ids.len()).collect();
    order.sort_by(|&a, &b| densities[b].total_cmp(&densities[a]).then(ids[a].cmp(&ids[b])));
    let mut names: Vec<u32> = order.iter().take(count).map(|&n| ids[n]).collect();
    names.sort_unstable();
    simulation.remove(|id| names.binary_search(&id).is_ok());
}

/// Lets particles settle under gravity among bodies that are held.
///
/// # Errors
/// As [`spread`].
pub fn settle(packing: Packing, bodies: Vec<BodyDescription>, positions: &[DVec3]) -> Result<Packed, Error> {
    let mut simulation = begin(packing, packing.world.clone(), packing.solver.clone(), bodies, positions)?;
    let sum = |simulation: &Simulation| -> f64 {
        simulation.particles().pressures.iter().map(|&p| f64::from(p)).sum()
    };
    let (mut steps, mut before) = (0, 0.0);
    while steps < MOST_SETTLING {
        step(packing, &mut simulation)?;
        steps += 1;
        if steps % WINDOW == 0 {
            let now = sum(&simulation);
            if (now - before).abs() <= STEADY * now.abs() {
                break;
            }
            before = now;
        }
    }
    Ok(packed(&simulation, steps))
}

/// A fluid at rest without viscosity, all bodies held, steps of one length.
fn begin(
    packing: Packing,
    world: World,
    mut solver: SolverSettings,
    bodies: Vec<BodyDescription>,
    positions: &[DVec3],
) -> Result<Simulation, Error> {
    let time_step = &mut solver.time_step;
    if time_step.adaptive {
        time_step.initial = time_step.initial.clamp(time_step.min, time_step.max);
    }
    time_step.adaptive = false;
    let fluid = FluidSettings {
        viscosity: 0.0,
        viscosity_method: ViscosityMethod::Explicit,
        xsph: 0.0,
        ..packing.fluid.clone()
    };
    let held = |body: BodyDescription| BodyDescription {
        motion: Motion::Static,
        fluid_contact: Default::default(),
        ..body
    };
    let bodies = Bodies::new(bodies.into_iter().map(held).collect(), world.gravity)?;
    let mut particles = Particles::default();
    particles.add(positions, &vec![[0.0; 3]; positions.len()]);
    Simulation::new(Setup { fluid, solver, ..Setup::new(world, particles, bodies) })
}

/// A step, and no velocity after it.
fn step(packing: Packing, simulation: &mut Simulation) -> Result<Compression, Error> {
    packing.watch.check()?;
    let report = simulation.step()?;
    simulation.particles.velocities.fill([0.0; 3]);
    Ok(report.compression)
}

fn packed(simulation: &Simulation, steps: u32) -> Packed {
    let particles = simulation.particles();
    let mut order: Vec<usize> = (0..particles.len()).collect();
    order.sort_by_key(|&n| particles.ids[n]);
    Packed {
        kept: order.iter().map(|&n| particles.ids[n]).collect(),
        positions: order.iter().map(|&n| particles.positions[n]).collect(),
        pressures: order.iter().map(|&n| particles.pressures[n]).collect(),
        compression: Compression::of(simulation.densities(), &particles.positions),
        steps,
    }
}

impl Simulation {
    /// Before the first step: of the particles whose names are in a range, those that packing has kept are put where it
    /// has put them, with their pressures, and the others are removed. The first of the range is packing's first.
    pub fn take(&mut self, range: Range<u32>, packed: &Packed) {
        let found = |id: u32| packed.kept.binary_search(&(id - range.start));
        let Particles { positions, pressures, ids, .. } = &mut self.particles;
        for ((position, pressure), &id) in positions.iter_mut().zip(pressures).zip(&*ids) {
            if let Some(Ok(n)) = range.contains(&id).then(|| found(id)) {
                (*position, *pressure) = (packed.positions[n], packed.pressures[n]);
            }
        }
        self.remove(|id| range.contains(&id) && found(id).is_err());
    }

    /// Removes the particles of some names.
    fn remove(&mut self, is_one: impl Fn(u32) -> bool) {
        let densities = &mut self.fields.densities;
        self.particles.retain(densities, |particles, n| !is_one(particles.ids[n]));
    }
}
