//! What each step did and how long it took; and the sum of it.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One step; one row of `stats.csv`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepStatistics {
    /// Its number, from 1.
    pub step: u64,
    /// Time simulated at its end, seconds.
    pub time: f64,
    /// Its length, seconds.
    pub dt: f64,
    /// Particles of the fluid.
    pub particles: u64,
    /// Iterations of the solve that keeps the density.
    pub density_iterations: u32,
    /// Iterations of the solve that keeps the velocity free of divergence.
    pub divergence_iterations: u32,
    /// Iterations of the viscous solve; 0 without implicit viscosity and drag of bodies.
    pub viscosity_iterations: u32,
    /// Mean error of the density at the end of its solve, in parts of the rest density.
    pub density_error: f64,
    /// Mean change of the density in the step at the end of the other solve, in parts of the rest density.
    pub divergence_error: f64,
    /// Residual at the end of the viscous solve, in parts of the velocities.
    pub viscosity_error: f64,
    /// Largest speed, m/s.
    pub max_speed: f64,
    /// Mean number of neighbours of a particle.
    pub neighbours: f64,
    /// Particles near a body.
    pub near_bodies: u64,
    /// Particles that emitters made.
    pub emitted: u64,
    /// Particles that left the domain and were removed.
    pub removed: u64,
    /// Particles that were found inside a body and brought back.
    pub inside_body: u64,
    /// Wall-clock time of the step, milliseconds; the rest are its parts.
    pub step_ms: f64,
    /// Sorting particles by cells.
    pub sort_ms: f64,
    /// Search for neighbours.
    pub neighbours_ms: f64,
    /// Sampling the volume maps.
    pub boundary_ms: f64,
    /// Densities and the factors of the solves.
    pub density_ms: f64,
    /// The solve that keeps the velocity free of divergence.
    pub divergence_ms: f64,
    /// The solve that keeps the density.
    pub pressure_ms: f64,
    /// Viscosity and other forces that aren't pressure.
    pub viscosity_ms: f64,
    /// Rigid bodies.
    pub rigid_ms: f64,
    /// Files and pictures.
    pub output_ms: f64,
}

/// A stage of a step: its name, and how long it took.
type Stage = (&'static str, fn(&StepStatistics) -> f64);

/// The parts of a step.
pub const STAGES: [Stage; 9] = [
    ("sort", |s| s.sort_ms),
    ("neighbours", |s| s.neighbours_ms),
    ("boundary", |s| s.boundary_ms),
    ("density", |s| s.density_ms),
    ("divergence", |s| s.divergence_ms),
    ("pressure", |s| s.pressure_ms),
    ("viscosity", |s| s.viscosity_ms),
    ("rigid", |s| s.rigid_ms),
    ("output", |s| s.output_ms),
];

/// A whole run: `stats.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Steps done.
    pub steps: u64,
    /// Time simulated, seconds.
    pub simulated_seconds: f64,
    /// Wall-clock time of all steps, seconds.
    pub wall_seconds: f64,
    /// Particles times steps, a second of wall-clock time.
    pub particle_steps_per_second: f64,
    /// Particles at the end.
    pub particles: u64,
    /// Particles made, removed, and brought back from inside a body.
    pub emitted: u64,
    /// See `emitted`.
    pub removed: u64,
    /// See `emitted`.
    pub brought_back: u64,
    /// Length of a step, seconds.
    pub dt: Spread,
    /// Iterations of the solve that keeps the density.
    pub density_iterations: Spread,
    /// Iterations of the solve that keeps the velocity free of divergence.
    pub divergence_iterations: Spread,
    /// Iterations of the viscous solve.
    pub viscosity_iterations: Spread,
    /// Mean error of the density, in parts of the rest density.
    pub density_error: Spread,
    /// Largest speed, m/s.
    pub max_speed: Spread,
    /// A step, milliseconds.
    pub step_ms: Spread,
    /// Its stages by name, milliseconds.
    pub stages_ms: BTreeMap<String, Spread>,
}

/// How a number spreads over the steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Over all steps.
    pub total: f64,
    /// A step.
    pub mean: f64,
    /// A step.
    pub median: f64,
    /// Of any step.
    pub least: f64,
    /// Of any step.
    pub most: f64,
}

impl Spread {
    /// Of these numbers; all zero if there are none.
    pub fn of(numbers: impl Iterator<Item = f64>) -> Spread {
        let mut sorted: Vec<f64> = numbers.collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else { return Spread::default() };
        let (count, total) = (sorted.len(), sorted.iter().sum::<f64>());
        let median = 0.5 * (sorted[count / 2] + sorted[(count - 1) / 2]);
        Spread { total, mean: total / count as f64, median, least, most }
    }
}

/// Sums up the steps of a run, in their order.
pub fn summarise(steps: &[StepStatistics]) -> Summary {
    let spread = |of: fn(&StepStatistics) -> f64| Spread::of(steps.iter().map(of));
    let count = |of: fn(&StepStatistics) -> u64| steps.iter().map(of).sum();
    let last = steps.last().cloned().unwrap_or_default();
    let wall_seconds = 1e-3 * spread(|s| s.step_ms).total;
    let particle_steps: f64 = steps.iter().map(|s| s.particles as f64).sum();
    Summary {
        steps: steps.len() as u64,
        simulated_seconds: last.time,
        wall_seconds,
        particle_steps_per_second: if wall_seconds > 0.0 { particle_steps / wall_seconds } else { 0.0 },
        particles: last.particles,
        emitted: count(|s| s.emitted),
        removed: count(|s| s.removed),
        brought_back: count(|s| s.inside_body),
        dt: spread(|s| s.dt),
        density_iterations: spread(|s| s.density_iterations.into()),
        divergence_iterations: spread(|s| s.divergence_iterations.into()),
        viscosity_iterations: spread(|s| s.viscosity_iterations.into()),
        density_error: spread(|s| s.density_error),
        max_speed: spread(|s| s.max_speed),
        step_ms: spread(|s| s.step_ms),
        stages_ms: STAGES.map(|(name, of)| (name.to_owned(), spread(of))).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_add_up() {
        let step = |step: u64, ms: f64| StepStatistics {
            step,
            time: 0.5 * step as f64,
            particles: 1000 * step,
            density_iterations: step as u32,
            step_ms: ms,
            pressure_ms: 0.5 * ms,
            removed: 2,
            ..StepStatistics::default()
        };
        let summary = summarise(&[step(1, 10.0), step(2, 40.0), step(3, 20.0), step(4, 30.0)]);
        assert_eq!((summary.steps, summary.particles, summary.removed), (4, 4000, 8));
        assert_eq!(summary.simulated_seconds, 2.0);
        assert_eq!(summary.wall_seconds, 0.1);
        assert_eq!(summary.particle_steps_per_second, 1e5);
        let pressure = Spread { total: 50.0, mean: 12.5, median: 12.5, least: 5.0, most: 20.0 };
        assert_eq!(summary.stages_ms["pressure"], pressure);
        assert_eq!(summary.density_iterations.median, 2.5);
        assert_eq!(summarise(&[]), Summary { stages_ms: summarise(&[]).stages_ms, ..Summary::default() });
    }
}
