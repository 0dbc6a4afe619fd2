//! Particles that walls press by themselves: with itself and the walls alone a particle has more than the rest density.
//!
//! In a gap of less than some 1.4 rp no motion cures that, and the walls' gradients cancel, so that a solve would take
//! any speed for it. So of such a particle
//!
//! - the density's error makes no velocity ([`Pressed::excess`]): the particle is eased towards where walls press it
//!   less, and gains no energy;
//! - what walls that move press together is to be answered only in part: the pressure P meets the compliance C =
//!   sum of |g_b|^2 - |sum of g_b|^2, of the gradients g_b of each body, the part of it that cancels. For one wall C is
//!   0; between two that face each other it bounds what P moves, C P <= source, by the walls' own speed.

use super::{BlockContacts, Boundary, Contact, Method, Pairing, Wall};
use crate::bodies::Bodies;
use volmap_runtime::DVec3;

/// Own and walls' density at which a gap begins to be too narrow for its fluid, and where it is so altogether.
const NARROW: [f32; 2] = [0.8, 1.0];

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
    /// C: what is taken off the compression for each of the particle's own pressure, 1/m^2.
    pub compliance: f32,
    /// Gradient of the walls' density, 1/m.
    pub gradient: [f32; 3],
    /// Whether no way of some [`REACH`] out of the walls leaves it less than the rest density.
    pub pinched: bool,
    /// Of the body that is summed up.
    body: u32,
    of_body: [f32; 3],
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
    }

    /// Adds the square of a body whose contacts are all there.
    fn close(&mut self) {
        self.compliance += square(std::mem::take(&mut self.of_body));
    }

    fn finish(&mut self) {
        self.close();
        let [begin, end] = NARROW;
        let part = ((self.excess + 1.0 - begin) / (end - begin)).clamp(0.0, 1.0);
        self.compliance = part * (self.compliance - square(self.gradient)).max(0.0);
    }
}

impl Pressed {
    /// Density whose excess makes a velocity: without what walls make of it alone.
    pub fn by_neighbours(&self, density: f32) -> f32 {
        if self.pinched { density.min(1.0) } else { density - self.excess.max(0.0) }
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
        let narrow = |(_, wall): &(usize, &Wall)| own + wall.density > NARROW[0];
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
        pressed.iter_mut().for_each(Pressed::finish);
    }
}
