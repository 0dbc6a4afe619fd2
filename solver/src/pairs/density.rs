//! Density, the slopes of the kernel for all other sums, and the factor of the Jacobi step: Eq. 6 of Bender et al. 2020, alpha of Band et al. 2018, Algorithm 1.

use super::kernels::KernelLanes;
use super::lanes::{Lanes, Quad};
use super::{Difference, KernelWork, Pairs, add_scaled, splat, sums};
use crate::neighbours::Lists;

/// What a particle's fluid neighbours amount to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Density {
    /// The sum of V W, the particle itself included: relative density.
    pub density: f32,
    /// The sum of V grad W, 1/m.
    pub gradient: [f32; 3],
    /// The sum of |V grad W|^2, 1/m^2.
    pub squares: f32,
}

pub(super) struct Work<'a> {
    pub pairs: Pairs<'a>,
    pub lists: &'a mut Lists,
    pub out: &'a mut [Density],
}

impl KernelWork for Work<'_> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let (of_density, of_gradient) = (self.pairs.density_scale::<K>(), self.pairs.gradient_scale::<K>());
        for (within, out) in self.out.iter_mut().enumerate() {
            let at: Quad = self.pairs.places[self.lists.first + within];
            let at = splat::<V>(at);
            let zero = V::splat(0.0);
            let (mut values, mut gradient, mut squares) = (zero, [zero; 3], zero);
            for (group, slopes) in self.lists.pairs_mut(within) {
                let to = Difference::new(self.pairs.places, at, group);
                let (value, slope) = K::both(to.square);
                *slopes = slope.array();
                values = values + value;
                gradient = add_scaled(gradient, slope, to.x);
                squares = squares + slope * slope * to.square;
            }
            out.density = of_density * values.sum();
            out.gradient = sums(of_gradient, gradient);
            out.squares = of_gradient * of_gradient * squares.sum();
        }
    }
}
