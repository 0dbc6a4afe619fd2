//! Acceleration by pressure, the part of the fluid: Eq. 1 of Band et al. 2018.

use super::kernels::KernelLanes;
use super::lanes::Lanes;
use super::{Difference, KernelWork, Pairs, add_scaled, splat, sums};
use crate::neighbours::Lists;

pub(super) struct Work<'a> {
    pub pairs: Pairs<'a>,
    pub lists: &'a Lists,
    pub out: &'a mut [[f32; 3]],
}

impl KernelWork for Work<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let scale = -self.pairs.gradient_scale::<K>();
        for (within, out) in self.out.iter_mut().enumerate() {
            let own = self.pairs.places[self.lists.first + within];
            let (at, pressure) = (splat::<V>(own), V::splat(own[3]));
            let mut sum = [V::splat(0.0); 3];
            for (group, slopes) in self.lists.pairs(within) {
                let to = Difference::new(self.pairs.places, at, group);
                sum = add_scaled(sum, V::load(slopes) * (pressure + to.fourth), to.x);
            }
            *out = sums(scale, sum);
        }
    }
}
