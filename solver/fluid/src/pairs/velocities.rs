//! Sums over differences of velocities, once a step: the Laplacian by Eq. 16 of Bender et al. 2020 (Monaghan 2005),
//! and the mean difference of XSPH (Schechter and Bridson 2012). Forces of both conserve momentum: particles have one
//! volume.

use super::kernels::{KernelLanes, SMALL};
use super::lanes::{Lanes, places_of};
use super::lists::Lists;
use super::table::Quads;
use super::{SLICE, Units, WithKernel, WorkOfKernel, dispatch};
use crate::discretization::Discretization;
use std::marker::PhantomData;
use std::ops::Range;

/// Tables of the places, in support radii, and velocities of a block's particles and those around it.
#[derive(Clone, Copy)]
pub(crate) struct Motion<'a> {
    pub places: &'a Quads,
    pub velocities: &'a Quads,
}

/// The Laplacian of each particle's velocity, 1/m^2 times m/s.
pub(crate) fn laplacian(lists: &Lists, with: Discretization, motion: Motion, out: &mut [[f32; 3]]) {
    sum(OfVelocities { lists, with, motion, summand: PhantomData::<Laplacian>, out });
}

/// The sum of V W (v_j - v_i) of each particle, m/s.
pub(crate) fn mean_difference(lists: &Lists, with: Discretization, motion: Motion, out: &mut [[f32; 3]]) {
    sum(OfVelocities { lists, with, motion, summand: PhantomData::<MeanDifference>, out });
}

fn sum<S: Summand>(work: OfVelocities<S>) {
    dispatch(WithKernel { kernel: work.with.kernel, work });
}

/// What is summed up over the neighbours of a particle.
pub(super) trait Summand {
    /// What the sum is multiplied by.
    fn unit(units: Units) -> f32;
    /// Of x_i - x_j (in support radii), v_j - v_i, and the square of the former. Must be inlined.
    fn of<V: Lanes, K: KernelLanes>(x: [V; 3], v: [V; 3], square: V) -> [V; 3];
}

pub(super) struct Laplacian;
pub(super) struct MeanDifference;

impl Summand for Laplacian {
    #[inline(always)]
    fn unit(units: Units) -> f32 {
        units.laplacian
    }

    #[inline(always)]
    fn of<V: Lanes, K: KernelLanes>(x: [V; 3], v: [V; 3], square: V) -> [V; 3] {
        let product = (v[0] * x[0] + v[1] * x[1]) + v[2] * x[2];
        let factor = K::slope(square) * product / (square + V::splat(SMALL));
        [factor * x[0], factor * x[1], factor * x[2]]
    }
}

impl Summand for MeanDifference {
    #[inline(always)]
    fn unit(units: Units) -> f32 {
        units.density
    }

    #[inline(always)]
    fn of<V: Lanes, K: KernelLanes>(_: [V; 3], v: [V; 3], square: V) -> [V; 3] {
        let value = K::value(square);
        [value * v[0], value * v[1], value * v[2]]
    }
}

pub(super) struct OfVelocities<'a, S> {
    pub lists: &'a Lists,
    pub with: Discretization,
    pub motion: Motion<'a>,
    pub summand: PhantomData<S>,
    pub out: &'a mut [[f32; 3]],
}

impl<S: Summand> WorkOfKernel for OfVelocities<'_, S> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let unit = S::unit(Units::new::<K>(self.with));
        for (particles, rows) in self.lists.slices() {
            let sums = self.of_slice::<V, K>(particles, rows).map(V::array);
            for (lane, &particle) in particles.iter().enumerate() {
                if let Some(out) = self.out.get_mut(usize::from(particle)) {
                    *out = [unit * sums[0][lane], unit * sums[1][lane], unit * sums[2][lane]];
                }
            }
        }
    }
}

impl<S: Summand> OfVelocities<'_, S> {
    #[inline(always)]
    fn of_slice<V: Lanes, K: KernelLanes>(&self, particles: &[u16; SLICE], rows: Range<usize>) -> [V; 3] {
        let Motion { places, velocities } = self.motion;
        let itself = places_of(particles);
        let (at, own) = (V::gather(places, &itself), V::gather(velocities, &itself));
        let mut sums = [V::splat(0.0); 3];
        for row in &self.lists.rows()[rows] {
            let (x, v) = (V::gather_row(places, row), V::gather_row(velocities, row));
            let x = [at[0] - x[0], at[1] - x[1], at[2] - x[2]];
            let v = [v[0] - own[0], v[1] - own[1], v[2] - own[2]];
            let square = (x[0] * x[0] + x[1] * x[1]) + x[2] * x[2];
            let add = S::of::<V, K>(x, v, square);
            for axis in 0..3 {
                sums[axis] = sums[axis] + add[axis];
            }
        }
        sums
    }
}
