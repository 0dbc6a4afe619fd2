//! The fluid's push on bodies: the negative of what each particle's boundary force is, at its sample point. Bender et
//! al. 2020, section 4.3.

use crate::bodies::Bodies;
use crate::fields::Fields;
use crate::pressure::Solve;
use volmap_runtime::DVec3;

/// Adds forces and torques, one pair for each body, to those that are free.
pub fn push(bodies: &mut Bodies, forces: &[[DVec3; 2]]) {
    for (body, &[force, torque]) in forces.iter().enumerate() {
        if bodies.is_free(body) {
            bodies.apply(body, force, torque);
        }
    }
}

/// Force and torque about the centre of mass of each body by a solve's pressures. `mass` is a particle's, kg.
pub fn forces(bodies: &Bodies, fields: &Fields, solve: &Solve, mass: f64) -> Vec<[DVec3; 2]> {
    let mut out = vec![[DVec3::ZERO; 2]; bodies.posed().len()];
    if !(0..out.len()).any(|body| bodies.is_free(body)) {
        return out;
    }
    for contact in solve.boundary.contacts() {
        let particle = contact.particle as usize;
        let factor = solve.wall_factor(fields.places[particle][3], fields.densities[particle]);
        let force = mass * f64::from(factor) * DVec3::from_array(contact.gradient.map(f64::from));
        let body = contact.body as usize;
        let [sum, torque] = &mut out[body];
        *sum += force;
        *torque += (contact.point - bodies.center_of_mass(body)).cross(force);
    }
    out
}
