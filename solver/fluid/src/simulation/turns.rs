//! Implicit viscosity and pressure in turns, until they agree. If each were solved for once, the viscous solve would
//! see the weight of a stiff fluid without the pressure that carries it, and the density solve would carry it as that
//! of a fluid without viscosity, which falls apart: a stiff block would sink by itself, and slide off a wall.
//!
//! After van Kan 1986, *A Second-Order Accurate Pressure-Correction Scheme for Viscous Incompressible Flow*: the
//! viscous solve sees the accelerations by the pressures of the last step, or of the last pass, among this step's
//! neighbours; the density solve goes on from these pressures.
//! ```text
//! v* = viscous solve of v0 + dt a(p),   p' = density solve of v* - dt a(p), from p,   v = v* + dt (a(p') - a(p))
//! ```
//! again with p' for p, until the last term, which viscosity didn't see, is small. Where that takes too many passes, or
//! the viscous solve ends at its limit, what is left of it may add energy: then both are done once more, one after the
//! other from p = 0, which never does.
//!
//! That density solve lets no density grow. A fluid that is too dense already is taken apart by changes of places
//! alone: as velocities, they would be the whole block's, for viscosity spreads them, and nothing would end them.

use super::{Goal, Simulation};
use crate::coupling::Motions;
use crate::fields;
use crate::forces::implicit_viscosity::CHANGES;
use crate::forces::viscosity::viscous_weights;
use crate::pairs::Quad;
use crate::pressure::forces_on_bodies;
use crate::report::SolveReport;
use crate::settings::ViscositySolveSettings;
use volmap_runtime::DVec3;

/// Velocities by pressures that viscosity didn't see, in parts of how the velocities change in the step, at which both
/// solves agree.
const AGREES: f64 = 0.05;

/// Energy that a step may add where they don't agree, in parts of what the fluid gets in a fall of a support radius: of
/// a stiff block at rest, whose pressures a viscous solve at its limit sees a little wrong, as much is there and gone.
const SMALL_GROWTH: f64 = 5e-4;

/// How the solves of a step went.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turns {
    /// How often both were done.
    pub passes: u32,
    /// Iterations of all, and the last error.
    pub viscosity: SolveReport,
    /// The same.
    pub density: SolveReport,
    /// Whether they didn't agree in time.
    pub is_one_after_the_other: bool,
}

/// What a pass begins with.
struct Begin {
    /// Velocities before all forces.
    before: Vec<Quad>,
    /// With those by the explicit ones.
    start: Vec<Quad>,
}

/// What a pass leaves.
struct Pass {
    /// The accelerations by pressures that it began with.
    predicted: Vec<Quad>,
    /// What the viscous solve pushes the bodies with.
    on_bodies: Motions,
}

impl Simulation {
    /// Whether viscosity and pressure are solved for in turns: where the step is longer than explicit viscosity would
    /// allow. In thinner fluids, viscosity does little in a step, and what it does needn't wait for the pressures.
    pub(super) fn is_in_turns(&self, dt: f64) -> bool {
        let [_, implicit] = self.fluid.viscosities();
        self.solver.density.enabled && dt * implicit * viscous_weights(&self.world) > 1.0
    }

    /// All forces and the density solve.
    pub(super) fn solve_in_turns(&mut self, dt: f64) -> Turns {
        let before = self.fields.velocities.clone();
        self.add_explicit(dt);
        let begin = Begin { before, start: self.fields.velocities.clone() };
        let fall = self.world.gravity.length() * self.world.support_radius;
        let mass = self.particle_mass() * self.particles.len() as f64;
        let (mut turns, most) = (Turns::default(), self.energy(dt) + SMALL_GROWTH * mass * fall);
        let mut push = self.predict(dt);
        self.stages.end(|stages| &mut stages.non_pressure);
        loop {
            let pass = self.pass(&begin, &mut push, &mut turns, dt);
            let can_go_on = turns.can_go_on(&self.solver.viscosity);
            if turns.is_one_after_the_other
                || self.agrees(&begin, &pass.predicted, dt)
                || !can_go_on && self.energy(dt) <= most
            {
                break;
            }
            self.push(&opposite(&push));
            self.push(&opposite(&pass.on_bodies));
            if !can_go_on {
                turns.is_one_after_the_other = true;
                self.fields.accelerations.fill([0.0; 4]);
                push.fill([DVec3::ZERO; 2]);
            }
            self.begin_where_this_ended(&pass.predicted, dt);
        }
        self.particles.pressures.copy_from_slice(&self.fields.pressures);
        let report = self.shift(dt);
        turns.density.iterations += report.iterations;
        turns.density.error = turns.density.error.max(report.error);
        self.stages.end(|stages| &mut stages.pressure);
        turns
    }

    /// Accelerations by the last step's pressures; what they push the bodies with.
    fn predict(&mut self, dt: f64) -> Motions {
        let mut fields = std::mem::take(&mut self.fields);
        fields.set_pressures(&self.particles.pressures, 1.0);
        let solve = self.solve(Goal::Density, dt);
        fields.accelerate_by_pressure(&solve);
        let push = forces_on_bodies(&self.bodies, &fields, &solve, self.particle_mass());
        self.fields = fields;
        push
    }

    /// Both solves, with the accelerations that the fields have and `push` as the pressures'; both become those that
    /// come of it.
    fn pass(&mut self, begin: &Begin, push: &mut Motions, turns: &mut Turns, dt: f64) -> Pass {
        let predicted = self.fields.accelerations.clone();
        self.fields.velocities.copy_from_slice(&begin.start);
        fields::accelerate(&mut self.fields.velocities, &predicted, dt);
        self.push(push);
        let solved = self.solve_implicit(dt);
        self.push(&opposite(push));
        self.push(&solved.on_bodies);
        fields::accelerate(&mut self.fields.velocities, &predicted, -dt);
        self.stages.end(|stages| &mut stages.non_pressure);
        let report = self.hold_density(dt, push);
        self.push(push);
        turns.add(solved.report, report);
        self.stages.end(|stages| &mut stages.pressure);
        Pass { predicted, on_bodies: solved.on_bodies }
    }

    /// Kinetic energy of fluid and free bodies at the end of the step, by all that acts on them so far.
    fn energy(&self, dt: f64) -> f64 {
        let square = |v: &Quad| (0..3).map(|n| f64::from(v[n]).powi(2)).sum::<f64>();
        let fluid = 0.5 * self.particle_mass() * self.fields.velocities.iter().map(square).sum::<f64>();
        let bodies =
            (0..self.bodies.posed().len()).map(|body| self.bodies.energy_after(body, dt)).sum::<f64>();
        fluid + bodies
    }

    fn hold_density(&mut self, dt: f64, push: &mut Motions) -> SolveReport {
        let mut fields = std::mem::take(&mut self.fields);
        let solve = self.solve(Goal::Density, dt);
        let report = fields.hold_density(&solve);
        *push = forces_on_bodies(&self.bodies, &fields, &solve, self.particle_mass());
        fields::accelerate(&mut fields.velocities, &fields.accelerations, dt);
        self.fields = fields;
        report
    }

    /// Whether viscosity would change little of what the density solve added.
    fn agrees(&self, begin: &Begin, predicted: &[Quad], dt: f64) -> bool {
        let square = |a: &Quad, b: &Quad| (0..3).map(|n| f64::from(a[n] - b[n]).powi(2)).sum::<f64>();
        let sum = |a: &[Quad], b: &[Quad]| a.iter().zip(b).map(|(a, b)| square(a, b)).sum::<f64>();
        let added = dt * dt * sum(&self.fields.accelerations, predicted);
        let changed = sum(&self.fields.velocities, &begin.before) + sum(&begin.start, &begin.before);
        added <= AGREES * AGREES * changed
    }

    /// The next viscous solve begins with the velocities that this one found, though it sees other pressures.
    fn begin_where_this_ended(&mut self, predicted: &[Quad], dt: f64) {
        let changes = self.particles.channels.vectors_mut(CHANGES.name);
        for ((change, now), then) in changes.iter_mut().zip(&self.fields.accelerations).zip(predicted) {
            for axis in 0..3 {
                change[axis] -= dt as f32 * (now[axis] - then[axis]);
            }
        }
    }

    /// The ways that bring the density back to rest.
    fn shift(&mut self, dt: f64) -> SolveReport {
        let mut fields = std::mem::take(&mut self.fields);
        fields.pressures.fill(0.0);
        let mut solve = self.solve(Goal::Density, dt);
        solve.response = solve.response.held();
        let report = fields.correct_density(&solve);
        let way = |a: &Quad| a.map(|a| (dt * dt) as f32 * a);
        fields.shifts.clear();
        fields.shifts.extend(fields.accelerations.iter().map(way));
        fields.pressures.copy_from_slice(&self.particles.pressures);
        self.fields = fields;
        report
    }
}

impl Turns {
    /// Whether another pass may bring them to agree.
    fn can_go_on(&self, settings: &ViscositySolveSettings) -> bool {
        self.passes < settings.max_passes && self.viscosity.error <= settings.max_error
    }

    fn add(&mut self, viscosity: SolveReport, density: SolveReport) {
        self.passes += 1;
        self.viscosity.iterations += viscosity.iterations;
        self.viscosity.error = viscosity.error;
        self.density.iterations += density.iterations;
        self.density.error = density.error;
    }
}

fn opposite(motions: &[[DVec3; 2]]) -> Motions {
    motions.iter().map(|[push, turn]| [-*push, -*turn]).collect()
}
