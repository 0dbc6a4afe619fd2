//! Gravity of the fluid. Bodies have their own: see [`Bodies::new`](crate::bodies::Bodies::new).

use super::{Force, ForceStep};
use crate::channels::Channels;
use crate::pairs::Quad;
use crate::particles::CHUNK;
use rayon::prelude::*;
use volmap_runtime::DVec3;

/// A constant acceleration.
#[derive(Clone, Debug, PartialEq)]
pub struct Gravity {
    /// m/s^2.
    pub acceleration: DVec3,
}

impl Force for Gravity {
    fn name(&self) -> &'static str {
        "gravity"
    }

    fn accelerate(&mut self, _: &ForceStep, _: &[Quad], _: &mut Channels, accelerations: &mut [Quad]) {
        let gravity = self.acceleration.as_vec3().to_array();
        accelerations.par_iter_mut().with_min_len(CHUNK).for_each(|out| {
            for axis in 0..3 {
                out[axis] += gravity[axis];
            }
        });
    }
}
