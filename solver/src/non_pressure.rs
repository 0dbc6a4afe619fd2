//! Forces other than pressure that aren't solved for: gravity, explicit viscosity (Monaghan 2005; Eq. 16 of Bender et al. 2020), XSPH
//! (Schechter and Bridson 2012).

use crate::fields::Fields;
use crate::neighbours::{self, Lists, Neighbours};
use crate::pairs::lanes::Quad;
use crate::pairs::{Row, sums};
use crate::settings::FluidSettings;
use rayon::prelude::*;
use volmap_runtime::DVec3;

impl Fields {
    /// Writes the accelerations by gravity (m/s^2), explicit viscosity and XSPH, for a step of `dt` seconds.
    pub fn compute_non_pressure(
        &mut self,
        neighbours: &Neighbours,
        (fluid, gravity): (&FluidSettings, DVec3),
        dt: f64,
    ) {
        let gravity = gravity.as_vec3().to_array();
        let [x, y, z] = gravity;
        let [viscosity, _] = fluid.viscosities();
        if viscosity == 0.0 && fluid.xsph == 0.0 {
            self.accelerations.fill([x, y, z, 0.0]);
            return;
        }
        let (nu, xsph) = (viscosity as f32, (fluid.xsph / dt) as f32);
        let velocities = &self.velocities;
        neighbours.with(&mut self.accelerations).for_each(|(lists, out)| {
            let Some(bends) = lists.bends() else { return };
            viscous(lists, bends, (velocities, xsph != 0.0), |within, [laplacian, mean]| {
                let change: [f32; 3] =
                    std::array::from_fn(|axis| gravity[axis] + nu * laplacian[axis] + xsph * mean[axis]);
                out[within] = [change[0], change[1], change[2], 0.0];
            });
        });
    }
}

/// Laplacian of the velocities of a block's particles, and XSPH's mean of the differences, if it is asked for.
fn viscous(
    lists: &Lists,
    bends: &[Row],
    (velocities, with_mean): (&[Quad], bool),
    mut out: impl FnMut(usize, [[f32; 3]; 2]),
) {
    neighbours::work(lists, |workspace| {
        workspace.vectors.fill(lists.table(), velocities);
        let [of_bends, means] = [&mut workspace.sums, &mut workspace.more_sums];
        if with_mean {
            sums::bends_and_means(lists, bends, &workspace.vectors, [of_bends, means]);
        } else {
            sums::bends(lists, bends, &workspace.vectors, of_bends);
        }
        let [unit, of_mean] = [lists.unit_of_bends(), lists.unit_of_means()];
        for within in 0..lists.len() {
            let ([a, b, c, _], [x, y, z, _]) = (workspace.sums[within], workspace.more_sums[within]);
            let mean = if with_mean { [x, y, z].map(|sum| of_mean * sum) } else { [0.0; 3] };
            out(within, [[a, b, c].map(|sum| unit * sum), mean]);
        }
    });
}
