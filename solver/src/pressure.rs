//! Both pressure solves: CORRECT DIVERGENCE ERROR and CORRECT DENSITY ERROR of Band et al. 2018, Algorithm 1.
//!
//! Unknown is P = p / (rho_0 D^2), D = rho / rho_0, for each particle. A particle compresses itself by A = V sum (a_i -
//! a_j) . grad W_ij + a_i . grad rho_B / rho_0, for the accelerations a of Eq. 1; both solves look for P >= 0 so that
//! source + A <= 0, with equality where P > 0.
//!
//! The boundary's part of a is Eq. 15 of Bender et al. 2020. Its second term, the boundary's pressure, is left out unless
//! asked for ([`crate::boundary::pressure`]): without it, forces are the gradient of what is to be kept constant, so that
//! the solves take no energy from the boundary and give it none. The closure `mirror` has the image's part in its gradient.

use crate::boundary::Boundary;
use crate::boundary::pressure::{Pressures, WallPressure};
use crate::fields::{Discretization, Fields};
use crate::neighbours::{CHUNK, Neighbours};
use crate::pairs::lanes::Quad;
use crate::response::Response;
use crate::settings::SolveSettings;
use rayon::prelude::*;

/// Factors times r^2 below this are those of particles without neighbours.
const SMALLEST_FACTOR: f32 = 1e-8;

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Jacobi steps.
    pub iterations: u32,
    /// Mean error left, in parts of the rest density.
    pub error: f64,
}

/// Particles whose density is below this may be compressed: those at the surface, spray, and blocks that begin loosely. Their
/// divergence is left alone.
const SURFACE_DENSITY: f32 = 0.9;

/// How much of a density's error, in parts of the rest density, is corrected in a step. In a flow it is a tenth of this; but
/// particles that begin too close together, beside a rough wall or in each other, would be thrown apart at once.
const MOST_CORRECTION: f32 = 0.01;

impl Fields {
    /// Solves for the pressures that keep the velocity from compressing the fluid; `accelerations` hold the answer.
    pub fn correct_divergence(&mut self, solve: &Solve) -> SolveReport {
        self.sources(solve, |density, rate, dt| (density >= SURFACE_DENSITY).then_some(rate.max(0.0) / dt));
        self.iterate(solve)
    }

    /// Solves for the pressures that bring the density back to rest; `accelerations` hold the answer.
    pub fn correct_density(&mut self, solve: &Solve) -> SolveReport {
        let error = |density: f32| (density - 1.0).min(MOST_CORRECTION);
        self.sources(solve, |density, rate, dt| Some(error(density) / (dt * dt) + rate / dt));
        self.iterate(solve)
    }

    /// The source of each particle, from its density, the rate at which the velocity raises it, and dt; one without
    /// takes no part.
    fn sources(&mut self, solve: &Solve, source: impl Fn(f32, f32, f32) -> Option<f32> + Sync) {
        self.sources.resize(self.len(), 0.0);
        self.steps.resize(self.len(), 0.0);
        self.begin_response(&solve.response);
        let (pairs, velocities, dt) = (solve.with.pairs(&self.places), &self.velocities, solve.dt as f32);
        let least = SMALLEST_FACTOR / (solve.with.support_radius * solve.with.support_radius) as f32;
        let (densities, factors) = (&self.densities, &self.factors);
        let (body_flux, body_factors) = (&self.body_flux, &self.body_factors);
        let chunks = self.sources.par_chunks_mut(CHUNK).zip(self.steps.par_chunks_mut(CHUNK));
        chunks.zip(solve.neighbours.chunks()).for_each(|((sources, steps), lists)| {
            pairs.flux(lists, velocities, sources);
            for within in 0..sources.len() {
                let particle = lists.first + within;
                let wall = &solve.boundary.of_particle[particle];
                let [known, bound] =
                    [body_flux, body_factors].map(|all| all.get(particle).copied().unwrap_or(0.0));
                let rate =
                    sources[within] + dot(velocities[particle], wall.gradient) - wall.flux - dt * known;
                let (source, factor) = (source(densities[particle], rate, dt), factors[particle] + bound);
                sources[within] = source.unwrap_or(0.0);
                // A particle alone can't be compressed.
                let takes_part = source.is_some() && factor > least;
                steps[within] = if takes_part { solve.relaxation / factor } else { 0.0 };
            }
        });
    }

    /// Relaxed Jacobi steps until the mean error is small; pressures begin as the fourth numbers of the places.
    fn iterate(&mut self, solve: &Solve) -> SolveReport {
        let mut report = SolveReport::default();
        loop {
            self.accelerate_by_pressure(solve);
            self.respond(solve);
            report.error = self.relax(solve);
            report.iterations += 1;
            let good = report.error <= solve.settings.max_error;
            if good && report.iterations >= solve.settings.min_iterations
                || report.iterations >= solve.settings.max_iterations
            {
                return report;
            }
            std::mem::swap(&mut self.places, &mut self.next_places);
        }
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
            let pressures = self.pressures();
            solve.response.add_response(|contact| solve.wall.factor(pressures, contact), &mut body_flux);
            self.body_flux = body_flux;
        }
    }

    /// Accelerations by the pressures: Eq. 1 of Band et al. with the boundary's part as Eq. 15 of Bender et al.
    fn accelerate_by_pressure(&mut self, solve: &Solve) {
        solve.wall.at_sites(&self.places, &mut self.site_pressures);
        let mut accelerations = std::mem::take(&mut self.accelerations);
        let (pairs, pressures) = (solve.with.pairs(&self.places), self.pressures());
        let chunks = accelerations.par_chunks_mut(CHUNK).zip(solve.neighbours.chunks()).enumerate();
        chunks.for_each(|(chunk, (out, lists))| {
            let mut sums = [[0.0; 3]; CHUNK];
            let sums = &mut sums[..lists.len()];
            pairs.acceleration(lists, sums);
            solve.wall.accelerate(solve.boundary, chunk, pressures, sums);
            for (out, &mut [x, y, z]) in out.iter_mut().zip(sums) {
                *out = [x, y, z, 0.0];
            }
        });
        self.accelerations = accelerations;
    }

    /// Pressures of fluid and boundary in this iteration.
    pub(crate) fn pressures(&self) -> Pressures<'_> {
        Pressures { places: &self.places, densities: &self.densities, sites: &self.site_pressures }
    }

    /// A Jacobi step into `next_places`; the mean error of the pressures before it.
    fn relax(&mut self, solve: &Solve) -> f64 {
        let pairs = solve.with.pairs(&self.places);
        let (places, accelerations) = (&self.places, &self.accelerations);
        let (sources, steps, body_flux) = (&self.sources, &self.steps, &self.body_flux);
        self.next_places.resize(places.len(), [0.0; 4]);
        let last = places.len() - 1;
        self.next_places[last] = places[last];
        let chunks = self.next_places[..last].par_chunks_mut(CHUNK).zip(solve.neighbours.chunks());
        let errors: Vec<f64> = chunks
            .map(|(out, lists)| {
                let mut change = [0.0; CHUNK];
                let change = &mut change[..lists.len()];
                pairs.flux(lists, accelerations, change);
                let mut sum = 0.0;
                for (within, (out, change)) in out.iter_mut().zip(change).enumerate() {
                    let particle = lists.first + within;
                    let wall = solve.boundary.of_particle[particle].gradient;
                    let bodies = body_flux.get(particle).copied().unwrap_or(0.0);
                    let error = sources[particle] + *change + dot(accelerations[particle], wall) - bodies;
                    let [x, y, z, pressure] = places[particle];
                    *out = [x, y, z, (pressure + steps[particle] * error).max(0.0)];
                    if steps[particle] > 0.0 {
                        sum += f64::from(error.max(0.0));
                    }
                }
                sum
            })
            .collect();
        errors.iter().sum::<f64>() * solve.dt * solve.dt / last.max(1) as f64
    }
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

fn dot(a: Quad, b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
