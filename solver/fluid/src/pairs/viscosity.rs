//! Explicit viscosity, once a step: the Laplacian of the velocity by Eq. 16 of Bender et al. 2020 (Monaghan 2005), and the mean of
//! the velocity differences of XSPH (Schechter and Bridson 2012). Both conserve momentum: particles have one volume.

use super::kernels::{KernelLanes, SMALL};
use super::lanes::{Lanes, dispatch, places_of};
use super::table::Quads;
use super::{SLICE, Units, WithKernel, WorkOfKernel};
use crate::fields::Discretization;
use crate::neighbours::Lists;
use std::ops::Range;

/// Tables of the places, in support radii, and velocities of a block's particles and those around it.
#[derive(Clone, Copy)]
pub struct Motion<'a> {
    pub places: &'a Quads,
    pub velocities: &'a Quads,
}

/// The Laplacian of each particle's velocity, 1/m^2 times m/s, and with `MEAN` the sum of V W (v_j - v_i), m/s.
pub fn viscosity<const MEAN: bool>(
    lists: &Lists,
    with: Discretization,
    motion: Motion,
    out: &mut [[[f32; 3]; 2]],
) {
    dispatch(WithKernel { kernel: with.kernel, work: Viscosity::<MEAN> { lists, with, motion, out } });
}

pub(super) struct Viscosity<'a, const MEAN: bool> {
    pub lists: &'a Lists,
    pub with: Discretization,
    pub motion: Motion<'a>,
    pub out: &'a mut [[[f32; 3]; 2]],
}

impl<const MEAN: bool> WorkOfKernel for Viscosity<'_, MEAN> {
    #[inline(always)]
    fn run<V: Lanes, K: KernelLanes>(self) {
        let units = Units::new::<K>(self.with);
        let [laplacian, mean] = [units.laplacian, units.density];
        for (particles, rows) in self.lists.slices() {
            let sums = self.of_slice::<V, K>(particles, rows);
            let [a, b, c, d, e, f] = sums;
            let (a, b, c) = (a.array(), b.array(), c.array());
            let (d, e, f) = (d.array(), e.array(), f.array());
            for (lane, &particle) in particles.iter().enumerate() {
                if let Some(out) = self.out.get_mut(usize::from(particle)) {
                    *out = [
                        [laplacian * a[lane], laplacian * b[lane], laplacian * c[lane]],
                        [mean * d[lane], mean * e[lane], mean * f[lane]],
                    ];
                }
            }
        }
    }
}

impl<const MEAN: bool> Viscosity<'_, MEAN> {
    #[inline(always)]
    fn of_slice<V: Lanes, K: KernelLanes>(&self, particles: &[u16; SLICE], rows: Range<usize>) -> [V; 6] {
        let Motion { places, velocities } = self.motion;
        let itself = places_of(particles);
        let (at, own) = (V::gather(places, &itself), V::gather(velocities, &itself));
        let (zero, small) = (V::splat(0.0), V::splat(SMALL));
        let (mut laplacian, mut mean) = ([zero; 3], [zero; 3]);
        for row in &self.lists.rows()[rows] {
            let (x, v) = (V::gather_row(places, row), V::gather_row(velocities, row));
            let x = [at[0] - x[0], at[1] - x[1], at[2] - x[2]];
            let v = [v[0] - own[0], v[1] - own[1], v[2] - own[2]];
            let square = (x[0] * x[0] + x[1] * x[1]) + x[2] * x[2];
            let (value, slope) = if MEAN { K::both(square) } else { (zero, K::slope(square)) };
            let factor = slope * ((v[0] * x[0] + v[1] * x[1]) + v[2] * x[2]) / (square + small);
            for axis in 0..3 {
                laplacian[axis] = laplacian[axis] + factor * x[axis];
                if MEAN {
                    mean[axis] = mean[axis] + value * v[axis];
                }
            }
        }
        [laplacian[0], laplacian[1], laplacian[2], mean[0], mean[1], mean[2]]
    }
}
