//! Explicit forces that are a sum over the neighbours' velocities.

use super::ForceStep;
use crate::discretization::Discretization;
use crate::pairs::Quad;
use crate::pairs::lists::Lists;
use crate::pairs::velocities::Motion;
use crate::pairs::workspace;
use rayon::prelude::*;

/// A sum of each particle of some lists, as those of [`crate::pairs::velocities`].
pub(super) type VelocitySum = fn(&Lists, Discretization, Motion, &mut [[f32; 3]]);

/// Adds `factor` times the sum at these velocities (m/s) to the accelerations (m/s^2).
pub(super) fn add_sums(
    step: &ForceStep,
    velocities: &[Quad],
    factor: f32,
    sum: VelocitySum,
    accelerations: &mut [Quad],
) {
    let (with, places) = (step.with, step.places);
    step.neighbours.with(accelerations).for_each(|(lists, out)| {
        workspace::work(lists, |workspace| {
            workspace.places.fill_places(lists.table(), places);
            workspace.vectors.fill(lists.table(), velocities);
            let motion = Motion { places: &workspace.places, velocities: &workspace.vectors };
            let sums = &mut workspace.differences[..lists.len()];
            sum(lists, with, motion, sums);
            for (out, sum) in out.iter_mut().zip(sums) {
                for axis in 0..3 {
                    out[axis] += factor * sum[axis];
                }
            }
        });
    });
}
