//! Explicit viscosity: Monaghan 2005; Eq. 16 of Bender et al. 2020.

use super::velocity_sums::add_sums;
use super::{Force, ForceStep};
use crate::channels::Channels;
use crate::pairs::Quad;
use crate::pairs::velocities::laplacian;
use crate::settings::{FluidSettings, World};
use std::f64::consts::PI;
use volmap_runtime::Dimension;

/// Viscosity from the velocities before the step.
#[derive(Clone, Debug, PartialEq)]
pub struct Viscosity {
    /// Kinematic viscosity nu, m^2/s.
    pub viscosity: f64,
    /// See [`viscous_limit`], seconds.
    pub longest_step: f64,
}

impl Viscosity {
    /// Of a fluid; none if its viscosity is implicit.
    pub fn new(fluid: &FluidSettings, world: &World) -> Viscosity {
        let [viscosity, _] = fluid.viscosities();
        Viscosity { viscosity, longest_step: viscous_limit(fluid, world) }
    }
}

impl Force for Viscosity {
    fn name(&self) -> &'static str {
        "viscosity"
    }

    fn longest_step(&self) -> f64 {
        self.longest_step
    }

    fn accelerate(
        &mut self,
        step: &ForceStep,
        velocities: &[Quad],
        _: &mut Channels,
        accelerations: &mut [Quad],
    ) {
        if self.viscosity == 0.0 {
            return;
        }
        add_sums(step, velocities, self.viscosity as f32, laplacian, accelerations);
    }
}

/// The longest step, seconds, in which explicit viscosity calms and doesn't excite; infinite without.
///
/// A step takes nu dt S (v_i - mean of v_j) from a velocity, S the sum of the weights of Eq. 16 of Bender et al. 2020:
/// ```text
/// S = 10 V sum |W'| / |x|  ->  40 pi integral of |W'(s)| s ds = 40 pi integral of W(s) ds  (0..r),
/// ```
/// which is 120 / r^2 for the cubic spline; in two dimensions 8 for 10, and 16 pi W(0), which is 91 / r^2. More than
/// the whole difference must not go: nu dt S <= 1, of which XSPH takes its part.
pub fn viscous_limit(fluid: &FluidSettings, world: &World) -> f64 {
    let [explicit, _] = fluid.viscosities();
    (1.0 - 0.5 * fluid.xsph) / (explicit * viscous_weights(world))
}

/// S of [`viscous_limit`], 1/m^2.
pub fn viscous_weights(world: &World) -> f64 {
    let in_radius = match world.dimension {
        Dimension::Two => 16.0 * PI * world.kernel.plane_thickness() * world.kernel.unit_value(0.0),
        Dimension::Three => 40.0 * world.kernel.line_integral(),
    };
    in_radius / (world.support_radius * world.support_radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::ViscosityMethod;
    use volmap_runtime::KernelKind;

    #[test]
    fn line_integrals_are_the_kernels() {
        let fluid = FluidSettings { viscosity: 2.0, xsph: 0.5, ..FluidSettings::default() };
        for kind in KernelKind::ALL {
            const STEPS: u32 = 20_000;
            let sum: f64 = (0..STEPS).map(|n| kind.unit_value((f64::from(n) + 0.5) / f64::from(STEPS))).sum();
            let weights = 40.0 * PI * sum / f64::from(STEPS) / 0.01;
            let world = World { kernel: kind, support_radius: 0.1, ..World::default() };
            let limit = viscous_limit(&fluid, &world);
            assert!((limit * 2.0 * weights / 0.75 - 1.0).abs() < 1e-6, "{kind}: {limit}");
            // 8 sum of A |W'| / |x| in the plane: 16 pi integral of |W'|.
            let kernel = volmap_runtime::Kernel::in_plane(kind, 0.1);
            let slope = |n: u32| -kernel.derivative(0.1 * (f64::from(n) + 0.5) / f64::from(STEPS));
            let weights = 16.0 * PI * (0..STEPS).map(slope).sum::<f64>() * 0.1 / f64::from(STEPS);
            let limit = viscous_limit(&fluid, &World { dimension: Dimension::Two, ..world });
            assert!((limit * 2.0 * weights / 0.75 - 1.0).abs() < 1e-6, "{kind} in the plane: {limit}");
        }
        let implicit = FluidSettings { viscosity_method: ViscosityMethod::Implicit, ..fluid.clone() };
        for none in [implicit, FluidSettings { viscosity: 0.0, ..fluid }] {
            assert_eq!(viscous_limit(&none, &World::default()), f64::INFINITY);
        }
    }
}
