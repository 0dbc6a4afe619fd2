//! The time step by the condition of Courant, Friedrichs and Lewy (Monaghan 1992; Bender and Koschier 2017, section 4),
//! and by that of explicit viscosity.

use crate::settings::{FluidSettings, TimeStepSettings, World};
use std::f64::consts::PI;
use volmap_runtime::Dimension;

/// A particle may cross this part of its diameter in a step, at a CFL factor of 1.
const PART_OF_DIAMETER: f64 = 0.4;

/// The step for a largest speed (m/s), seconds; `most` is [`viscous_limit`].
pub fn time_step(settings: &TimeStepSettings, particle_radius: f64, max_speed: f64, most: f64) -> f64 {
    if !settings.adaptive {
        return settings.initial;
    }
    let step = settings.cfl_factor * PART_OF_DIAMETER * 2.0 * particle_radius / max_speed;
    // A fluid at rest gives infinity.
    step.min(settings.max).min(most).max(settings.min)
}

/// The longest step, seconds, in which explicit viscosity calms and doesn't excite; infinite without.
///
/// A step takes nu dt S (v_i - mean of v_j) from a velocity, S the sum of the weights of Eq. 16 of Bender et al. 2020:
/// ```text
/// S = 10 V sum |W'| / |x|  ->  40 pi integral of |W'(s)| s ds = 40 pi integral of W(s) ds  (0..r),
/// ```
/// which is 120 / r^2 for the cubic spline; in two dimensions 8 for 10, and 16 pi W(0), which is 91 / r^2. More than the whole difference must not go: nu dt S <= 1, of which XSPH takes
/// its part.
pub fn viscous_limit(fluid: &FluidSettings, world: &World) -> f64 {
    let in_radius = match world.dimension {
        Dimension::Two => 16.0 * PI * world.kernel.plane_thickness() * world.kernel.unit_value(0.0),
        Dimension::Three => 40.0 * world.kernel.line_integral(),
    };
    let weights = in_radius / (world.support_radius * world.support_radius);
    let [explicit, _] = fluid.viscosities();
    (1.0 - 0.5 * fluid.xsph) / (explicit * weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::ViscosityMethod;
    use volmap_runtime::KernelKind;

    #[test]
    fn step_keeps_its_bounds() {
        let settings =
            TimeStepSettings { cfl_factor: 0.5, min: 1e-4, max: 5e-3, ..TimeStepSettings::default() };
        let step = |speed| time_step(&settings, 0.025, speed, f64::INFINITY);
        assert_eq!(step(0.0), 5e-3);
        assert!((step(10.0) - 1e-3).abs() < 1e-12, "0.5 * 0.4 * 0.05 m in 10 m/s");
        assert_eq!(step(1e9), 1e-4);
        assert_eq!(step(f64::INFINITY), 1e-4);
        assert_eq!(time_step(&settings, 0.025, 0.0, 2e-3), 2e-3);
        let fixed = TimeStepSettings { adaptive: false, initial: 7e-3, ..settings };
        assert_eq!(time_step(&fixed, 0.025, 1e9, 2e-3), 7e-3);
    }

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
