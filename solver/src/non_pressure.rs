//! Forces other than pressure that aren't solved for: gravity, explicit viscosity (Monaghan 2005; Eq. 16 of Bender et al. 2020), XSPH
//! (Schechter and Bridson 2012).

use crate::fields::{Discretization, Fields};
use crate::neighbours::{CHUNK, Neighbours};
use crate::settings::FluidSettings;
use rayon::prelude::*;
use volmap_runtime::DVec3;

impl Fields {
    /// Writes the accelerations by gravity (m/s^2), explicit viscosity and XSPH, for a step of `dt` seconds.
    pub fn compute_non_pressure(
        &mut self,
        with: Discretization,
        neighbours: &Neighbours,
        (fluid, gravity): (&FluidSettings, DVec3),
        dt: f64,
    ) {
        let gravity = gravity.as_vec3().to_array();
        let [x, y, z] = gravity;
        let count = self.len();
        let [viscosity, _] = fluid.viscosities();
        if viscosity == 0.0 && fluid.xsph == 0.0 {
            self.accelerations[..count].fill([x, y, z, 0.0]);
            return;
        }
        let (nu, xsph) = (viscosity as f32, (fluid.xsph / dt) as f32);
        let (pairs, velocities) = (with.pairs(&self.places), &self.velocities);
        let chunks = self.accelerations.par_chunks_mut(CHUNK).zip(neighbours.chunks());
        chunks.for_each(|(out, lists)| {
            let mut sums = [[[0.0; 3]; 2]; CHUNK];
            let sums = &mut sums[..lists.len()];
            pairs.viscosity(lists, velocities, sums);
            for (out, [laplacian, mean]) in out.iter_mut().zip(sums) {
                for axis in 0..3 {
                    out[axis] = gravity[axis] + nu * laplacian[axis] + xsph * mean[axis];
                }
            }
        });
    }
}
