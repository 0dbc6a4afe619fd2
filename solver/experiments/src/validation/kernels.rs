//! Every kernel with every usual support radius, as calm and as right as the default: water at rest from wall to wall,
//! a floating ball, and a collision without gravity.
//!
//! What must follow from the kernel for it: the particles' volume and the boundary's density by the kernel's sum over
//! the lattice, and the relaxation of the solves ([`volmap_fluid::rest`]).

use super::hydrostatic::column::Column;
use super::hydrostatic::{Case, filled, rows, tank};
use super::{Experiment, Outcome, Row, Run, floats, momentum};
use volmap_fluid::Error;
use volmap_fluid::rest::calm_radii;
use volmap_runtime::KernelKind;

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "kernels",
    title: "Every kernel with support radii of 3.5 to 5 rp",
    about: "Water at rest, a floating ball and momentum, each as with the default kernel",
    run,
};

/// Support radii, rp.
const RADII: [f64; 4] = [3.5, 4.0, 4.5, 5.0];
/// Particle radius, and ten layers of water, metres.
const RADIUS: f64 = 0.05;
const DEPTH: f64 = 1.0;

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let all = KernelKind::ALL.into_iter().flat_map(|kernel| RADII.map(|radii| (kernel, radii)));
    for (kernel, radii) in all {
        let name = format!("{kernel}, {radii} rp");
        (run.progress)(&format!("kernels: {name}"));
        let end = run.pick(0.5, 4.0);
        let column =
            Column { kernel: (kernel, radii), radius: RADIUS, largest_step: 0.003, end, ..filled(DEPTH) };
        let rest = column.settle(run, &tank(&column)?)?;
        let calm = Row::new(&name, "largest speed in the first half second", "m/s", rest.first_speed);
        // Scenes are refused with the others: their rows say why.
        let judged = calm_radii(kernel).is_some_and(|[least, most]| (least..=most).contains(&radii));
        outcome.rows.push(if judged { calm.at_most(1.0) } else { calm });
        if !run.short {
            outcome.rows.extend(rows(run, &Case { name: name.clone(), column, judged }, &rest));
        }
        if !run.short && judged {
            momentum::collide(run, &mut outcome, &name, 0.01, (kernel, radii))?;
            floats::of_kernel(run, &mut outcome, &name, (kernel, radii))?;
        }
    }
    Ok(outcome)
}
