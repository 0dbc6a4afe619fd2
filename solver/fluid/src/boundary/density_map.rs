//! Boundaries by density maps: Koschier and Bender 2017, *Density Maps for Improved SPH Boundary Handling*; Bender et
//! al. 2020, Eq. 9 and 11. The map holds the density itself, for one kernel; its gradient is that of the shape
//! functions, and jumps between cells. A contact for each particle and body, at the closest point of the surface.

use super::{Contact, Pairing, Scratch};
use crate::bodies::Bodies;
use crate::error::Error;
use volmap_bake::density_map::KERNELS;
use volmap_runtime::{KernelKind, Sample};

/// Where gamma of Eq. 11 becomes 0, in support radii: as the authors' own program has it. With the paper's 1, a
/// wall's density is 1 at its surface and reaches 2 r: fluid a spacing from a wall is thrown off.
pub const EXTENSION: f64 = 0.2;

/// What is wrong with the density of a map for this kernel, if anything.
pub fn defect(density_kernel: Option<KernelKind>, kernel: KernelKind) -> Option<String> {
    if !KERNELS.contains(&kernel) {
        let known = KERNELS.map(KernelKind::name).join(" and ");
        return Some(format!("density maps are baked for {known}, not for {kernel}"));
    }
    match density_kernel {
        Some(own) if own == kernel => None,
        Some(own) => Some(format!("its density is that of the kernel {own}, the scene's is {kernel}")),
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
    for (within, (sample, density)) in samples.iter().zip(densities).enumerate() {
        let (Sample::Near(near), Some(density)) = (sample, density) else { continue };
        // Interpolated, it may be a little below zero.
        if density.value > 0.0 {
            contacts.push(pairing.contact(
                within,
                density.value,
                density.gradient,
                near.surface.closest_point,
            ));
        }
    }
}
