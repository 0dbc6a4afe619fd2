//! Drag of the air, linear in the velocity: a = -k v, whatever the fluid does.
//!
//! What is added is the mean of that over the step, -(1 - e^(-k dt)) / dt v, so that a fluid without other forces has
//! exactly e^(-k t) of its velocity after t seconds, in steps of any length.

use super::{Defect, Force, ForceStep};
use crate::channels::Channels;
use crate::pairs::Quad;
use crate::particles::CHUNK;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Drag of the air on all of the fluid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// Rate k at which velocities decay, 1/s.
    pub rate: f64,
}

impl Force for Damping {
    fn name(&self) -> &'static str {
        "damping"
    }

    fn check(&self) -> Result<(), Defect> {
        if self.rate.is_finite() && self.rate >= 0.0 {
            return Ok(());
        }
        let reason = format!("{} 1/s is not a rate of decay: give 0 or more", self.rate);
        Err(Defect { key: "rate", reason })
    }

    fn accelerate(
        &mut self,
        step: &ForceStep,
        velocities: &[Quad],
        _: &mut Channels,
        accelerations: &mut [Quad],
    ) {
        let factor = ((-self.rate * step.dt).exp_m1() / step.dt) as f32;
        let all = accelerations.par_iter_mut().zip(velocities).with_min_len(CHUNK);
        all.for_each(|(out, velocity)| {
            for axis in 0..3 {
                out[axis] += factor * velocity[axis];
            }
        });
    }
}
