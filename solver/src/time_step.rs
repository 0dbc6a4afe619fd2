//! The time step by the condition of Courant, Friedrichs and Lewy: Monaghan 1992; Bender and Koschier 2017, section 4.

use crate::settings::TimeStepSettings;

/// A particle may cross this part of its diameter in a step, at a CFL factor of 1.
const PART_OF_DIAMETER: f64 = 0.4;

/// The step for a largest speed (m/s), seconds.
pub fn time_step(settings: &TimeStepSettings, particle_radius: f64, max_speed: f64) -> f64 {
    if !settings.adaptive {
        return settings.initial;
    }
    let step = settings.cfl_factor * PART_OF_DIAMETER * 2.0 * particle_radius / max_speed;
    // A fluid at rest gives infinity.
    step.min(settings.max).max(settings.min)
}
