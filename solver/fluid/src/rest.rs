//! The lattice in which a fluid rests, and what the kernel's sums amount to on it.
//!
//! Particles of volume V = a^3 fill space in a cubic lattice of spacing a. There the sum of V W over a particle's
//! neighbours, itself included, is not 1 but
//! ```text
//! S = a^3 sum over the lattice of W       (KernelKind::lattice_sum)
//! ```
//! which is 1.0000 for the cubic spline with r = 4 rp, and 1.03 for Wendland's kernel, 1.24 for the spiky one, 1.09 for
//! the cubic spline with r = 3 rp. So every density, gradient and pressure force is by the kernel W / S: the sums have
//! V / S = 1 / sum of W for a particle's volume, and what a map's integral of W says of the boundary is divided by S.
//! Then a lattice has the rest density exactly, whatever the kernel and its support radius. Masses are rho_0 V, and
//! viscosity and the bodies' drag, to which a particle itself adds nothing, have the plain V.
//!
//! The slope of poly6 vanishes around its centre: by it, particles come together in pairs, and water stands an eighth
//! too low. Müller et al. 2003, who made it, take densities by it and forces by the spiky kernel's gradient, and so
//! does this; scaled, so that an even compression of the lattice changes the density as fast as it really does.

use crate::settings::{BoundaryMethod, BoundaryPressure, FluidSettings, World};
use std::f64::consts::PI;
use volmap_runtime::{ClosureKind, DVec3, Dimension, KernelKind};

/// A sum so near to 1 stays 1: a fifth of what the solves leave of an error. It is for the default, whose sum is
/// 0.99997.
const AS_GOOD_AS_1: f64 = 1e-4;

/// Stiffness of a lattice up to which the relaxation is as given: Jacobi steps of omega = 0.5, the default, converge up
/// to 4. 2.8 of the default lattice.
const SOFT: f64 = 3.2;
/// That of the default, in support radii.
const DEFAULT_SPACING: f64 = 0.5;
/// Waves along each axis among which the stiffest is looked for.
const WAVES: i32 = 8;

/// Support radii, in particle radii, with which water at rest is calm and has the pressure of its depth, if there are
/// any (solver/VALIDATION.md, Kernels). Simulations run with others, too.
pub fn calm_radii(kernel: KernelKind) -> Option<[f64; 2]> {
    match kernel {
        KernelKind::CubicSpline => Some([3.5, 4.0]),
        KernelKind::WendlandC2 | KernelKind::Spiky => Some([3.5, 10.0]),
        KernelKind::Poly6 => None,
    }
}

impl World {
    /// The edge of a cube (a square) of a particle's volume, metres: the spacing of the fluid's lattice at rest. 2 rp,
    /// but for particles of more or less volume.
    pub fn rest_spacing(&self, fluid: &FluidSettings) -> f64 {
        2.0 * (self.particle_radius * fluid.volume_factor.powf(1.0 / self.dimension.count() as f64))
    }

    /// How far from walls the fluid's first layer rests, metres: particles that begin nearer are pushed away. Measured
    /// with the default kernel and r = 4 rp (solver/METHODS.md, combinations); of wider ones in proportion. rp where it
    /// would sink nearer.
    pub fn resting_distance(&self, pressure: BoundaryPressure) -> f64 {
        let is_own = pressure == BoundaryPressure::Own;
        let of = |own: f64, other: f64| if is_own { own } else { other };
        let radii = match (self.boundary, self.closure) {
            (BoundaryMethod::VolumeMap, ClosureKind::Offset) => of(2.35, 2.59),
            (BoundaryMethod::VolumeMap, ClosureKind::Paper) => of(2.83, 3.06),
            (BoundaryMethod::VolumeMap, _) => 1.0,
            (BoundaryMethod::DensityMap, _) => of(1.23, 1.9),
            (BoundaryMethod::TubeMap, _) => of(1.34, 1.73),
            (BoundaryMethod::Particles, _) => of(1.86, 2.32),
        };
        let scale = (self.support_radius / (4.0 * self.particle_radius)).max(1.0);
        self.particle_radius * if radii > 1.0 { radii * scale } else { 1.0 }
    }

    /// S: the kernel's sum over the fluid's lattice at rest, by which densities are divided.
    pub fn rest_sum(&self, fluid: &FluidSettings) -> f64 {
        let spacing = self.rest_spacing(fluid) / self.support_radius;
        let sum = self.kernel.lattice_sum(self.dimension, spacing);
        if (sum - 1.0).abs() < AS_GOOD_AS_1 { 1.0 } else { sum }
    }

    /// omega of the Jacobi steps for a relaxation that was given. A wider kernel has more neighbours, whose pressures
    /// all push the same particle: the pressure solve is then stiffer than its diagonal says, and steps that are right
    /// with r = 4 rp overshoot until the fluid bursts.
    pub fn jacobi_relaxation(&self, fluid: &FluidSettings, relaxation: f64) -> f64 {
        relaxation * (SOFT / self.stiffness(fluid)).min(1.0)
    }

    /// What pressures of the solves are multiplied by to be those of the fluid. A lattice's sums answer a compression
    /// by less than a continuum's, the less of a density is the neighbours': the solves make up for it by more
    /// pressure, and forces are right. By
    /// ```text
    /// f = V / 3 sum of |W'| |x|    (1 in a continuum)
    /// ```
    /// over S, in parts of what the default has: water at rest has the pressure of its depth by it, as it has with the
    /// default, whose own f is 1.02.
    pub fn pressure_scale(&self, fluid: &FluidSettings) -> f64 {
        let spacing = self.rest_spacing(fluid) / self.support_radius;
        let response = |kernel: KernelKind, spacing: f64| {
            kernel.lattice_response(self.dimension, spacing) / kernel.lattice_sum(self.dimension, spacing)
        };
        response(self.kernel, spacing) / response(KernelKind::CubicSpline, DEFAULT_SPACING)
    }

    /// What gradients of [`KernelKind::of_gradients`] are multiplied by, for the density to change by them as it does
    /// when the lattice at rest is compressed: 1 where they are the kernel's own.
    pub fn gradient_scale(&self, fluid: &FluidSettings) -> f64 {
        let spacing = self.rest_spacing(fluid) / self.support_radius;
        let response = |kernel: KernelKind| kernel.lattice_response(self.dimension, spacing);
        let of = self.kernel.of_gradients();
        if of == self.kernel { 1.0 } else { response(self.kernel) / response(of) }
    }

    /// Stiffness of the pressure solve on the lattice at rest: the largest eigenvalue of its matrix over the diagonal.
    /// Jacobi steps of omega converge where omega times it is below 2. A wave of pressure of wave vector k has
    /// ```text
    /// |sum of grad W sin(k x)|^2 / sum of |grad W|^2
    /// ```
    fn stiffness(&self, fluid: &FluidSettings) -> f64 {
        let gradients = self.gradients(self.rest_spacing(fluid) / self.support_radius);
        let diagonal: f64 = gradients.iter().map(|(_, gradient)| gradient.length_squared()).sum();
        let flat = self.dimension == Dimension::Two;
        let mut largest = 0.0_f64;
        for x in 1..=WAVES {
            for y in 0..=x {
                for z in 0..=if flat { 0 } else { y } {
                    let wave = PI / f64::from(WAVES) * DVec3::new(x.into(), y.into(), z.into());
                    let sum: DVec3 =
                        gradients.iter().map(|(at, gradient)| wave.dot(*at).sin() * gradient).sum();
                    largest = largest.max(sum.length_squared());
                }
            }
        }
        // A lattice without neighbours has no pressure either.
        if diagonal > 0.0 { largest / diagonal } else { 0.0 }
    }

    /// The neighbours of a lattice's point: where they are, in spacings, and the kernel's gradient.
    fn gradients(&self, spacing: f64) -> Vec<(DVec3, DVec3)> {
        let reach = (1.0 / spacing).min(FARTHEST) as i32;
        let depth = if self.dimension == Dimension::Two { 0 } else { reach };
        let mut out = Vec::new();
        for x in -reach..=reach {
            for y in -reach..=reach {
                for z in -depth..=depth {
                    let at = DVec3::new(x.into(), y.into(), z.into());
                    let distance = at.length();
                    let slope = self.kernel.of_gradients().unit_derivative(spacing * distance);
                    if distance > 0.0 && slope < 0.0 {
                        out.push((at, slope / distance * at));
                    }
                }
            }
        }
        out
    }
}

/// Spacings in a support radius beyond which neighbours aren't looked at: scenes allow 5.
const FARTHEST: f64 = 8.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn world(kernel: KernelKind, radii: f64) -> World {
        World { kernel, support_radius: radii * 0.025, particle_radius: 0.025, ..World::default() }
    }

    #[test]
    fn the_default_is_left_as_it_is() {
        let (world, fluid) = (World::default(), FluidSettings::default());
        assert_eq!(world.rest_sum(&fluid), 1.0);
        assert_eq!(world.jacobi_relaxation(&fluid, 0.5), 0.5);
        assert_eq!(world.rest_spacing(&fluid), 0.05);
        assert_eq!(world.pressure_scale(&fluid), 1.0);
    }

    #[test]
    fn jacobi_steps_converge_on_every_lattice() {
        for kernel in KernelKind::ALL {
            for radii in [3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 8.0] {
                let (world, fluid) = (world(kernel, radii), FluidSettings::default());
                let omega = world.jacobi_relaxation(&fluid, 0.5);
                let product = omega * world.stiffness(&fluid);
                assert!(omega > 0.02 && product < 1.65, "{kernel}, {radii}: {omega} {product}");
            }
        }
    }

    #[test]
    fn a_compressed_lattice_changes_as_its_gradients_say() {
        for radii in [3.5, 4.0, 4.5, 5.0] {
            let (world, fluid) = (world(KernelKind::Poly6, radii), FluidSettings::default());
            let spacing = world.rest_spacing(&fluid) / world.support_radius;
            // dD/dt for x' = -x / 3, by gradients of the spiky kernel; and by the density itself.
            let by_gradients: f64 =
                world.gradients(spacing).iter().map(|(at, gradient)| -at.dot(*gradient) / 3.0).sum();
            let by_gradients = world.gradient_scale(&fluid) * spacing.powi(4) * by_gradients;
            let density = |part: f64| {
                let sum = KernelKind::Poly6.lattice_sum(Dimension::Three, part * spacing);
                sum / part.powi(3)
            };
            let slope = (density(1.0 - 1e-5) - density(1.0 + 1e-5)) / (2e-5 * 3.0);
            assert!((by_gradients / slope - 1.0).abs() < 1e-3, "{radii}: {by_gradients} {slope}");
            assert_eq!(self::world(KernelKind::Spiky, radii).gradient_scale(&fluid), 1.0);
        }
    }

    #[test]
    fn sums_are_those_of_the_volume() {
        // Half the volume: a closer lattice, of which more is in reach.
        let fluid = FluidSettings { volume_factor: 0.125, ..FluidSettings::default() };
        let world = world(KernelKind::WendlandC2, 4.0);
        assert!((world.rest_spacing(&fluid) - 0.025).abs() < 1e-12);
        let sum = KernelKind::WendlandC2.lattice_sum(Dimension::Three, 0.25);
        assert!((world.rest_sum(&fluid) - sum).abs() < 1e-12);
    }
}
