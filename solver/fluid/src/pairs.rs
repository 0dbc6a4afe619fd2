//! Pairs of neighbours, and the sums over them: all that the solver asks of who is near whom.
//!
//! A pair is what one particle is to another, V grad W_ij in fixed point, and where the other's values stand in a
//! table. Eight bytes: a sum reads them one after the other, and of the other particle one quad.
//!
//! ```text
//! bytes  0 1   2 3   4 5   6 7
//!        grad W_ij         place        Pair: i16 three times, u16
//!        x     y     z
//! ```
//!
//! Pairs stand in rows of eight, one for each of eight particles, a slice; the particles of a slice have about as
//! many neighbours (Kreutzer et al. 2014, *A Unified Sparse Matrix Data Format*, SELL-C-sigma with C = 8). Where one
//! has fewer, pairs of no gradient fill its place.
//!
//! ```text
//! row 0:  pair of particle a, of b, .. of h      64 bytes
//! row 1:  second pair of a, ..
//! ```
//!
//! Fixed point: the largest gradient that a kernel has is some 32,000, so that a pair is exact to 2e-5 of it; grad
//! W_ij is exactly -grad W_ji, and sums of some hundreds of them are exact. The factor is V, the kernel's largest
//! slope and the radius.

#[cfg(target_arch = "x86_64")]
mod avx2;
pub(crate) mod kernels;
pub(crate) mod lanes;
pub mod lists;
pub(crate) mod sums;
pub(crate) mod table;
pub(crate) mod velocities;
pub(crate) mod workspace;

use crate::discretization::Discretization;
use kernels::{CubicSpline, KernelLanes, Poly6, Spiky, WendlandC2};
use lanes::{Lanes, Vectorized};
use volmap_runtime::KernelKind;

/// A pair: gradient, and twice the number of the other particle in the block's table.
pub type Pair = [i16; 4];
/// Particles of a slice.
pub const SLICE: usize = 8;

/// A pair of each particle of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Row(pub [Pair; SLICE]);

/// The largest number of a pair, which rounding doesn't raise above that of 16 bits.
const LARGEST: f32 = 32_766.0;

/// Four numbers of a particle, which are read together: a place or a vector, and 0.
pub type Quad = [f32; 4];

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub type Symmetric = [f32; 6];

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

/// From sums in support radii, and from numbers of pairs, to metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Units {
    /// Sums of w to densities: V NORM / r^3 / S, with S of [`Discretization::rest_sum`].
    pub density: f32,
    /// Sums of slope x to V grad W / S: V SLOPE_NORM SLOPE / r^4 / S, times [`Discretization::gradient_scale`].
    pub gradient: f32,
    /// Slope x to a pair's numbers.
    pub pair: f32,
    /// A pair's numbers to V grad W.
    pub of_pair: f32,
    /// x (|slope| / (x^2 + 0.01))^1/2 to a bend's numbers.
    pub bend: f32,
    /// Products of two of them to the Laplacian, Eq. 16 of Bender et al. 2020; positive.
    pub of_bend: f32,
    /// Sums of slope (u . x) x / (x^2 + 0.01) to the Laplacian of -u; with the sign of the slope.
    pub laplacian: f32,
}

impl Units {
    pub(crate) fn new<K: KernelLanes>(with: Discretization) -> Units {
        let radius = with.support_radius;
        let [plain, steep] =
            [K::NORM, K::SLOPE_NORM].map(|norm| with.volume * f64::from(norm) / radius.powi(3));
        let density = plain / with.rest_sum;
        let gradient = with.gradient_scale * (steep / with.rest_sum) * f64::from(K::SLOPE) / radius;
        let [pair, bend] = [K::STEEPEST, K::BENDIEST].map(|largest| LARGEST / largest);
        // x . x and x are in support radii, of which one is left over. The particle itself adds nothing to it.
        let steep = steep * f64::from(K::SLOPE) / radius;
        let laplacian = 2.0 * (with.dimension.count() as f64 + 2.0) * steep / radius;
        Units {
            density: density as f32,
            gradient: gradient as f32,
            pair,
            of_pair: (gradient / f64::from(pair)) as f32,
            bend,
            of_bend: (laplacian.abs() / f64::from(bend).powi(2)) as f32,
            laplacian: -laplacian as f32,
        }
    }
}

/// Does the work with the widest vectors that this processor has.
#[inline]
pub(crate) fn dispatch(work: impl Vectorized) {
    #[cfg(target_arch = "x86_64")]
    let Some(work) = avx2::run(work) else { return };
    work.run::<lanes::Plain>();
}

/// What can be done with any kernel on any lanes.
pub(crate) trait WorkOfKernel {
    /// Must be inlined, to be compiled for the processor that has the lanes.
    fn run<V: Lanes, K: KernelLanes>(self);
}

/// That with one kernel.
pub(crate) struct WithKernel<W> {
    pub kernel: KernelKind,
    pub work: W,
}

impl<W: WorkOfKernel> Vectorized for WithKernel<W> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        match self.kernel {
            KernelKind::CubicSpline => self.work.run::<V, CubicSpline>(),
            KernelKind::WendlandC2 => self.work.run::<V, WendlandC2>(),
            KernelKind::Spiky => self.work.run::<V, Spiky>(),
            KernelKind::Poly6 => self.work.run::<V, Poly6>(),
        }
    }
}

#[cfg(test)]
mod tests;
