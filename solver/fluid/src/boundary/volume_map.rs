//! Boundaries by volume maps: Bender et al. 2020, section 4.3. Distance, closest point and volume become a density and
//! its gradient by a closure (Eq. 14 and 15, or better ones); a contact for each particle and body.

use super::{Contact, Pairing};
use volmap_runtime::{Closure, Sample, SurfaceWithGradient};

/// Adds the contacts of a chunk; `samples` are what the map says of its particles.
pub(super) fn touch(
    pairing: Pairing,
    closure: &Closure,
    samples: &[Sample<SurfaceWithGradient>],
    contacts: &mut Vec<Contact>,
) {
    let map = pairing.map();
    let distance = |point| map.values(point).distance;
    for (within, sample) in samples.iter().enumerate() {
        let (Sample::Near(near), position) = (sample, pairing.positions[within]) else { continue };
        if let Some(density) = closure.density_probing(near, position, distance) {
            contacts.push(pairing.contact(within, density.density, density.gradient, density.point));
        }
    }
}
