//! Both pressure solves: CORRECT DIVERGENCE ERROR and CORRECT DENSITY ERROR of Band et al. 2018, Algorithm 1.
//!
//! Unknown is P = p / (rho_0 D^2), D = rho / rho_0, for each particle. The boundary's part is that of Bender et al.
//! 2020, Eq. 15, with mirrored pressure: both p / rho^2 and p / rho_0^2 times the gradient of the boundary's density.

use crate::boundary::Boundary;
use crate::neighbours::{CHUNK, Neighbours};
use crate::pairs::lanes::Quad;
use crate::pairs::{Density, Pairs};
use crate::settings::SolveSettings;
use rayon::prelude::*;
use volmap_runtime::KernelKind;

/// What the sums over neighbours are made with.
#[derive(Clone, Copy, Debug)]
pub struct Discretization {
    /// The kernel.
    pub kernel: KernelKind,
    /// Its support radius r, metres.
    pub support_radius: f64,
    /// Volume V of a particle, m^3.
    pub volume: f64,
}

/// What a step computes of the particles, in their order. Quads have one more, far away and at rest.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Places in support radii, and P.
    pub places: Vec<Quad>,
    next_places: Vec<Quad>,
    /// Velocities, m/s.
    pub velocities: Vec<Quad>,
    /// Accelerations by pressure, m/s^2.
    pub accelerations: Vec<Quad>,
    /// Relative densities D, the boundary's part included.
    pub densities: Vec<f32>,
    /// alpha of Algorithm 1, of the other sign: how fast P lowers its own particle's density, 1/m^2.
    pub factors: Vec<f32>,
    /// What is to be cancelled: the density's error or the velocity's divergence, 1/s^2.
    sources: Vec<f32>,
    /// Relaxation / factor; 0 where a particle takes no part.
    steps: Vec<f32>,
}

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Jacobi steps.
    pub iterations: u32,
    /// Mean error left, in parts of the rest density.
    pub error: f64,
}

/// Particles whose density is below this are at the surface: their divergence is left alone.
const SURFACE_DENSITY: f32 = 0.7;

impl Fields {
    /// Density and factor of all particles: Algorithm 1, lines 4 and 5.
    pub fn compute_density(&mut self, with: Discretization, neighbours: &Neighbours, boundary: &Boundary) {
        let count = self.places.len() - 1;
        self.densities.resize(count, 0.0);
        self.factors.resize(count, 0.0);
        let pairs = pairs(with, &self.places);
        let chunks = self.densities.par_chunks_mut(CHUNK).zip(self.factors.par_chunks_mut(CHUNK));
        chunks.zip(neighbours.chunks()).for_each(|((densities, factors), lists)| {
            let mut sums = [Density::default(); CHUNK];
            let sums = &mut sums[..densities.len()];
            pairs.density(lists, sums);
            for (within, sum) in sums.iter().enumerate() {
                let wall = boundary.of_particle[lists.first + within];
                let gradient = std::array::from_fn(|axis| sum.gradient[axis] + wall.gradient[axis]);
                densities[within] = sum.density + wall.density;
                factors[within] = dot(gradient, gradient) + sum.squares;
            }
        });
    }

    /// Solves for the pressures that keep the velocity from compressing the fluid; `accelerations` hold the answer.
    pub fn correct_divergence(&mut self, solve: &Solve) -> SolveReport {
        let surface = |density: f32| density < SURFACE_DENSITY;
        self.sources(solve, |density, rate, dt| if surface(density) { 0.0 } else { rate.max(0.0) / dt });
        for (step, &density) in self.steps.iter_mut().zip(&self.densities) {
            if surface(density) {
                *step = 0.0;
            }
        }
        self.iterate(solve)
    }

    /// Solves for the pressures that bring the density back to rest; `accelerations` hold the answer.
    pub fn correct_density(&mut self, solve: &Solve) -> SolveReport {
        self.sources(solve, |density, rate, dt| (density - 1.0) / (dt * dt) + rate / dt);
        self.iterate(solve)
    }

    /// The source of each particle, from its density and the rate at which the velocity raises it.
    fn sources(&mut self, solve: &Solve, source: impl Fn(f32, f32, f32) -> f32 + Sync) {
        let count = self.places.len() - 1;
        self.sources.resize(count, 0.0);
        self.steps.resize(count, 0.0);
        let (pairs, velocities, dt) = (pairs(solve.with, &self.places), &self.velocities, solve.dt as f32);
        let (densities, factors) = (&self.densities, &self.factors);
        let chunks = self.sources.par_chunks_mut(CHUNK).zip(self.steps.par_chunks_mut(CHUNK));
        chunks.zip(solve.neighbours.chunks()).for_each(|((sources, steps), lists)| {
            pairs.flux(lists, velocities, sources);
            for within in 0..sources.len() {
                let particle = lists.first + within;
                let wall = solve.boundary.of_particle[particle];
                let rate = sources[within] + dot3(velocities[particle], wall.gradient) - wall.flux;
                sources[within] = source(densities[particle], rate, dt);
                let factor = factors[particle];
                steps[within] = if factor > 1e-6 { solve.relaxation / factor } else { 0.0 };
            }
        });
    }

    /// Relaxed Jacobi steps until the mean error is small; pressures begin as the fourth numbers of the places.
    fn iterate(&mut self, solve: &Solve) -> SolveReport {
        let mut report = SolveReport::default();
        loop {
            self.accelerate(solve);
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

    /// Accelerations by the pressures: Eq. 1 of Band et al. with the boundary's part as Eq. 15 of Bender et al.
    fn accelerate(&mut self, solve: &Solve) {
        let pairs = pairs(solve.with, &self.places);
        let (places, densities) = (&self.places, &self.densities);
        self.accelerations.resize(places.len(), [0.0; 4]);
        let chunks = self.accelerations.par_chunks_mut(CHUNK).zip(solve.neighbours.chunks());
        chunks.for_each(|(out, lists)| {
            let mut sums = [[0.0; 3]; CHUNK];
            let sums = &mut sums[..lists.len()];
            pairs.acceleration(lists, sums);
            for (within, (out, sum)) in out.iter_mut().zip(sums).enumerate() {
                let particle = lists.first + within;
                let wall = solve.boundary.of_particle[particle];
                let factor = -mirrored(places[particle][3], densities[particle]);
                let [x, y, z] = std::array::from_fn(|axis| sum[axis] + factor * wall.gradient[axis]);
                *out = [x, y, z, 0.0];
            }
        });
    }

    /// A Jacobi step into `next_places`; the mean error of the pressures before it.
    fn relax(&mut self, solve: &Solve) -> f64 {
        let pairs = pairs(solve.with, &self.places);
        let (places, accelerations) = (&self.places, &self.accelerations);
        let (sources, steps) = (&self.sources, &self.steps);
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
                    let error = sources[particle] + *change + dot3(accelerations[particle], wall);
                    let [x, y, z, pressure] = places[particle];
                    *out = [x, y, z, (pressure + steps[particle] * error).max(0.0)];
                    if steps[particle] > 0.0 {
                        static TWO: std::sync::LazyLock<bool> = std::sync::LazyLock::new(|| std::env::var("TWO").is_ok());
                        let error = if *TWO { (out[3] - pressure).abs() / steps[particle] } else { error.max(0.0) };
                        sum += f64::from(error);
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
    /// When to stop.
    pub settings: &'a SolveSettings,
    /// Relaxation of the Jacobi steps, omega.
    pub relaxation: f32,
    /// Time step, seconds.
    pub dt: f64,
}

/// P_i + p_i / rho_0, which is P D^2: own and mirrored pressure, by which the boundary's gradient is multiplied.
pub fn mirrored(pressure: f32, density: f32) -> f32 {
    static M: std::sync::LazyLock<f32> = std::sync::LazyLock::new(|| std::env::var("MIRROR").map_or(1.0, |v| v.parse().unwrap()));
    pressure * (1.0 + *M * density * density)
}

fn pairs(with: Discretization, places: &[Quad]) -> Pairs<'_> {
    Pairs { kernel: with.kernel, support_radius: with.support_radius, volume: with.volume, places }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn dot3(a: Quad, b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

