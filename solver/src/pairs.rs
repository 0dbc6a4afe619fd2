//! Sums over neighbours, eight pairs at a time: density, flux of a vector field, acceleration by pressure, viscosity and
//! the Laplacian.
//!
//! Places are in support radii from an origin near the fluid, so that single precision is enough; the sums come out
//! in metres. Particles have one volume V. D is the relative density, rho / rho_0.

mod acceleration;
#[cfg(target_arch = "x86_64")]
mod avx2;
mod density;
mod flux;
mod kernels;
pub(crate) mod lanes;
mod laplacian;
mod viscosity;

use crate::fields::Discretization;
use crate::neighbours::{CHUNK, Lists};
use kernels::{CubicSpline, KernelLanes, Poly6, Spiky, WendlandC2};
use lanes::{Group, Lanes, Quad, Work, dispatch};
use volmap_runtime::KernelKind;

pub use density::Density;
pub use laplacian::Symmetric;

/// What all sums share.
#[derive(Clone, Copy, Debug)]
pub struct Pairs<'a> {
    /// What the sums are made with.
    pub with: Discretization,
    /// Places in support radii and a fourth number, P where pressure is asked for; one more than particles are, the
    /// last one far from all.
    pub places: &'a [Quad],
}

/// A vector for each particle of a chunk.
pub type Vectors = [[f32; 3]; CHUNK];

impl Pairs<'_> {
    /// Writes the kernel's slopes into the lists, for the sums below, and D without boundary, the sum of V grad W, and the sum of |V grad W|^2 of the chunk's particles.
    pub fn density(&self, lists: &mut Lists, out: &mut [Density]) {
        self.run(density::Work { pairs: *self, lists, out });
    }

    /// The sum of V (u_i - u_j) . grad W_ij of a field u, which has one value more than particles are.
    pub fn flux(&self, lists: &Lists, field: &[Quad], out: &mut [f32]) {
        self.run(flux::Work { pairs: *self, lists, field, out });
    }

    /// The sum of -V (P_i + P_j) grad W_ij: Eq. 1 of Band et al. 2018, the part of the fluid.
    pub fn acceleration(&self, lists: &Lists, out: &mut [[f32; 3]]) {
        self.run(acceleration::Work { pairs: *self, lists, out });
    }

    /// The Laplacian of the velocity, Eq. 16 of Bender et al. 2020, and the XSPH mean of the differences.
    pub fn viscosity(&self, lists: &Lists, velocities: &[Quad], out: &mut [[[f32; 3]; 2]]) {
        self.run(viscosity::Work { pairs: *self, lists, velocities, out });
    }

    /// The Laplacian alone, of any field.
    pub fn laplacian(&self, lists: &Lists, field: &[Quad], out: &mut [[f32; 3]]) {
        self.run(laplacian::Work { pairs: *self, lists, field, out });
    }

    /// The matrices by which the particles' own values enter their own Laplacians, 1/m^2; none has a positive eigenvalue.
    pub fn laplacian_own_part(&self, lists: &Lists, out: &mut [Symmetric]) {
        self.run(laplacian::OwnPart { pairs: *self, lists, out });
    }

    /// V NORM / r^3: what the sum of w becomes a density by.
    fn density_scale<K: KernelLanes>(&self) -> f32 {
        (self.with.volume * f64::from(K::NORM) / self.with.support_radius.powi(3)) as f32
    }

    /// V NORM SLOPE / r^4: what the sum of slope x / r becomes V grad W by.
    fn gradient_scale<K: KernelLanes>(&self) -> f32 {
        (self.with.volume * f64::from(K::NORM) * f64::from(K::SLOPE) / self.with.support_radius.powi(4))
            as f32
    }

    /// The same times 2 (d + 2) / r: what the sum of slope (u . x) x / (x . x) becomes a Laplacian by; x . x and x are in
    /// support radii, of which one is left over.
    fn laplacian_scale<K: KernelLanes>(&self) -> f32 {
        let factor = 2 * (self.with.dimension.count() + 2);
        factor as f32 * self.gradient_scale::<K>() / self.with.support_radius as f32
    }

    fn run(&self, work: impl KernelWork) {
        dispatch(WithKernel { kernel: self.with.kernel, work });
    }
}

/// What can be done with any kernel on any lanes.
trait KernelWork {
    /// Must be inlined, to be compiled for the processor that has the lanes.
    fn run<V: Lanes, K: KernelLanes>(self);
}

struct WithKernel<W> {
    kernel: KernelKind,
    work: W,
}

impl<W: KernelWork> Work for WithKernel<W> {
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

/// From i to eight neighbours: x_ij = x_i - x_j in support radii, its square, and the neighbours' fourth numbers.
struct Difference<V> {
    x: [V; 3],
    square: V,
    fourth: V,
}

impl<V: Lanes> Difference<V> {
    #[inline(always)]
    fn new(places: &[Quad], at: [V; 3], group: &Group) -> Difference<V> {
        let [place] = V::gather([places], group);
        Difference::from(at, place)
    }

    /// As [`Difference::new`], with the neighbours' values of a field.
    #[inline(always)]
    fn with_field(places: &[Quad], field: &[Quad], at: [V; 3], group: &Group) -> (Difference<V>, [V; 4]) {
        let [place, values] = V::gather([places, field], group);
        (Difference::from(at, place), values)
    }

    #[inline(always)]
    fn from(at: [V; 3], [x, y, z, fourth]: [V; 4]) -> Difference<V> {
        let x = [at[0] - x, at[1] - y, at[2] - z];
        Difference { x, square: dot(x, x), fourth }
    }
}

#[inline(always)]
fn dot<V: Lanes>(a: [V; 3], b: [V; 3]) -> V {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// sum + factor vector.
#[inline(always)]
fn add_scaled<V: Lanes>(sum: [V; 3], factor: V, vector: [V; 3]) -> [V; 3] {
    [sum[0] + factor * vector[0], sum[1] + factor * vector[1], sum[2] + factor * vector[2]]
}

#[inline(always)]
fn splat<V: Lanes>(quad: Quad) -> [V; 3] {
    [V::splat(quad[0]), V::splat(quad[1]), V::splat(quad[2])]
}

/// The sums of the lanes, times a factor.
#[inline(always)]
fn sums<V: Lanes>(factor: f32, vector: [V; 3]) -> [f32; 3] {
    [factor * vector[0].sum(), factor * vector[1].sum(), factor * vector[2].sum()]
}

#[cfg(test)]
mod tests;
