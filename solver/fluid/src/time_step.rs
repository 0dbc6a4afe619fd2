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

/// Rounding of sums of steps, in parts of a step: a last step may be longer by this.
const ROUNDING: f64 = 1e-6;

/// The first of equal steps that together last for `time` and are as few as can be, none longer than `most`. All times
/// in seconds and positive.
pub fn part_of(time: f64, most: f64) -> f64 {
    let count = (time / most - ROUNDING).ceil().max(1.0);
    time / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_share_a_time_evenly() {
        assert_eq!(part_of(0.04, 0.04), 0.04);
        assert_eq!(part_of(0.04, 1.0), 0.04);
        // Twenty, not one and a half; and no tiny last one.
        assert_eq!(part_of(0.04, 0.002), 0.04 / 20.0);
        assert_eq!(part_of(0.04, 0.03), 0.02);
        assert_eq!(part_of(0.04, 0.0399), 0.02);
        assert_eq!(part_of(0.04, 0.04 * (1.0 - 1e-12)), 0.04, "rounding makes no step");
        // As a run goes: what is left after each of them is shared anew.
        let (mut left, mut count) = (0.04, 0);
        while left > 0.0 {
            let dt = part_of(left, 0.0019);
            assert!(dt > 0.0018 && dt <= 0.0019);
            (left, count) = (if dt == left { 0.0 } else { left - dt }, count + 1);
        }
        assert_eq!(count, 22);
    }

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
