//! What a user should know of how a run went, from the rows of its steps: fluid that was compressed, particles for
//! which there was no room, solves that ended too early.

use super::statistics::{EmitterSummary, StepStatistics};
use volmap_fluid::compression::COMPRESSED;
use volmap_fluid::room::FULL;
use volmap_fluid::settings::SolverSettings;
use volmap_formats::text::{number, percent, thousands};

/// For so long a fluid may be compressed without a note, seconds: longer than a splash is.
const MOMENT: f64 = 0.1;

/// All notes of a run, whose emitters gave so much.
pub fn of_run(steps: &[StepStatistics], emitters: &[EmitterSummary], solver: &SolverSettings) -> Vec<String> {
    let all =
        [compressed(steps), pinched(steps), held(steps, emitters)].into_iter().chain(unsolved(steps, solver));
    all.flatten().collect()
}

/// A fluid that is denser than at rest somewhere for more than a moment: how long at most without a break, and the
/// worst.
fn compressed(steps: &[StepStatistics]) -> Option<String> {
    let spells = steps.chunk_by(|a, b| is_compressed(a) == is_compressed(b)).filter(|s| is_compressed(&s[0]));
    let length = |spell: &&[StepStatistics]| spell.iter().map(|step| step.dt).sum::<f64>();
    let longest = spells.max_by(|a, b| length(a).total_cmp(&length(b)))?;
    let seconds = length(&longest);
    if seconds < MOMENT {
        return None;
    }
    let worst = longest.iter().max_by(|a, b| a.density_error_max.total_cmp(&b.density_error_max))?;
    let place = [worst.densest_x, worst.densest_y, worst.densest_z].map(number).join(", ");
    Some(format!(
        "the fluid was denser than at rest by more than {} somewhere for {} s, from {} s on; by up to {}, at \
         ({place}) m and {} s; it has no room there, began too dense, or is pressed together faster than it can \
         give way",
        percent(COMPRESSED),
        number(seconds),
        number(longest[0].time - longest[0].dt),
        percent(worst.density_error_max),
        number(worst.time - worst.dt),
    ))
}

fn is_compressed(step: &StepStatistics) -> bool {
    step.density_error_max > COMPRESSED
}

/// Fluid where bodies leave it less room than a particle has, for more than a moment: in how many steps, how much, and
/// where.
fn pinched(steps: &[StepStatistics]) -> Option<String> {
    let with = || steps.iter().filter(|step| step.pinched > 0);
    if with().map(|step| step.dt).sum::<f64>() < MOMENT {
        return None;
    }
    let worst = with().max_by_key(|step| (step.pinched, std::cmp::Reverse(step.step)))?;
    let place = [worst.pinched_x, worst.pinched_y, worst.pinched_z].map(number).join(", ");
    Some(format!(
        "up to {} particles were pinched between bodies that leave less room than a particle has (default closure: \
         gaps of less than some 1.4 particle radii), in {} of {} steps, as at ({place}) m and {} s; they are held there \
         and gain no energy; take smaller particles, or keep bodies farther from each other and the fluid out of gaps",
        thousands(worst.pinched),
        thousands(with().count() as u64),
        thousands(steps.len() as u64),
        number(worst.time - worst.dt),
    ))
}

fn held(steps: &[StepStatistics], emitters: &[EmitterSummary]) -> Option<String> {
    let first = steps.iter().find(|step| step.held > 0)?;
    let count = |of: fn(&StepStatistics) -> u64| steps.iter().map(of).sum::<u64>();
    let (held, emitted) = (count(|s| s.held), count(|s| s.emitted));
    let of = |held: u64, emitted: u64| {
        let part = percent(held as f64 / (held + emitted).max(1) as f64);
        format!("{} of {} particles ({part})", thousands(held), thousands(held + emitted))
    };
    let each = emitters.iter().enumerate().filter(|(_, emitter)| emitter.held > 0);
    let each = each.map(|(n, emitter)| format!("emitters[{n}] {}", of(emitter.held, emitter.emitted)));
    let each = if emitters.len() > 1 { each.collect::<Vec<_>>().join(", ") + "; " } else { String::new() };
    Some(format!(
        "emitters held back {}, the first at {} s: {each}there was no room for them before the next layer was due, in \
         a body, on top of other fluid, or where the fluid was denser than at rest by more than {}; so much of the \
         flow is missing",
        of(held, emitted),
        number(first.time - first.dt),
        percent(FULL),
    ))
}

/// A solve, for a note: what it is called, its limit, what it may leave, and how it went in a step.
struct Solve {
    name: &'static str,
    most: u32,
    error: f64,
    went: fn(&StepStatistics) -> (u32, f64),
}

fn unsolved(steps: &[StepStatistics], solver: &SolverSettings) -> Vec<Option<String>> {
    let SolverSettings { density, divergence, viscosity, .. } = solver;
    let all = [
        Solve {
            name: "density",
            most: density.max_iterations,
            error: density.max_error,
            went: |s| (s.density_iterations, s.density_residual),
        },
        Solve {
            name: "divergence",
            most: divergence.max_iterations,
            error: divergence.max_error,
            went: |s| (s.divergence_iterations, s.divergence_error),
        },
        Solve {
            name: "viscosity",
            most: viscosity.max_iterations,
            error: viscosity.max_error,
            went: |s| (s.viscosity_iterations, s.viscosity_error),
        },
    ];
    all.iter().map(|solve| unsolved_by(solve, steps)).collect()
}

fn unsolved_by(solve: &Solve, steps: &[StepStatistics]) -> Option<String> {
    let failed = |step: &&StepStatistics| {
        let (iterations, error) = (solve.went)(step);
        iterations >= solve.most && error > solve.error
    };
    let count = steps.iter().filter(failed).count();
    let worst = steps.iter().filter(failed).map(|step| (solve.went)(step).1).fold(0.0, f64::max);
    let Solve { name, most, error, .. } = solve;
    (count > 0).then(|| {
        format!(
            "the {name} solve ended at its limit of {most} iterations in {} of {} steps, with an error of up to {} \
             ({} is asked for); take smaller steps (solver.time_step.max), or raise solver.{name}.max_iterations",
            thousands(count as u64),
            thousands(steps.len() as u64),
            percent(worst),
            percent(*error),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of 10 ms, changed by their number.
    fn steps(count: u64, change: impl Fn(u64, &mut StepStatistics)) -> Vec<StepStatistics> {
        let step = |n: u64| {
            let mut step =
                StepStatistics { step: n, time: 0.01 * n as f64, dt: 0.01, emitted: 2, ..Default::default() };
            change(n, &mut step);
            step
        };
        (1..=count).map(step).collect()
    }

    fn notes(steps: &[StepStatistics]) -> Vec<String> {
        let emitters = [EmitterSummary { emitted: 100, held: 0 }, EmitterSummary { emitted: 100, held: 150 }];
        of_run(steps, &emitters, &SolverSettings::default())
    }

    #[test]
    fn a_run_without_trouble_has_no_notes() {
        assert_eq!(notes(&steps(100, |_, _| ())), Vec::<String>::new());
        // A splash: 50 ms.
        let splash =
            |n, step: &mut StepStatistics| step.density_error_max = if n % 10 < 5 { 0.2 } else { 0.0 };
        assert_eq!(notes(&steps(100, splash)), Vec::<String>::new());
    }

    #[test]
    fn compression_is_told_with_time_and_place() {
        let long = |n: u64, step: &mut StepStatistics| {
            step.density_error_max = if (21..=60).contains(&n) { 0.001 * n as f64 + 0.1 } else { 0.01 };
            step.densest_y = n as f64;
        };
        let notes = notes(&steps(100, long));
        let [note] = &notes[..] else { panic!("{notes:?}") };
        assert!(
            note.contains("for 0.4 s, from 0.2 s on; by up to 16 %, at (0, 60, 0) m and 0.59 s"),
            "{note}"
        );
    }

    #[test]
    fn pinched_fluid_is_told_with_its_place() {
        let gap = |n: u64, step: &mut StepStatistics| {
            step.pinched = if n > 70 { 5 + u64::from(n == 81) } else { 0 };
            step.pinched_x = 0.1 * n as f64;
        };
        let notes = notes(&steps(100, gap));
        let [note] = &notes[..] else { panic!("{notes:?}") };
        assert!(note.starts_with("up to 6 particles were pinched"), "{note}");
        assert!(note.contains("in 30 of 100 steps, as at (8.1, 0, 0) m and 0.8 s"), "{note}");
    }

    #[test]
    fn what_is_held_back_and_not_solved_is_told() {
        let bad = |n: u64, step: &mut StepStatistics| {
            step.held = 3 * u64::from(n > 50);
            if n > 90 {
                (step.density_iterations, step.density_residual) = (100, 0.02);
                // At the limit, but solved.
                (step.divergence_iterations, step.divergence_error) = (100, 1e-4);
            }
        };
        let notes = notes(&steps(100, bad));
        let [held, density] = &notes[..] else { panic!("{notes:?}") };
        assert!(held.contains("held back 150 of 350 particles (42.9 %), the first at 0.5 s"), "{held}");
        assert!(held.contains("0.5 s: emitters[1] 150 of 250 particles (60 %); there"), "{held}");
        assert!(
            density.contains("the density solve ended at its limit of 100 iterations in 10 of 100"),
            "{density}"
        );
        assert!(density.contains("up to 2 % (0.05 % is asked for)"), "{density}");
    }
}
