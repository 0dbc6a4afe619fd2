//! Particles where none may be: in a body, or out of the domain. Counted, brought back or removed, never in silence.
//!
//! A particle in a body is moved towards the surface and a little beyond, by its radius in every step, and keeps no
//! velocity along the way: what pressure would make of a particle that sees nothing but wall must not shoot it out.
//! So its velocity gains no energy, and a free body gets the momentum that it loses. What is put elsewhere may be
//! lifted, or press others together a little: 0.3 % of the energy in a step were seen. The way out is along the normal,
//! or, deeper than the map's band, along the shortest of 26 rays.

use crate::bodies::Bodies;
use crate::boundary::Inside;
use crate::boundary::pressed::Pressed;
use crate::particles::Particles;
use volmap_runtime::{DVec3, Dimension, PosedMap, Sample};

/// How far from the surface a particle is put down, in its radii: on it the wall's density alone would push it away.
const BEYOND: f64 = 0.5;
/// How far the way out is looked for, in support radii, and in which steps.
const LONGEST_RAY: u32 = 64;
const RAY_STEP: f64 = 1.0;
/// In a step a pressed particle is eased by so much of the density, and so far, in its radii, at most.
const MOST_EASED: f64 = 0.01;
const LONGEST_EASED: f64 = 0.02;

/// Particles of a kind, bodies that take their momentum, and a step.
pub struct Strays<'a> {
    /// What the particles may be in.
    pub bodies: &'a mut Bodies,
    /// Force and torque on each body in this step, to which the impulses are added.
    pub body_forces: &'a mut [[DVec3; 2]],
    /// Metres.
    pub particle_radius: f64,
    /// Kilograms.
    pub particle_mass: f64,
    /// Seconds.
    pub dt: f64,
}

impl Strays<'_> {
    /// Moves particles that are in bodies towards the surface, at the end of a step. `inside` are those at its
    /// beginning; places and velocities are new, those of the bodies still old.
    pub fn bring_back<'a>(&mut self, particles: &mut Particles, inside: impl Iterator<Item = &'a Inside>) {
        for &Inside { particle, body, way_out } in inside {
            let (particle, body) = (particle as usize, body as usize);
            let position = particles.positions[particle];
            let way = way_out.or_else(|| shortest_way(&self.bodies.posed()[body], position));
            let Some(direction) = way.and_then(DVec3::try_normalize) else { continue };
            let own = DVec3::from_array(particles.velocities[particle].map(f64::from));
            let taken = self.stop(body, position - self.dt * own, own, direction);
            // Never put down between the surface and there.
            let length = match way.map_or(0.0, DVec3::length) {
                way if way <= 1.5 * self.particle_radius => way + BEYOND * self.particle_radius,
                _ => self.particle_radius,
            };
            particles.positions[particle] = position + (length - taken * self.dt) * direction;
            particles.velocities[particle] = (own - taken * direction).as_vec3().to_array();
            // The next step must not begin with them: particles were seen to leave a wall at 30 m/s.
            particles.pressures[particle] = 0.0;
        }
    }

    /// How much of its velocity a particle that was at `place` loses along a direction until it and the body move
    /// alike there, m/s; the body gets the impulse at that place. As a plastic collision has it: of a light body only a
    /// part is taken, so that no energy comes from it.
    fn stop(&mut self, body: usize, place: DVec3, own: DVec3, direction: DVec3) -> f64 {
        let arm = place - self.bodies.center_of_mass(body);
        let here = |[linear, angular]: [DVec3; 2]| (linear + angular.cross(arm)).dot(direction);
        // At the end of the step, with all that acts on the body so far.
        let old = self.bodies.velocity_at(body, place).dot(direction);
        let along = own.dot(direction) - (old + self.dt * here(self.bodies.acceleration(body)));
        if !self.bodies.is_free(body) {
            return along;
        }
        let gives_way = here(self.bodies.response(body, direction, arm.cross(direction)));
        let taken = along / (1.0 + self.particle_mass * gives_way);
        let force = self.particle_mass * taken / self.dt * direction;
        self.bodies.apply(body, force, arm.cross(force));
        self.body_forces[body][0] += force;
        self.body_forces[body][1] += arm.cross(force);
        taken
    }
}

/// Moves particles that walls press towards where they press them less, at the end of a step. Velocities are left, so
/// that nothing gains energy.
pub fn ease<'a>(particles: &mut Particles, pressed: impl Iterator<Item = &'a Pressed>, rp: f64) {
    for pressed in pressed.filter(|pressed| pressed.excess > 0.0 && !pressed.pinched) {
        let gradient = DVec3::from_array(pressed.gradient.map(f64::from));
        let square = gradient.length_squared();
        if square > 0.0 {
            let length = (f64::from(pressed.excess).min(MOST_EASED) / square.sqrt()).min(LONGEST_EASED * rp);
            particles.positions[pressed.particle as usize] -= length / square.sqrt() * gradient;
        }
    }
}

/// From a point deep in a body to its surface; in two dimensions by the 8 rays in the plane.
fn shortest_way(map: &PosedMap, point: DVec3) -> Option<DVec3> {
    let step = RAY_STEP * map.map.support_radius();
    let rays: Vec<DVec3> = (0..27)
        .filter(|&i| i != 13 && (map.map.dimension() == Dimension::Three || i / 9 == 1))
        .map(|i| DVec3::new((i % 3 - 1) as f64, (i / 3 % 3 - 1) as f64, (i / 9 - 1) as f64).normalize())
        .collect();
    // All rays grow together: the first that meets the band is the shortest.
    (1..=LONGEST_RAY).find_map(|count| {
        let found = rays.iter().filter_map(|&ray| {
            let way = f64::from(count) * step * ray;
            match map.sample(point + way) {
                Sample::Near(near) => Some(way - near.distance * near.normal),
                Sample::Outside => Some(way),
                Sample::DeepInside => None,
            }
        });
        found.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
    })
}

/// Whether a place is in a box; one that is no number isn't.
pub fn is_within(x: DVec3, [min, max]: [DVec3; 2]) -> bool {
    x.cmpge(min).all() && x.cmple(max).all()
}

/// Removes the particles out of a box, and their densities; how many there were.
pub fn remove_outside(particles: &mut Particles, densities: &mut Vec<f32>, domain: [DVec3; 2]) -> usize {
    particles.retain(densities, |particles, n| is_within(particles.positions[n], domain))
}
