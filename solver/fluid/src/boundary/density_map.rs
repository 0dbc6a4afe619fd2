//! Boundaries by density maps: Koschier and Bender 2017, *Density Maps for Improved SPH Boundary Handling*; Bender et al.
//! 2020, Eq. 9 and 11. The map holds the density itself, for one kernel; its gradient is that of the shape functions, and
//! jumps between cells. A contact for each particle and body, at the closest point of the surface.

use super::{Contact, Pairing, Scratch};
use crate::bodies::Bodies;
use crate::error::Error;
use volmap_bake::density_map::smoothing::Smoothing;
use volmap_runtime::{KernelKind, Sample};

/// Where gamma of Eq. 11 becomes 0, in support radii: as the authors' own program has it. With the paper's 1, a wall's density
/// is 1 at its surface and reaches 2 r: fluid a spacing from a wall is thrown off.
pub const EXTENSION: f64 = 0.2;

/// The baker's name for a kernel; none if it bakes no density for it.
pub fn smoothing(kernel: KernelKind) -> Option<Smoothing> {
    match kernel {
        KernelKind::CubicSpline => Some(Smoothing::CubicSpline),
        KernelKind::WendlandC2 => Some(Smoothing::WendlandC2),
        KernelKind::Spiky | KernelKind::Poly6 => None,
    }
}

/// What is wrong with the density of a map for this kernel, if anything.
pub fn defect(density_kernel: Option<&str>, kernel: KernelKind) -> Option<String> {
    let Some(needed) = smoothing(kernel) else {
        return Some(format!("density maps are baked for cubic-spline and wendland-c2, not for {kernel}"));
    };
    match density_kernel {
        Some(name) if name.parse() == Ok(needed) => None,
        Some(name) => Some(format!("its density is that of the kernel {name}, the scene's is {needed}")),
        None => Some("it holds no density".into()),
    }
}

/// Checks that every map has the density of this kernel.
pub(super) fn check(bodies: &Bodies, kernel: KernelKind) -> Result<(), Error> {
    for (body, posed) in bodies.posed().iter().enumerate() {
        if let Some(defect) = defect(posed.map.density_kernel(), kernel) {
            let reason = format!("its map can't be used with boundary = \"density_map\": {defect}");
            return Err(Error::Setup { place: format!("body `{}`", bodies.name(body)), reason });
        }
    }
    Ok(())
}

/// Adds the contacts of a chunk.
pub(super) fn touch(pairing: Pairing, scratch: &mut Scratch, contacts: &mut Vec<Contact>) {
    let Scratch { samples, densities, .. } = scratch;
    pairing.map().sample_batch(pairing.positions, densities);
    for (within, ((sample, _), density)) in samples.iter().zip(densities).enumerate() {
        let (Sample::Near(near), Some(density)) = (sample, density) else { continue };
        // Interpolated, it may be a little below zero.
        if density.value > 0.0 {
            contacts.push(pairing.contact(within, density.value, density.gradient, near.closest_point));
        }
    }
}
