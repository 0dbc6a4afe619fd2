//! Boundaries by volume maps: Bender et al. 2020, section 4.3. Distance, closest point and volume become a density and
//! its gradient by a closure (Eq. 14 and 15, or better ones); a contact for each particle and body.

use super::{Contact, Pairing};
use volmap_runtime::{Closure, ClosureKind, DVec3, Sample};

/// Adds the contacts of a chunk; `samples` are what the map says of its particles.
pub(super) fn touch(
    pairing: Pairing,
    closure: &Closure,
    samples: &[(Sample, DVec3)],
    contacts: &mut Vec<Contact>,
) {
    let map = pairing.map();
    let distance = |point| map.values(point).distance;
    for (within, (sample, volume_gradient)) in samples.iter().enumerate() {
        let (Sample::Near(near), position) = (sample, pairing.positions[within]) else { continue };
        if let Some(density) = closure.density_probing(near, Some(*volume_gradient), position, distance) {
            contacts.push(pairing.contact(within, density.density, density.gradient, density.point));
        }
    }
}

/// Edge of the cells of the maps that a closure takes for a kernel's support radius, metres. Where two walls meet, the
/// map's distance is too small by up to a quarter of a cell, and closures that go by it need cells half as large as the
/// baker's; `mirror` goes by the volume.
pub fn cell_size(closure: ClosureKind, support_radius: f64) -> f64 {
    let cells_per_radius = if closure == ClosureKind::Mirror { 2.0 } else { 4.0 };
    closure.map_radius(support_radius) / cells_per_radius
}

/// The same for bodies that turn by themselves. Between its nodes a map's wall is rough by some thousandths of the particle
/// radius; one that turns stirs the fluid by that (see `sphere` in VALIDATION.md), the less the smaller its cells are.
pub fn cell_size_of_turning(closure: ClosureKind, support_radius: f64) -> f64 {
    let finer = if closure == ClosureKind::Mirror { 2.0 / 3.0 } else { 1.0 };
    finer * cell_size(closure, support_radius)
}
