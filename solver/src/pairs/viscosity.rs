//! Viscosity: the Laplacian of the velocity by Eq. 16 of Bender et al. 2020 (Monaghan 2005), and the mean of the
//! velocity differences of XSPH (Schechter and Bridson 2012). Both conserve momentum: particles have one volume.

use super::kernels::KernelLanes;
use super::lanes::{Lanes, Quad};
use super::{Difference, KernelWork, Pairs, add_scaled, dot, splat, sums};
use crate::neighbours::Lists;

/// What is added to the square of a distance in support radii, 0.01 h^2 of Eq. 16.
pub(super) const SMALL: f32 = 0.01;

pub(super) struct Work<'a> {
    pub pairs: Pairs<'a>,
    pub lists: &'a Lists,
    pub velocities: &'a [Quad],
    pub out: &'a mut [[[f32; 3]; 2]],
}

impl KernelWork for Work<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let (of_density, of_laplacian) = (self.pairs.density_scale::<K>(), self.pairs.laplacian_scale::<K>());
        let small = V::splat(SMALL);
        for (within, out) in self.out.iter_mut().enumerate() {
            let particle = self.lists.first + within;
            let (at, own) = (splat::<V>(self.pairs.places[particle]), splat::<V>(self.velocities[particle]));
            let (mut laplacian, mut mean) = ([V::splat(0.0); 3], [V::splat(0.0); 3]);
            for (group, slopes) in self.lists.pairs(within) {
                let (to, [u, v, w, _]) =
                    Difference::with_field(self.pairs.places, self.velocities, at, group);
                let apart = [own[0] - u, own[1] - v, own[2] - w];
                laplacian =
                    add_scaled(laplacian, V::load(slopes) * dot(apart, to.x) / (to.square + small), to.x);
                mean = add_scaled(mean, K::value(to.square), apart);
            }
            *out = [sums(of_laplacian, laplacian), sums(-of_density, mean)];
        }
    }
}
