//! How fast a vector field compresses the fluid: the sum of V (u_i - u_j) . grad W_ij, which is dD/dt for a velocity.

use super::kernels::KernelLanes;
use super::lanes::{Lanes, Quad};
use super::{Difference, KernelWork, Pairs, dot, splat};
use crate::neighbours::Lists;

pub(super) struct Work<'a> {
    pub pairs: Pairs<'a>,
    pub lists: &'a Lists,
    pub field: &'a [Quad],
    pub out: &'a mut [f32],
}

impl KernelWork for Work<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let scale = self.pairs.gradient_scale::<K>();
        for (within, out) in self.out.iter_mut().enumerate() {
            let particle = self.lists.first + within;
            let (at, own) = (splat::<V>(self.pairs.places[particle]), splat::<V>(self.field[particle]));
            let mut sum = V::splat(0.0);
            for (group, slopes) in self.lists.pairs(within) {
                let (to, [u, v, w, _]) = Difference::with_field(self.pairs.places, self.field, at, group);
                sum = sum + V::load(slopes) * dot([own[0] - u, own[1] - v, own[2] - w], to.x);
            }
            *out = scale * sum.sum();
        }
    }
}
