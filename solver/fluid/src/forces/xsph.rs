//! XSPH: Schechter and Bridson 2012, *Ghost SPH for Animating Water*. Velocities go a part of the way to those of
//! their neighbours.

use super::{Force, ForceStep};
use crate::channels::Channels;
use crate::pairs::Quad;
use crate::pairs::velocities::{self, Motion};
use crate::pairs::workspace;
use rayon::prelude::*;

/// Smoothing of the velocities.
#[derive(Clone, Debug, PartialEq)]
pub struct Xsph {
    /// Part of the difference to the neighbours' velocities that goes in a step.
    pub part: f64,
}

impl Force for Xsph {
    fn name(&self) -> &'static str {
        "xsph"
    }

    fn accelerate(
        &mut self,
        step: &ForceStep,
        velocities: &[Quad],
        _: &mut Channels,
        accelerations: &mut [Quad],
    ) {
        if self.part == 0.0 {
            return;
        }
        let (rate, with, places) = ((self.part / step.dt) as f32, step.with, step.places);
        step.neighbours.with(accelerations).for_each(|(lists, out)| {
            workspace::work(lists, |workspace| {
                workspace.places.fill_places(lists.table(), places);
                workspace.vectors.fill(lists.table(), velocities);
                let motion = Motion { places: &workspace.places, velocities: &workspace.vectors };
                let sums = &mut workspace.differences[..lists.len()];
                velocities::mean_difference(lists, with, motion, sums);
                for (out, difference) in out.iter_mut().zip(sums) {
                    for axis in 0..3 {
                        out[axis] += rate * difference[axis];
                    }
                }
            });
        });
    }
}
