//! The time step by the condition of Courant, Friedrichs and Lewy: Monaghan 1992; Bender and Koschier 2017, section 4.

use crate::settings::TimeStepSettings;

/// A particle may cross this part of its diameter in a step, at a CFL factor of 1.
const PART_OF_DIAMETER: f64 = 0.4;

/// The step for a largest speed (m/s), seconds; `most` is the longest that forces allow.
pub fn time_step(settings: &TimeStepSettings, particle_radius: f64, max_speed: f64, most: f64) -> f64 {
    if !settings.adaptive {
        return settings.initial;
    }
    let step = settings.cfl_factor * PART_OF_DIAMETER * 2.0 * particle_radius / max_speed;
    // A fluid at rest gives infinity.
    step.min(settings.max).min(most).max(settings.min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_keeps_its_bounds() {
        let settings =
            TimeStepSettings { cfl_factor: 0.5, min: 1e-4, max: 5e-3, ..TimeStepSettings::default() };
        let step = |speed| time_step(&settings, 0.025, speed, f64::INFINITY);
        assert_eq!(step(0.0), 5e-3);
        assert!((step(10.0) - 1e-3).abs() < 1e-12, "0.5 * 0.4 * 0.05 m in 10 m/s");
        assert_eq!(step(1e9), 1e-4);
        assert_eq!(step(f64::INFINITY), 1e-4);
        assert_eq!(time_step(&settings, 0.025, 0.0, 2e-3), 2e-3);
        let fixed = TimeStepSettings { adaptive: false, initial: 7e-3, ..settings };
        assert_eq!(time_step(&fixed, 0.025, 1e9, 2e-3), 7e-3);
    }
}
