//! Both pressure solves: CORRECT DIVERGENCE ERROR and CORRECT DENSITY ERROR of Band et al. 2018, Algorithm 1.
//!
//! Unknown is P = p / (rho_0 D^2), D = rho / rho_0, for each particle. A particle compresses itself by A = V sum (a_i -
//! a_j) . grad W_ij + a_i . grad rho_B / rho_0, for the accelerations a of Eq. 1; both solves look for P >= 0 so that
//! source + A <= 0, with equality where P > 0.
//!
//! The boundary's part of a is Eq. 15 of Bender et al. 2020. Its second term, the boundary's pressure, is left out
//! unless asked for ([`crate::boundary::pressure`]): without it, forces are the gradient of what is to be kept
//! constant, so that the solves take no energy from the boundary and give it none. The closure `mirror` has the
//! image's part in its gradient.

use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::boundary::pressure::{Pressures, Seen, WallPressure};
use crate::coupling::{self, Motions};
use crate::discretization::Discretization;
use crate::fields::Fields;
use crate::neighbours::Neighbours;
use crate::pairs::lists::Lists;
use crate::pairs::sums::{self, Room};
use crate::pairs::{Quad, workspace};
use crate::report::SolveReport;
use crate::response::Response;
use crate::settings::SolveSettings;
use rayon::prelude::*;

/// Factors times r^2 below this are those of particles without neighbours.
const SMALLEST_FACTOR: f32 = 1e-8;

/// Particles whose density is below this may be compressed: those at the surface, spray, and blocks that begin
/// loosely. Their divergence is left alone.
const SURFACE_DENSITY: f32 = 0.9;

/// A solve that ends at its limit of iterations with an error so many times that of its beginning has found nothing,
/// and must not throw the fluid about. None does whose forces are the gradient of the density; with pressures of the
/// boundary (`mirror`, `sph`, `mls`) some do.
const DIVERGED: f64 = 2.0;

/// How much of a density's error, in parts of the rest density, is corrected in a step. In a flow it is a tenth of
/// this; but particles that begin too close together, beside a rough wall or in each other, would be thrown apart at
/// once.
const MOST_CORRECTION: f32 = 0.01;

impl Fields {
    /// Solves for the pressures that keep the velocity from compressing the fluid; `accelerations` hold the answer.
    pub fn correct_divergence(&mut self, solve: &Solve) -> SolveReport {
        self.pressures.clear();
        self.pressures.resize(self.len(), 0.0);
        self.sources(solve, |density, rate, dt| (rate.max(0.0) / dt, density >= SURFACE_DENSITY));
        self.iterate(solve, true)
    }

    /// Solves for the pressures that bring the density back to rest; `accelerations` hold the answer.
    pub fn correct_density(&mut self, solve: &Solve) -> SolveReport {
        self.sources(solve, |density, rate, dt| (to_correct(density) / (dt * dt) + rate / dt, true));
        self.iterate(solve, false)
    }

    /// Solves for the pressures that keep the velocity from raising a density above that of rest; what is denser
    /// already only gets no denser. From the pressures that are there; `accelerations` hold the answer.
    pub(crate) fn hold_density(&mut self, solve: &Solve) -> SolveReport {
        let room = |density: f32| (density - 1.0).min(0.0);
        self.sources(solve, |density, rate, dt| (room(density) / (dt * dt) + rate / dt, true));
        self.iterate(solve, false)
    }

    /// The source of each particle, from its density, the rate at which the velocity raises it, and dt, and whether
    /// it takes part.
    fn sources(&mut self, solve: &Solve, source: impl Fn(f32, f32, f32) -> (f32, bool) + Sync) {
        self.sources.resize(self.len(), 0.0);
        self.steps.resize(self.len(), 0.0);
        self.begin_response(&solve.response);
        let (velocities, dt) = (&self.velocities, solve.dt as f32);
        let least = SMALLEST_FACTOR / (solve.with.support_radius * solve.with.support_radius) as f32;
        let (densities, factors, gradients) = (&self.densities, &self.factors, &self.gradients);
        let (wall_rates, body_flux, body_factors) = (&self.wall_rates, &self.body_flux, &self.body_factors);
        let starts = solve.neighbours.split(&mut self.pressures);
        let steps = solve.neighbours.split(&mut self.steps).into_par_iter().zip(starts);
        let blocks = solve.neighbours.with(&mut self.sources).zip(steps).enumerate();
        blocks.for_each(|(block, ((lists, sources), (steps, starts)))| {
            flux(lists, velocities, gradients, sources);
            steps.copy_from_slice(&factors[lists.particles()]);
            if !body_flux.is_empty() {
                let bodies = body_flux[lists.particles()].iter().zip(&body_factors[lists.particles()]);
                for ((source, step), (known, bound)) in sources.iter_mut().zip(&mut *steps).zip(bodies) {
                    *source -= dt * known;
                    *step += bound;
                }
            }
            let of_fluid = solve.wall.is_more_than_own().then_some(Seen { densities, factors, gradients });
            if let Some(seen) = of_fluid {
                solve.wall.add_bounds(solve.boundary, block, lists.first, seen, steps);
            }
            let own = densities[lists.particles()].iter().zip(&wall_rates[lists.particles()]);
            for ((out, step), (density, wall)) in sources.iter_mut().zip(&mut *steps).zip(own) {
                let (source, takes_part) = source(*density, *out - wall, dt);
                // A particle alone can't be compressed.
                *step = if takes_part && *step > least { solve.relaxation / *step } else { 0.0 };
                *out = if takes_part { source } else { 0.0 };
            }
            let of_error = |density: f32| source(density, 0.0, dt).0;
            for pressed in solve.boundary.pressed_of_block(block) {
                let (particle, within) = (pressed.particle as usize, pressed.particle as usize - lists.first);
                let (factor, density, step) = (factors[particle], densities[particle], &mut steps[within]);
                if *step > 0.0 {
                    let compliance = pressed.compliance(factor, density, dt);
                    *step = solve.relaxation / (solve.relaxation / *step + compliance);
                    sources[within] += pressed.left_of_error(density, of_error) - of_error(density);
                }
            }
            // What pressed in the last step, and doesn't in this one, must not push.
            for (start, (source, step)) in starts.iter_mut().zip(sources.iter().zip(&*steps)) {
                *start = if *source > 0.0 && *step > 0.0 { *start } else { 0.0 };
            }
        });
    }

    /// Relaxed Jacobi steps until the mean error is small, from the pressures that are there, which may be zero.
    fn iterate(&mut self, solve: &Solve, from_zero: bool) -> SolveReport {
        let mut report = SolveReport::default();
        let mut first = None;
        loop {
            report.error = if from_zero && report.iterations == 0 {
                self.relax_from_zero(solve)
            } else {
                self.accelerate_by_pressure(solve);
                self.respond(solve);
                self.relax(solve)
            };
            report.iterations += 1;
            let good = report.error <= solve.settings.max_error;
            if good && report.iterations >= solve.settings.min_iterations
                || report.iterations >= solve.settings.max_iterations
            {
                if report.error > DIVERGED * *first.get_or_insert(report.error) + solve.settings.max_error {
                    self.give_up();
                }
                return report;
            }
            first.get_or_insert(report.error);
            std::mem::swap(&mut self.pressures, &mut self.next_pressures);
        }
    }

    /// Without pressures: those that were found are worse than none.
    fn give_up(&mut self) {
        self.pressures.fill(0.0);
        self.site_pressures.fill(0.0);
        self.accelerations.fill([0.0; 4]);
    }

    /// The first Jacobi step from pressures of zero, which accelerate nothing; the mean error.
    fn relax_from_zero(&mut self, solve: &Solve) -> f64 {
        solve.wall.at_sites(&self.pressures, &mut self.site_pressures);
        self.accelerations.fill([0.0; 4]);
        let (pressures, sources, steps) = (&self.pressures, &self.sources, &self.steps);
        self.next_pressures.resize(pressures.len(), 0.0);
        let blocks = solve.neighbours.with(&mut self.next_pressures);
        let of_block = |(lists, out): (&Lists, &mut [f32])| {
            let all = lists.particles();
            out.fill(0.0);
            step_by(out, &pressures[all.clone()], &sources[all.clone()], &steps[all])
        };
        let errors: Vec<f64> = blocks.map(of_block).collect();
        errors.iter().sum::<f64>() * solve.dt * solve.dt / pressures.len().max(1) as f64
    }

    /// What the free bodies' known accelerations are to each particle, and what giving way adds to its factor.
    fn begin_response(&mut self, response: &Response) {
        self.body_flux.clear();
        self.body_factors.clear();
        if !response.is_empty() {
            self.body_flux.resize(self.len(), 0.0);
            self.body_factors.resize(self.len(), 0.0);
            response.add_known(&mut self.body_flux);
            response.add_bounds(&mut self.body_factors);
        }
    }

    /// What the free bodies' accelerations by the pressures are to each particle.
    fn respond(&mut self, solve: &Solve) {
        if !solve.response.is_empty() {
            let mut body_flux = std::mem::take(&mut self.body_flux);
            body_flux.fill(0.0);
            let pressures = self.all_pressures();
            solve.response.add_response(|contact| solve.wall.factor(pressures, contact), &mut body_flux);
            self.body_flux = body_flux;
        }
    }

    /// Accelerations by the pressures: Eq. 1 of Band et al. with the boundary's part as Eq. 15 of Bender et al.
    pub(crate) fn accelerate_by_pressure(&mut self, solve: &Solve) {
        solve.wall.at_sites(&self.pressures, &mut self.site_pressures);
        let mut accelerations = std::mem::take(&mut self.accelerations);
        let (all, gradients) = (self.all_pressures(), &self.gradients);
        solve.neighbours.with(&mut accelerations).enumerate().for_each(|(block, (lists, out))| {
            workspace::work(lists, |workspace| {
                workspace.numbers.fill(lists.table(), all.fluid);
                let (own, gradients) = (&all.fluid[lists.particles()], &gradients[lists.particles()]);
                let room = Room { sums: &mut workspace.sums, out };
                sums::accelerations(lists, &workspace.numbers, own, gradients, room);
            });
            solve.wall.accelerate(solve.boundary, block, lists.first, all, out);
        });
        self.accelerations = accelerations;
    }

    /// Pressures of fluid and boundary in this iteration.
    pub(crate) fn all_pressures(&self) -> Pressures<'_> {
        Pressures { fluid: &self.pressures, densities: &self.densities, sites: &self.site_pressures }
    }

    /// A Jacobi step into `next_pressures`; the mean error of the pressures before it.
    fn relax(&mut self, solve: &Solve) -> f64 {
        let (accelerations, gradients) = (&self.accelerations, &self.gradients);
        let (pressures, body_flux) = (&self.pressures, &self.body_flux);
        let (sources, steps) = (&self.sources, &self.steps);
        let (factors, densities, dt) = (&self.factors, &self.densities, solve.dt as f32);
        self.next_pressures.resize(pressures.len(), 0.0);
        let blocks = solve.neighbours.with(&mut self.next_pressures).enumerate();
        let errors: Vec<f64> = blocks
            .map(|(block, (lists, out))| {
                flux(lists, accelerations, gradients, out);
                if !body_flux.is_empty() {
                    for (change, bodies) in out.iter_mut().zip(&body_flux[lists.particles()]) {
                        *change -= bodies;
                    }
                }
                for pressed in solve.boundary.pressed_of_block(block) {
                    let particle = pressed.particle as usize;
                    let compliance = pressed.compliance(factors[particle], densities[particle], dt);
                    out[particle - lists.first] -= compliance * pressures[particle];
                }
                step_by(
                    out,
                    &pressures[lists.particles()],
                    &sources[lists.particles()],
                    &steps[lists.particles()],
                )
            })
            .collect();
        errors.iter().sum::<f64>() * solve.dt * solve.dt / pressures.len().max(1) as f64
    }
}

/// The errors of a block, some thousands at most, are summed up in as many parts, so that several are added at once.
const PARTS: usize = 8;

/// What of a density's error a step corrects.
pub(crate) fn to_correct(density: f32) -> f32 {
    (density - 1.0).min(MOST_CORRECTION)
}

/// A Jacobi step of a block's particles: `out` has what their pressures compress, and gets the new ones. The sum of
/// the errors.
fn step_by(out: &mut [f32], pressures: &[f32], sources: &[f32], steps: &[f32]) -> f64 {
    let mut sums = [0.0; PARTS];
    let chunks = out.chunks_mut(PARTS).zip(pressures.chunks(PARTS));
    for ((out, pressures), (sources, steps)) in chunks.zip(sources.chunks(PARTS).zip(steps.chunks(PARTS))) {
        for n in 0..out.len() {
            let error = sources[n] + out[n];
            out[n] = (pressures[n] + steps[n] * error).max(0.0);
            sums[n] += if steps[n] > 0.0 { error.max(0.0) } else { 0.0 };
        }
    }
    sums.into_iter().map(f64::from).sum()
}

/// How fast a vector field compresses the particles of a block: the sum of V (u_i - u_j) . grad W_ij + u_i . grad
/// rho_B / rho_0, which is dD/dt for a velocity among bodies at rest.
fn flux(lists: &Lists, field: &[Quad], gradients: &[Quad], out: &mut [f32]) {
    workspace::work(lists, |workspace| {
        workspace.vectors.fill(lists.table(), field);
        let (own, gradients) = (&field[lists.particles()], &gradients[lists.particles()]);
        let room = Room { sums: &mut workspace.fluxes, out };
        sums::fluxes(lists, &workspace.vectors, own, gradients, room);
    });
}

/// Force and torque about the centre of mass of each body by a solve's pressures; zero if no body is free. `mass` is a
/// particle's, kg.
pub fn forces_on_bodies(bodies: &Bodies, fields: &Fields, solve: &Solve, mass: f64) -> Motions {
    let free = (0..bodies.posed().len()).any(|body| bodies.is_free(body));
    let contacts = solve.boundary.contacts().filter(|_| free);
    let pressures = fields.all_pressures();
    coupling::sum(bodies, contacts, |contact| solve.wall.factor(pressures, contact), mass)
}

/// What a solve works on.
pub struct Solve<'a> {
    /// The kernel's sums.
    pub with: Discretization,
    /// Who is near whom.
    pub neighbours: &'a Neighbours,
    /// What of the boundary is near.
    pub boundary: &'a Boundary,
    /// How free bodies give way.
    pub response: Response<'a>,
    /// When to stop.
    pub settings: &'a SolveSettings,
    /// The boundary's pressure.
    pub wall: WallPressure<'a>,
    /// Relaxation of the Jacobi steps, omega.
    pub relaxation: f32,
    /// Time step, seconds.
    pub dt: f64,
}
