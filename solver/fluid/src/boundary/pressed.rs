//! Particles that walls press by themselves.
//!
//! In a gap of less than some 1.4 rp a particle has more than the rest density by itself and the walls alone. No motion
//! cures that, and the walls' gradients cancel, so that a solve would take any speed for it. Nor is a film that is
//! thinner than 2 rp what its density says: where plates at a distance h close with V, it must flow out with V / h, but
//! its neighbours' part of the density would have to make up for all that the walls add. So
//!
//! - of a density above that at rest, what walls alone make of it gives no velocity ([`Pressed::left_of_error`]), and
//!   where there is no way out, the rest of it doesn't either; in a film little of it does. A particle that has a way
//!   out is eased along it;
//! - of a compression by walls that move together a pressure P takes only a part. It meets a compliance C,
//!   ```text
//!   source + A - C P <= 0,    C = C_narrow + C_film
//!   ```
//!   C_narrow is the part of the walls' gradients g_b, one of each body, that cancels: sum of |g_b|^2 - |sum of g_b|^2.
//!   So P moves nothing faster than the walls move. C_film leaves of a film's outflow what V / h is of it.
//!
//! Both are 0 at a single body. P >= 0 is then less than without C, so that the solves take energy from the fluid and
//! give it none, as ever; forces on fluid and bodies are by the same P.

use super::{BlockContacts, Boundary, Contact, Method, Pairing, Wall};
use crate::bodies::Bodies;
use volmap_runtime::DVec3;

/// Own and walls' density between which C_narrow grows to all of what cancels.
const NARROW: [f32; 2] = [0.6, 0.9];
/// The same of C_film: from two particles' layers of room on, 2 rp, to a film.
const FILM: [f32; 2] = [0.42, 0.55];
/// Neighbours' density, times this, is the part of a film's outflow that is left: 1.5 h |d rho_walls / dh|.
const OUTFLOW: f32 = 0.8;
/// C_film is at most this times the particle's factor.
const MOST_FILM: f32 = 50.0;
/// From this change of the density in a step on walls close: less is among what a solve leaves.
const CLOSING: f32 = 5e-4;
/// This part of a density's error is left in a film.
const FILM_CALM: f32 = 0.95;

/// How far from where it is a place is looked for that has room for a particle, in support radii, and in how many
/// steps.
const REACH: f64 = 0.5;
const STEPS: u32 = 8;

/// A particle between walls with little room, or pressed into one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pressed {
    /// The particle.
    pub particle: u32,
    /// By how much its own and the walls' density is above that at rest, in parts of it; negative where it isn't yet.
    pub excess: f32,
    /// What of the walls' gradients cancels, 1/m^2.
    cancelled: f32,
    /// How fast the walls' motion among themselves raises the density, 1/s.
    closing: f32,
    /// Gradient of the walls' density, 1/m.
    pub gradient: [f32; 3],
    /// Whether no way of half a support radius out of the walls leaves it less than the rest density.
    pub pinched: bool,
    /// Of the body that is summed up.
    body: u32,
    of_body: [f32; 3],
    /// Sum of the contacts' velocities, m/s, and their number.
    velocity: [f32; 3],
    contacts: f32,
}

fn square([x, y, z]: [f32; 3]) -> f32 {
    x * x + y * y + z * z
}

impl Pressed {
    fn add(&mut self, contact: &Contact) {
        if contact.body != self.body {
            self.close();
            self.body = contact.body;
        }
        for (sum, part) in self.of_body.iter_mut().zip(contact.gradient) {
            *sum += part;
        }
        for (sum, part) in self.velocity.iter_mut().zip(contact.velocity.as_vec3().to_array()) {
            *sum += part;
        }
        self.contacts += 1.0;
    }

    /// Adds the square of a body whose contacts are all there.
    fn close(&mut self) {
        self.cancelled += square(std::mem::take(&mut self.of_body));
    }

    /// After the last contact; `flux` is the sum of the bodies' velocities times their gradients.
    fn finish(&mut self, flux: f32) {
        self.close();
        self.cancelled = (self.cancelled - square(self.gradient)).max(0.0);
        let of_mean: f32 = self.velocity.iter().zip(self.gradient).map(|(v, g)| v * g).sum();
        self.closing = (of_mean / self.contacts.max(1.0) - flux).max(0.0);
    }

    /// How far own and walls' density are between two values, 0 to 1.
    fn part(&self, [begin, end]: [f32; 2]) -> f32 {
        ((1.0 + self.excess - begin) / (end - begin)).clamp(0.0, 1.0)
    }

    /// How much of a film between two bodies the particle is in, 0 to 1.
    fn film(&self) -> f32 {
        if self.cancelled <= 0.0 {
            return 0.0;
        }
        self.part(FILM) * self.cancelled / (self.cancelled + square(self.gradient))
    }

    /// C, 1/m^2, for the particle's factor (1/m^2) and density, and a step of `dt` seconds.
    pub fn compliance(&self, factor: f32, density: f32, dt: f32) -> f32 {
        let moving = (self.closing * dt / CLOSING).min(1.0);
        let outflow = OUTFLOW * (density - 1.0 - self.excess).max(0.0);
        let film = (1.0 / outflow - 1.0).clamp(0.0, MOST_FILM) * factor;
        moving * (self.part(NARROW) * self.cancelled + self.film() * film)
    }

    /// What makes a velocity of a density's error: of that without what walls alone make of it, and if that is above
    /// rest, a part. `error` gives the source by a density.
    pub fn left_of_error(&self, density: f32, error: impl Fn(f32) -> f32) -> f32 {
        let by_neighbours = error(density - self.excess.max(0.0));
        match by_neighbours > 0.0 {
            true if self.pinched => 0.0,
            true => (1.0 - FILM_CALM * self.film()) * by_neighbours,
            false => by_neighbours,
        }
    }
}

/// The particles of a step that walls press together, with no way out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pinched {
    /// How many they are.
    pub count: usize,
    /// Where the one is that is pressed most, metres.
    pub place: DVec3,
}

impl Pinched {
    /// Of particles at these places, metres.
    pub fn of(boundary: &Boundary, positions: &[DVec3]) -> Pinched {
        let mut all = boundary.pressed().filter(|pressed| pressed.pinched);
        let Some(first) = all.next() else { return Pinched::default() };
        let start = (1, *first);
        let worse = |(count, most): (usize, Pressed), next: &Pressed| {
            (count + 1, if next.excess > most.excess { *next } else { most })
        };
        let (count, most) = all.fold(start, worse);
        Pinched { count, place: positions[most.particle as usize] }
    }
}

/// What is asked for other places.
#[derive(Clone, Copy)]
pub(super) struct Probe<'a> {
    pub method: &'a Method,
    pub bodies: &'a Bodies,
    /// See [`Pairing`].
    pub scale: f64,
    /// Density of a particle alone.
    pub own: f32,
    pub support_radius: f64,
}

impl BlockContacts {
    /// Tells which of the pressed particles have no way out; `positions` are those of the block.
    pub(super) fn find_pinched(&mut self, probe: Probe, positions: &[DVec3], first: usize) {
        if self.pressed.iter().all(|pressed| pressed.excess <= 0.0) {
            return;
        }
        let mut room = BlockContacts::default();
        for pressed in self.pressed.iter_mut().filter(|pressed| pressed.excess > 0.0) {
            let gradient = DVec3::from_array(pressed.gradient.map(f64::from));
            let way = -REACH * probe.support_radius / f64::from(STEPS) * gradient.normalize_or_zero();
            let from = positions[pressed.particle as usize - first];
            pressed.pinched = !(1..=STEPS)
                .map(|step| room.density_at(probe, from + f64::from(step) * way))
                .take_while(Option::is_some)
                .flatten()
                .any(|density| density < 1.0);
        }
    }

    /// Density of a particle alone at another place; none in a body.
    fn density_at(&mut self, Probe { method, bodies, scale, own, .. }: Probe, at: DVec3) -> Option<f32> {
        self.contacts.clear();
        self.inside.clear();
        for body in 0..bodies.posed().len() {
            self.touch(method, Pairing { bodies, body, first: 0, positions: &[at], scale });
        }
        let walls: f32 = self.contacts.iter().map(|contact| contact.density).sum();
        self.inside.is_empty().then_some(own + walls)
    }

    /// Finds the particles of the block that walls press; `own` is the density of a particle alone, `first` the block's
    /// first particle.
    pub(super) fn find_pressed(&mut self, walls: &[Wall], own: f32, first: usize) {
        let BlockContacts { contacts, pressed, .. } = self;
        pressed.clear();
        if contacts.is_empty() {
            return;
        }
        let narrow = |(_, wall): &(usize, &Wall)| own + wall.density > FILM[0];
        pressed.extend(walls.iter().enumerate().filter(narrow).map(|(within, wall)| Pressed {
            particle: (first + within) as u32,
            excess: own + wall.density - 1.0,
            gradient: wall.gradient,
            ..Pressed::default()
        }));
        if pressed.is_empty() {
            return;
        }
        for contact in contacts {
            if let Ok(n) = pressed.binary_search_by_key(&contact.particle, |pressed| pressed.particle) {
                pressed[n].add(contact);
            }
        }
        pressed.retain_mut(|pressed| {
            pressed.finish(walls[pressed.particle as usize - first].flux);
            pressed.excess > 0.0 || pressed.cancelled > 0.0
        });
    }
}
