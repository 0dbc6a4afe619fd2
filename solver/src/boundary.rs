//! What the particles near a body see of it: the one place where volume maps are asked, once per step and particle.
//!
//! Bender et al. 2020, section 4.3: distance, closest point and volume become a density and its gradient by a closure.

use crate::bodies::Bodies;
use crate::neighbours::CHUNK;
use crate::viscosity::drag::Drag;
use rayon::prelude::*;
use volmap_runtime::{Closure, DVec3, PosedMap, Sample};

/// All bodies together, as one particle sees them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wall {
    /// Sum of the boundary's densities, rho_B / rho_0.
    pub density: f32,
    /// Sum of their gradients, 1/m.
    pub gradient: [f32; 3],
    /// Sum of the bodies' velocities times the gradients, 1/s.
    pub flux: f32,
}

/// A particle and a body in reach of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The particle.
    pub particle: u32,
    /// The body.
    pub body: u32,
    /// The body's part of the density, rho_B / rho_0.
    pub density: f32,
    /// Its gradient, 1/m.
    pub gradient: [f32; 3],
    /// Where the body feels the force, metres.
    pub point: DVec3,
    /// Velocity of the body there, m/s.
    pub velocity: DVec3,
}

/// A particle whose centre is in a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// The particle.
    pub particle: u32,
    /// The body.
    pub body: u32,
    /// The way out: a vector to the surface, metres; none where the particle is deeper than the map's band.
    pub way_out: Option<DVec3>,
}

/// The bodies' part in a step.
#[derive(Clone, Debug, Default)]
pub struct Boundary {
    /// One for each particle.
    pub of_particle: Vec<Wall>,
    chunks: Vec<ChunkContacts>,
}

/// Contacts of a chunk of particles, body after body.
#[derive(Clone, Debug, Default)]
struct ChunkContacts {
    contacts: Vec<Contact>,
    inside: Vec<Inside>,
    drags: Vec<Drag>,
    samples: Vec<(Sample, DVec3)>,
}

impl Boundary {
    /// Asks the maps of all bodies for all particles (positions in metres).
    pub fn sample(&mut self, bodies: &Bodies, closure: &Closure, positions: &[DVec3]) {
        self.of_particle.clear();
        self.of_particle.resize(positions.len(), Wall::default());
        self.chunks.resize_with(positions.len().div_ceil(CHUNK), ChunkContacts::default);
        let chunks = self.chunks.par_iter_mut().zip(self.of_particle.par_chunks_mut(CHUNK));
        chunks.zip(positions.par_chunks(CHUNK)).enumerate().for_each(|(chunk, ((out, walls), positions))| {
            out.contacts.clear();
            out.inside.clear();
            out.drags.clear();
            for body in 0..bodies.posed().len() {
                out.touch(bodies, body, closure, (chunk * CHUNK, positions));
            }
            for contact in &out.contacts {
                walls[contact.particle as usize - chunk * CHUNK].add(contact);
            }
        });
    }

    /// All contacts, in the order of the particles' chunks.
    pub fn contacts(&self) -> impl Iterator<Item = &Contact> {
        self.chunks.iter().flat_map(|chunk| &chunk.contacts)
    }

    /// Drag of all bodies whose surfaces have one, in the order of the particles' chunks.
    pub fn drags(&self) -> impl Iterator<Item = &Drag> {
        self.chunks.iter().flat_map(|chunk| &chunk.drags)
    }

    /// The same of the particles of one chunk.
    pub fn drags_of_chunk(&self, chunk: usize) -> &[Drag] {
        &self.chunks[chunk].drags
    }

    /// Largest speed of a body at a contact, m/s.
    pub fn max_speed(&self) -> f64 {
        self.contacts().map(|contact| contact.velocity.length_squared()).fold(0.0, f64::max).sqrt()
    }

    /// The particles whose centres are in a body.
    pub fn inside(&self) -> impl Iterator<Item = &Inside> {
        self.chunks.iter().flat_map(|chunk| &chunk.inside)
    }
}

impl ChunkContacts {
    fn touch(&mut self, bodies: &Bodies, body: usize, closure: &Closure, chunk: (usize, &[DVec3])) {
        let (first, positions) = chunk;
        let map: &PosedMap = &bodies.posed()[body];
        map.sample_with_gradient_batch(positions, &mut self.samples);
        for (within, ((sample, volume_gradient), &position)) in self.samples.iter().zip(positions).enumerate()
        {
            let particle = (first + within) as u32;
            let inside = |way_out| Inside { particle, body: body as u32, way_out };
            let near = match sample {
                Sample::Outside => continue,
                Sample::DeepInside => {
                    self.inside.push(inside(None));
                    continue;
                }
                Sample::Near(near) => near,
            };
            if near.distance < 0.0 {
                self.inside.push(inside(Some(-near.distance * near.normal)));
            }
            let of = [particle, body as u32];
            let wide = volmap_runtime::Boundary { volume: closure.volume(near), ..*near };
            self.drags.extend(Drag::new(of, position, &wide, bodies.fluid_contact(body), closure.kernel()));
            let distance = |point| map.values(point).distance;
            if let Some(density) = closure.density_probing(near, Some(*volume_gradient), position, distance) {
                self.contacts.push(Contact {
                    particle,
                    body: body as u32,
                    density: density.density as f32,
                    gradient: density.gradient.as_vec3().to_array(),
                    point: density.point,
                    velocity: bodies.velocity_at(body, density.point),
                });
            }
        }
    }
}

impl Contact {
    /// Gradient of the body's density, 1/m.
    pub fn gradient(&self) -> DVec3 {
        DVec3::from_array(self.gradient.map(f64::from))
    }
}

impl Wall {
    fn add(&mut self, contact: &Contact) {
        self.density += contact.density;
        for (sum, part) in self.gradient.iter_mut().zip(contact.gradient) {
            *sum += part;
        }
        self.flux += contact.velocity.dot(contact.gradient()) as f32;
    }
}
