//! Where there is room for a particle that a nozzle would add: out of bodies, away from other particles, and where the
//! fluid isn't compressed already. So a nozzle under water adds what the water gives way to, and one in a tank that is
//! full adds nothing.

use crate::bodies::Bodies;
use crate::cubes::Cubes;
use crate::particles::Particles;
use crate::strays::is_within;
use volmap_runtime::{DVec3, PosedMap};

/// Nearer to a particle than this part of a spacing there is no room, nor nearer to a body than that part. Fluid at
/// rest gives way to what comes between its particles, but not to what lies on top of them.
const NEAREST: f64 = 0.5;
const NEAREST_BODY: f64 = 0.1;
/// Of what comes between particles in the same moment, no two may be nearer to each other than so many spacings: the
/// kernel's reach, as each takes the room of the other.
const APART: f64 = 2.0;
/// Part of a spacing that rounding may take from a distance.
const SLACK: f64 = 1e-6;
/// Fluid that is denser than at rest by more than this part has no room: what the density solve corrects in a step.
pub const FULL: f64 = 0.01;

/// Particles and bodies near some places. By default there are none, and there is room everywhere.
#[derive(Clone, Debug)]
pub struct Room {
    spacing: f64,
    /// Particles by cubes of the spacing, and whether the fluid is compressed there.
    particles: Cubes<bool>,
    /// Places between particles that were taken.
    taken: Vec<DVec3>,
    bodies: Vec<PosedMap>,
}

impl Default for Room {
    fn default() -> Room {
        Room { spacing: 0.0, particles: Cubes::new(1.0), taken: Vec::new(), bodies: Vec::new() }
    }
}

impl Room {
    /// What is near some places, metres, in a fluid of this spacing at rest. `densities` are relative ones of the
    /// first particles; the others are at rest.
    pub fn near(
        places: &[DVec3],
        positions: &[DVec3],
        densities: &[f32],
        bodies: &Bodies,
        spacing: f64,
    ) -> Room {
        let (near, mut particles) = (around(places, spacing), Cubes::new(spacing));
        for (i, &x) in positions.iter().enumerate().filter(|(_, x)| is_within(**x, near)) {
            let density = densities.get(i).map_or(1.0, |&density| f64::from(density));
            particles.add(x, density > 1.0 + FULL);
        }
        Room { spacing, particles, taken: Vec::new(), bodies: bodies.posed().to_vec() }
    }

    /// Takes a place, metres, if a particle can be put there.
    pub fn take(&mut self, place: DVec3) -> bool {
        let in_body = |body: &PosedMap| body.values(place).distance < NEAREST_BODY * self.spacing;
        if self.bodies.iter().any(in_body) {
            return false;
        }
        let far = self.spacing * (1.0 - SLACK);
        let all = self.particles.around(place);
        let mut near = all.filter(|(x, _)| x.distance(place) < far).peekable();
        if near.peek().is_none() {
            return true;
        }
        let fits = near.all(|(x, compressed)| x.distance(place) >= NEAREST * far && !compressed)
            && self.taken.iter().all(|x| x.distance(place) >= APART * self.spacing);
        if fits {
            self.taken.push(place);
        }
        fits
    }
}

/// The box of places, wider by a spacing.
fn around(places: &[DVec3], spacing: f64) -> [DVec3; 2] {
    let low = places.iter().fold(DVec3::INFINITY, |low, &x| low.min(x));
    let high = places.iter().fold(DVec3::NEG_INFINITY, |high, &x| high.max(x));
    [low - spacing, high + spacing]
}

/// Gives fluid in the mouth of a nozzle, nearer than a spacing to one of these places (metres), at least the velocity
/// of the flow (m/s) along it: a pump pushes out what lies in its mouth. So there is room after a while, if what lies
/// there can go.
pub fn clear(places: &[DVec3], flow: DVec3, particles: &mut Particles, spacing: f64) {
    let (near, direction) = (around(places, spacing), flow.normalize_or_zero());
    for (x, velocity) in particles.positions.iter().zip(&mut particles.velocities) {
        if is_within(*x, near) && places.iter().any(|place| place.distance(*x) < spacing) {
            let own = DVec3::from_array(velocity.map(f64::from));
            let missing = (flow - own).dot(direction).max(0.0);
            *velocity = (own + missing * direction).as_vec3().to_array();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_away_from_particles_and_bodies() {
        let none = Bodies::new(Vec::new(), DVec3::ZERO).unwrap();
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        let room = |density: f32| Room::near(&[at(0.0), at(1.0)], &[at(0.0)], &[density], &none, 0.1);
        let free = |density: f32, x: f64| room(density).take(at(x));
        assert!(!free(1.0, 0.0) && !free(1.0, 0.049) && free(1.0, 0.051) && free(1.0, 1.0));
        // Compressed fluid takes nothing beside it either.
        assert!(!free(1.1, 0.06) && !free(1.1, 0.099) && free(1.1, 0.101));
        assert!(Room::default().take(at(0.0)));
    }

    #[test]
    fn what_comes_between_particles_takes_the_room_of_others() {
        let none = Bodies::new(Vec::new(), DVec3::ZERO).unwrap();
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        let row: Vec<DVec3> = (0..10).map(|n| at(0.1 * f64::from(n))).collect();
        let mut room = Room::near(&row, &row, &[1.0; 10], &none, 0.1);
        assert!(room.take(at(0.05)) && !room.take(at(0.15)) && room.take(at(0.25)));
        // Beside them a whole layer has room.
        let beside = |n: u32| at(0.1 * f64::from(n)) + 0.1 * DVec3::Y;
        assert!((0..10).all(|n| room.take(beside(n))));
    }
}
