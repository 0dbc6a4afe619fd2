//! Forces other than pressure that aren't solved for: gravity, explicit viscosity (Monaghan 2005; Eq. 16 of Bender et al. 2020), XSPH
//! (Schechter and Bridson 2012).

use crate::fields::{Discretization, Fields};
use crate::neighbours::{self, Neighbours};
use crate::pairs::viscosity::{self, Motion};
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
        let [explicit, _] = fluid.viscosities();
        if explicit == 0.0 && fluid.xsph == 0.0 {
            self.accelerations.fill([x, y, z, 0.0]);
            return;
        }
        let (nu, xsph) = (explicit as f32, (fluid.xsph / dt) as f32);
        let (places, velocities) = (&self.places, &self.velocities);
        neighbours.with(&mut self.accelerations).for_each(|(lists, out)| {
            neighbours::work(lists, |workspace| {
                workspace.places.fill_places(lists.table(), places);
                workspace.vectors.fill(lists.table(), velocities);
                let motion = Motion { places: &workspace.places, velocities: &workspace.vectors };
                let viscous = &mut workspace.viscous[..lists.len()];
                if xsph == 0.0 {
                    viscosity::viscosity::<false>(lists, with, motion, viscous);
                } else {
                    viscosity::viscosity::<true>(lists, with, motion, viscous);
                }
                for (out, [laplacian, mean]) in out.iter_mut().zip(viscous) {
                    for axis in 0..3 {
                        out[axis] = gravity[axis] + nu * laplacian[axis] + xsph * mean[axis];
                    }
                }
            });
        });
    }
}
