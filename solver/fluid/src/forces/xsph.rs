//! XSPH: Schechter and Bridson 2012, *Ghost SPH for Animating Water*. Velocities go a part of the way to those of
//! their neighbours. The differences of velocities don't lie along the lines between particles, so that angular
//! momentum isn't kept: what turns is slowed down. Along these lines only, it would be viscosity.

use super::velocity_sums::add_sums;
use super::{Force, ForceStep};
use crate::channels::Channels;
use crate::pairs::Quad;
use crate::pairs::velocities::mean_difference;

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
        add_sums(step, velocities, (self.part / step.dt) as f32, mean_difference, accelerations);
    }
}
