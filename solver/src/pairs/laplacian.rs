//! What implicit viscosity asks of the pairs: the Laplacian of Eq. 16 of Bender et al. 2020 (Monaghan 2005) of any vector
//! field, and by which matrix a particle's own value enters its own Laplacian.

use super::kernels::KernelLanes;
use super::lanes::{Lanes, Quad};
use super::viscosity::SMALL;
use super::{Difference, KernelWork, Pairs, add_scaled, dot, splat, sums};
use crate::neighbours::Lists;

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub type Symmetric = [f32; 6];

pub(super) struct Work<'a> {
    pub pairs: Pairs<'a>,
    pub lists: &'a Lists,
    pub field: &'a [Quad],
    pub out: &'a mut [[f32; 3]],
}

impl KernelWork for Work<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let scale = self.pairs.laplacian_scale::<K>();
        let small = V::splat(SMALL);
        for (within, out) in self.out.iter_mut().enumerate() {
            let particle = self.lists.first + within;
            let (at, own) = (splat::<V>(self.pairs.places[particle]), splat::<V>(self.field[particle]));
            let mut sum = [V::splat(0.0); 3];
            for (group, slopes) in self.lists.pairs(within) {
                let (to, [u, v, w, _]) = Difference::with_field(self.pairs.places, self.field, at, group);
                let apart = [own[0] - u, own[1] - v, own[2] - w];
                sum = add_scaled(sum, V::load(slopes) * dot(apart, to.x) / (to.square + small), to.x);
            }
            *out = sums(scale, sum);
        }
    }
}

pub(super) struct OwnPart<'a> {
    pub pairs: Pairs<'a>,
    pub lists: &'a Lists,
    pub out: &'a mut [Symmetric],
}

impl KernelWork for OwnPart<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let scale = self.pairs.laplacian_scale::<K>();
        let small = V::splat(SMALL);
        for (within, out) in self.out.iter_mut().enumerate() {
            let at = splat::<V>(self.pairs.places[self.lists.first + within]);
            let (mut squares, mut products) = ([V::splat(0.0); 3], [V::splat(0.0); 3]);
            for (group, slopes) in self.lists.pairs(within) {
                let Difference { x: [x, y, z], square, .. } = Difference::new(self.pairs.places, at, group);
                let weight = V::load(slopes) / (square + small);
                squares = add_scaled(squares, weight, [x * x, y * y, z * z]);
                products = add_scaled(products, weight, [x * y, x * z, y * z]);
            }
            let ([xx, yy, zz], [xy, xz, yz]) = (sums(scale, squares), sums(scale, products));
            *out = [xx, yy, zz, xy, xz, yz];
        }
    }
}
