//! Free bodies give way within a solve: they move under the pressures that are being looked for, so that fluid and
//! body agree at the end of the step. Without it, a solve pushes bodies as if they were immovable, and light ones are
//! thrown about: the fluid they carry along weighs more than they do. Gissler et al. 2019, *Interlinked SPH Pressure
//! Solvers for Strong Fluid-Rigid Coupling*.

use crate::bodies::Bodies;
use crate::boundary::{Boundary, Contact};
use crate::coupling::{self, Motions};
use volmap_runtime::DVec3;

/// The free bodies in a solve.
pub struct Response<'a> {
    bodies: &'a Bodies,
    /// Of free bodies, in the order of the particles.
    contacts: Vec<&'a Contact>,
    /// Mass of a particle, kg.
    mass: f64,
    /// Accelerations (m/s^2, rad/s^2) that are known before the solve.
    known: Motions,
}

impl<'a> Response<'a> {
    /// Of a particle's mass (kg). `with_known`: what gravity and the forces so far do to the bodies in this step
    /// counts.
    pub fn new(bodies: &'a Bodies, boundary: &'a Boundary, mass: f64, with_known: bool) -> Response<'a> {
        let count = bodies.posed().len();
        let free: Vec<bool> = (0..count).map(|body| bodies.is_free(body)).collect();
        let contacts = match free.contains(&true) {
            true => boundary.contacts().filter(|contact| free[contact.body as usize]).collect(),
            false => Vec::new(),
        };
        let known = |body: usize| if with_known { bodies.acceleration(body) } else { [DVec3::ZERO; 2] };
        Response { bodies, contacts, mass, known: (0..count).map(known).collect() }
    }

    /// The same if none gives way.
    pub fn held(self) -> Response<'a> {
        Response { contacts: Vec::new(), ..self }
    }

    /// Whether no free body is near the fluid.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Adds to `flux`, one for each particle, the bodies' known accelerations times the boundary's gradients, 1/s^2.
    pub fn add_known(&self, flux: &mut [f32]) {
        self.add(&self.known, flux);
    }

    /// The same of the accelerations by the fluid; `factor` is what a contact's gradient is multiplied by, m^2/s^2.
    pub fn add_response(&self, factor: impl Fn(&Contact) -> f32, flux: &mut [f32]) {
        let pushes = coupling::sum(self.bodies, self.contacts.iter().copied(), factor, self.mass);
        let motion =
            |(body, [force, torque]): (usize, &[DVec3; 2])| self.bodies.response(body, *force, *torque);
        let motions: Motions = pushes.iter().enumerate().map(motion).collect();
        self.add(&motions, flux);
    }

    /// Energy that the pressures give to the bodies in a step of `dt` seconds, to each particle's mass: what is in
    /// proportion to them, by the known accelerations, and what is to their square; `factor` as above.
    pub fn energy(&self, factor: impl Fn(&Contact) -> f32, dt: f64) -> [f64; 2] {
        let pushes = coupling::sum(self.bodies, self.contacts.iter().copied(), factor, self.mass);
        let mut out = [0.0; 2];
        for (body, ([force, torque], [linear, angular])) in pushes.iter().zip(&self.known).enumerate() {
            let [along, about] = self.bodies.response(body, *force, *torque);
            out[0] += dt * dt / self.mass * (force.dot(*linear) + torque.dot(*angular));
            out[1] += 0.5 * dt * dt / self.mass * (force.dot(along) + torque.dot(about));
        }
        out
    }

    /// Adds to `factors`, one for each particle, a bound of what giving way does there to all pressures of one: the
    /// sum of the absolute values in its row of the system. Jacobi's steps stay stable with it, however light a body
    /// is.
    pub fn add_bounds(&self, factors: &mut [f32]) {
        let mut sums = vec![[0.0; 2]; self.known.len()];
        for contact in &self.contacts {
            let [linear, angular] = &mut sums[contact.body as usize];
            *linear += contact.gradient().length();
            *angular += coupling::arm(self.bodies, contact).cross(contact.gradient()).length();
        }
        let inverse = |body: usize| {
            let square = |turn: bool| {
                DVec3::AXES.map(|axis| {
                    let unit = [DVec3::ZERO, axis];
                    let motion =
                        self.bodies.response(body, unit[usize::from(!turn)], unit[usize::from(turn)]);
                    motion[usize::from(turn)].length_squared()
                })
            };
            let linear = square(false).into_iter().fold(0.0, f64::max).sqrt();
            [linear, square(true).iter().sum::<f64>().sqrt()]
        };
        let inverses: Vec<[f64; 2]> = (0..sums.len()).map(inverse).collect();
        for contact in &self.contacts {
            let (sum, inverse) = (sums[contact.body as usize], inverses[contact.body as usize]);
            let linear = contact.gradient().length() * sum[0] * inverse[0];
            let angular =
                coupling::arm(self.bodies, contact).cross(contact.gradient()).length() * sum[1] * inverse[1];
            factors[contact.particle as usize] += (self.mass * (linear + angular)) as f32;
        }
    }

    fn add(&self, motions: &[[DVec3; 2]], flux: &mut [f32]) {
        for contact in &self.contacts {
            let [linear, angular] = motions[contact.body as usize];
            let here = linear + angular.cross(coupling::arm(self.bodies, contact));
            flux[contact.particle as usize] += here.dot(contact.gradient()) as f32;
        }
    }
}
