//! What each step did and how long it took, and a summary of all steps.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;
use volmap_fluid::simulation::{Simulation, StepReport};
use volmap_fluid::stages::Stages;

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
    /// Iterations of the viscous solve; 0 without implicit viscosity and drag at bodies.
    pub viscosity_iterations: u32,
    /// How often viscosity and density were solved for in turns; 1 where they aren't.
    pub viscosity_passes: u32,
    /// How much denser than at rest the fluid is, mean over all particles, in parts of the rest density; those that are
    /// less dense count as 0. At the beginning of the step: after the one before, and with what emitters have added.
    pub density_error: f64,
    /// The same of the densest particle.
    pub density_error_max: f64,
    /// Where that one is, metres.
    pub densest_x: f64,
    /// See `densest_x`.
    pub densest_y: f64,
    /// See `densest_x`.
    pub densest_z: f64,
    /// What the solve that keeps the density left of the errors that it was to correct, mean over all particles, in
    /// parts of the rest density. It corrects at most 1 % in a step.
    pub density_residual: f64,
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
    /// Particles that emitters should have made, and for which there was no room.
    pub held: u64,
    /// Particles that left the domain and were removed.
    pub removed: u64,
    /// Particles that were found inside a body and pushed out.
    pub inside_body: u64,
    /// Particles that bodies press together, with less room than a particle has and no way out.
    pub pinched: u64,
    /// Where the one is that is pressed most, metres.
    pub pinched_x: f64,
    /// See `pinched_x`.
    pub pinched_y: f64,
    /// See `pinched_x`.
    pub pinched_z: f64,
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

impl StepStatistics {
    /// Of the simulation's last step, and the time that its files took.
    pub fn of(simulation: &Simulation, report: &StepReport, writing: Duration) -> StepStatistics {
        let ms = |duration: Duration| 1e3 * duration.as_secs_f64();
        let stages: &Stages = &report.stages;
        StepStatistics {
            step: simulation.steps(),
            time: simulation.time(),
            dt: report.dt,
            particles: simulation.particles().len() as u64,
            density_iterations: report.density.iterations,
            divergence_iterations: report.divergence.iterations,
            viscosity_iterations: report.viscosity.iterations,
            viscosity_passes: report.passes,
            density_error: report.compression.mean,
            density_error_max: report.compression.largest,
            densest_x: report.compression.place.x,
            densest_y: report.compression.place.y,
            densest_z: report.compression.place.z,
            density_residual: report.density.error,
            divergence_error: report.divergence.error,
            viscosity_error: report.viscosity.error,
            max_speed: report.max_speed,
            neighbours: simulation.mean_neighbours(),
            near_bodies: report.near_bodies as u64,
            emitted: report.emitted as u64,
            held: report.held as u64,
            removed: report.removed as u64,
            inside_body: report.inside as u64,
            pinched: report.pinched.count as u64,
            pinched_x: report.pinched.place.x,
            pinched_y: report.pinched.place.y,
            pinched_z: report.pinched.place.z,
            step_ms: ms(stages.total() + writing),
            sort_ms: ms(stages.sort),
            neighbours_ms: ms(stages.neighbours),
            boundary_ms: ms(stages.boundary),
            density_ms: ms(stages.density),
            divergence_ms: ms(stages.divergence),
            pressure_ms: ms(stages.pressure),
            viscosity_ms: ms(stages.non_pressure + stages.advance),
            rigid_ms: ms(stages.rigid),
            output_ms: ms(writing),
        }
    }
}

/// A stage of a step.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// Its name in `stats.json`.
    pub name: &'static str,
    /// How long it took in a step, milliseconds.
    pub milliseconds: fn(&StepStatistics) -> f64,
}

/// The stages of a step. Together they take all of its time.
pub const STAGES: [Stage; 9] = [
    Stage { name: "sort", milliseconds: |s| s.sort_ms },
    Stage { name: "neighbours", milliseconds: |s| s.neighbours_ms },
    Stage { name: "boundary", milliseconds: |s| s.boundary_ms },
    Stage { name: "density", milliseconds: |s| s.density_ms },
    Stage { name: "divergence", milliseconds: |s| s.divergence_ms },
    Stage { name: "pressure", milliseconds: |s| s.pressure_ms },
    Stage { name: "viscosity", milliseconds: |s| s.viscosity_ms },
    Stage { name: "rigid", milliseconds: |s| s.rigid_ms },
    Stage { name: "output", milliseconds: |s| s.output_ms },
];

/// The summary of a run: `stats.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunSummary {
    /// Steps done.
    pub steps: u64,
    /// Time simulated, seconds.
    pub simulated_seconds: f64,
    /// Wall-clock time of all steps, seconds.
    pub wall_seconds: f64,
    /// Particles times steps, per second of wall-clock time.
    pub particle_steps_per_second: f64,
    /// Particles at the end.
    pub particles: u64,
    /// Particles that emitters made.
    pub emitted: u64,
    /// Particles that emitters should have made, and for which there was no room.
    pub held: u64,
    /// The same of each emitter, in the scene's order.
    #[serde(default)]
    pub emitters: Vec<EmitterSummary>,
    /// Particles that left the domain and were removed.
    pub removed: u64,
    /// Particles that were pushed out of bodies; one counts once per step.
    pub brought_back: u64,
    /// Particles that bodies pressed together; one counts once per step.
    #[serde(default)]
    pub pinched: u64,
    /// Length of a step, seconds.
    pub dt: Spread,
    /// Iterations of the solve that keeps the density.
    pub density_iterations: Spread,
    /// Iterations of the solve that keeps the velocity free of divergence.
    pub divergence_iterations: Spread,
    /// Iterations of the viscous solve.
    pub viscosity_iterations: Spread,
    /// How much denser than at rest the fluid is, mean over all particles, in parts of the rest density.
    pub density_error: Spread,
    /// The same of the densest particle.
    pub density_error_max: Spread,
    /// What the solve that keeps the density left of it, mean over all particles.
    pub density_residual: Spread,
    /// Largest speed, m/s.
    pub max_speed: Spread,
    /// Wall-clock time of a step, milliseconds.
    pub step_ms: Spread,
    /// Wall-clock times of the stages of a step, milliseconds.
    pub stages_ms: BTreeMap<String, Spread>,
    /// What the user should know of how it went.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// What an emitter gave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EmitterSummary {
    /// Particles that it made.
    pub emitted: u64,
    /// Particles that it should have made, and for which there was no room.
    pub held: u64,
}

/// How a number spreads over the steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Sum over all steps.
    pub total: f64,
    /// Mean over the steps.
    pub mean: f64,
    /// Median over the steps.
    pub median: f64,
    /// Least of all steps.
    pub least: f64,
    /// Largest of all steps.
    pub most: f64,
}

impl Spread {
    /// The spread of these numbers; all zero if there are none.
    pub fn of(numbers: impl Iterator<Item = f64>) -> Spread {
        let mut sorted: Vec<f64> = numbers.collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else { return Spread::default() };
        let (count, total) = (sorted.len(), sorted.iter().sum::<f64>());
        let median = 0.5 * (sorted[count / 2] + sorted[(count - 1) / 2]);
        Spread { total, mean: total / count as f64, median, least, most }
    }
}

/// Sums up the steps of a run, in their order; without notes, and without what each emitter gave.
pub fn summarise(steps: &[StepStatistics]) -> RunSummary {
    let spread = |of: fn(&StepStatistics) -> f64| Spread::of(steps.iter().map(of));
    let count = |of: fn(&StepStatistics) -> u64| steps.iter().map(of).sum();
    let last = steps.last().cloned().unwrap_or_default();
    let wall_seconds = 1e-3 * spread(|s| s.step_ms).total;
    let particle_steps: f64 = steps.iter().map(|s| s.particles as f64).sum();
    RunSummary {
        steps: steps.len() as u64,
        simulated_seconds: last.time,
        wall_seconds,
        particle_steps_per_second: if wall_seconds > 0.0 { particle_steps / wall_seconds } else { 0.0 },
        particles: last.particles,
        emitted: count(|s| s.emitted),
        held: count(|s| s.held),
        emitters: Vec::new(),
        removed: count(|s| s.removed),
        brought_back: count(|s| s.inside_body),
        pinched: count(|s| s.pinched),
        dt: spread(|s| s.dt),
        density_iterations: spread(|s| s.density_iterations.into()),
        divergence_iterations: spread(|s| s.divergence_iterations.into()),
        viscosity_iterations: spread(|s| s.viscosity_iterations.into()),
        density_error: spread(|s| s.density_error),
        density_error_max: spread(|s| s.density_error_max),
        density_residual: spread(|s| s.density_residual),
        max_speed: spread(|s| s.max_speed),
        step_ms: spread(|s| s.step_ms),
        stages_ms: STAGES.map(|stage| (stage.name.to_owned(), spread(stage.milliseconds))).into(),
        notes: Vec::new(),
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
        assert_eq!(
            summarise(&[]),
            RunSummary { stages_ms: summarise(&[]).stages_ms, ..RunSummary::default() }
        );
    }
}
