//! The fluid's push on bodies: the negative of what each particle's boundary force is, at its sample point. Bender et
//! al. 2020, section 4.3.

use crate::bodies::Bodies;
use crate::boundary::Contact;
use volmap_runtime::DVec3;

/// Force and torque, or linear and angular acceleration, of each body.
pub type Motions = Vec<[DVec3; 2]>;

/// Adds forces and torques, one pair for each body, to those that are free.
pub fn push(bodies: &mut Bodies, forces: &[[DVec3; 2]]) {
    for (body, &[force, torque]) in forces.iter().enumerate() {
        if bodies.is_free(body) {
            bodies.apply(body, force, torque);
        }
    }
}

/// Force and torque about the centre of mass of each body at these contacts; `factor` is what a contact's gradient is
/// multiplied by, m^2/s^2.
pub fn sum<'a>(
    bodies: &Bodies,
    contacts: impl Iterator<Item = &'a Contact>,
    factor: impl Fn(&Contact) -> f32,
    mass: f64,
) -> Motions {
    let mut out = vec![[DVec3::ZERO; 2]; bodies.posed().len()];
    for contact in contacts {
        let force = mass * f64::from(factor(contact)) * contact.gradient();
        let [sum, torque] = &mut out[contact.body as usize];
        *sum += force;
        *torque += arm(bodies, contact).cross(force);
    }
    out
}

/// From the centre of mass to the sample point, metres.
pub fn arm(bodies: &Bodies, contact: &Contact) -> DVec3 {
    contact.point - bodies.center_of_mass(contact.body as usize)
}
