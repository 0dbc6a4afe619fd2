//! Energy that the pressures of a solve add: bounded where the boundary has a pressure of its own.
//!
//! Forces that are the gradient of the density (`own`) take energy from fluid and bodies, but for what is stored in
//! fluid that is too dense. With `mirror`, `sph` and `mls` they aren't that gradient: a solve that doesn't converge, or
//! that does where walls make most of a density, would throw the fluid about. A part s of all pressures adds
//! ```text
//! E(s) = s L + s^2 Q,   L = dt (sum of v_i . a_i + sum over contacts of f_c g_c . v_c),
//!                       Q = dt^2 / 2 (sum of a_i^2 + what the free bodies get)
//! ```
//! for each of a particle's mass: to fluid and free bodies, less the work of bodies that move by themselves. As much
//! as C s may be added, C = sum of P_i times the density's error, so that s = (C - L) / Q if that is below 1. One s for
//! all, so that momentum stays.

use crate::boundary::Contact;
use crate::fields::Fields;
use crate::pairs::Quad;
use crate::particles::CHUNK;
use crate::pressure::Solve;
use rayon::prelude::*;

impl Fields {
    /// Lessens the pressures that a solve has found, and their accelerations, if they would add energy; `error` is the
    /// part of a density (relative) that they are to bring back.
    pub(crate) fn bound_energy(&mut self, solve: &Solve, error: impl Fn(f32) -> f32 + Sync) {
        let pressures = self.all_pressures();
        let factor = |contact: &Contact| solve.wall.factor(pressures, contact);
        let [work, push] = solve.response.energy(factor, solve.dt);
        let of_walls: f64 = solve
            .boundary
            .contacts()
            .map(|contact| f64::from(factor(contact)) * contact.gradient().dot(contact.velocity))
            .sum();
        let [of_fluid, squares] = self.power();
        let stored: f64 = {
            let of = |(pressure, density): (&f32, &f32)| f64::from(pressure * error(*density).max(0.0));
            self.pressures.iter().zip(&self.densities).map(of).sum()
        };
        let linear = solve.dt * (of_fluid + of_walls) + work - stored;
        let square = 0.5 * solve.dt * solve.dt * squares + push;
        if linear + square > 0.0 {
            let part = (-linear / square).max(0.0) as f32;
            let lessen = |value: &mut f32| *value *= part;
            self.pressures.iter_mut().for_each(lessen);
            self.site_pressures.iter_mut().for_each(lessen);
            self.accelerations.iter_mut().flatten().for_each(lessen);
        }
    }

    /// Sums of v . a and of a^2 over the particles, in an order that doesn't depend on threads.
    fn power(&self) -> [f64; 2] {
        let dot = |a: &Quad, b: &Quad| (0..3).map(|n| f64::from(a[n]) * f64::from(b[n])).sum::<f64>();
        let chunk = |(velocities, accelerations): (&[Quad], &[Quad])| {
            velocities
                .iter()
                .zip(accelerations)
                .fold([0.0; 2], |[linear, square], (v, a)| [linear + dot(v, a), square + dot(a, a)])
        };
        let all = self.velocities.par_chunks(CHUNK).zip(self.accelerations.par_chunks(CHUNK));
        let sums: Vec<[f64; 2]> = all.map(chunk).collect();
        sums.iter().fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y])
    }
}
