//! What the particles near a body see of it, once a step: one small interface for all boundary methods.
//!
//! Every method makes contacts, each with a density and its gradient; their sum is a particle's wall. A method is a
//! file:
//!
//! - [`volume_map`]: Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 4.3, with any
//!   closure;
//! - [`density_map`]: Koschier and Bender 2017, *Density Maps for Improved SPH Boundary Handling*;
//! - [`particles`]: Akinci et al. 2012, *Versatile Rigid-Fluid Coupling for Incompressible SPH*;
//! - [`tube_map`]: Nogina and Sellan 2026, *Tube Maps*, in our own derivation;
//!
//! and [`pressure`] is what pressure the boundary has at a contact. Which particles are in a body the map tells,
//! whatever the method.

pub mod density_map;
pub mod drag;
pub mod particles;
pub mod pressed;
pub mod pressure;
pub mod sampling;
pub mod tube_map;
pub mod volume_map;

use crate::bodies::{Bodies, FluidContact};
use crate::error::Error;
use crate::neighbours::Neighbours;
use crate::settings::{BoundaryMethod, FluidSettings, World};
use drag::Drag;
use particles::BodyParticles;
use pressed::{Pressed, Probe};
use rayon::prelude::*;
use std::sync::Arc;
use volmap_runtime::{
    Closure, ClosureError, DVec3, Kernel, MapDensity, PosedMap, Sample, SurfaceWithGradient, Values,
};

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

/// A particle and a body in reach of each other: one for each of them on maps, one for each of the body's particles
/// else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The particle.
    pub particle: u32,
    /// The body.
    pub body: u32,
    /// Where the boundary's pressure is one, among all such sites: of a boundary particle the same in all its contacts.
    pub site: u32,
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
#[derive(Clone, Debug)]
pub struct Boundary {
    /// One for each particle.
    pub of_particle: Vec<Wall>,
    kernel: Kernel,
    method: Method,
    /// What densities of the maps are multiplied by: 1 over [`World::rest_sum`].
    per_rest_sum: f64,
    /// Relative density of a particle that is alone.
    own_density: f32,
    blocks: Vec<BlockContacts>,
}

/// How bodies are seen, with what it needs.
#[derive(Clone, Debug)]
enum Method {
    /// None without bodies: a map makes it.
    VolumeMap(Option<Closure>),
    DensityMap,
    /// One for each body.
    Particles(particles::Kernels, Vec<Arc<BodyParticles>>),
    TubeMap(Kernel),
}

/// Contacts of a block of particles, body after body.
#[derive(Clone, Debug, Default)]
struct BlockContacts {
    contacts: Vec<Contact>,
    inside: Vec<Inside>,
    drags: Vec<Drag>,
    pressed: Vec<Pressed>,
    scratch: Scratch,
}

/// What the maps answer.
#[derive(Clone, Debug, Default)]
struct Scratch {
    samples: Vec<Sample<SurfaceWithGradient>>,
    densities: Vec<Option<MapDensity>>,
    points: Vec<DVec3>,
    values: Vec<Values>,
}

/// A block of particles, and the body that they may touch.
#[derive(Clone, Copy)]
struct Pairing<'a> {
    bodies: &'a Bodies,
    body: usize,
    /// First particle of the block.
    first: usize,
    positions: &'a [DVec3],
    /// What the density of a contact, as the method has it, is multiplied by.
    scale: f64,
}

impl Boundary {
    /// The boundary of these bodies by the method of the world.
    ///
    /// # Errors
    /// [`Error::Setup`] for a body that hasn't what the method needs: a mesh, or a density in its map.
    pub fn new(world: &World, fluid: &FluidSettings, bodies: &Bodies) -> Result<Boundary, Error> {
        let kernel = world.kernel_of_size();
        let method = match world.boundary {
            BoundaryMethod::VolumeMap => Method::VolumeMap(closure(world, fluid, bodies)?),
            BoundaryMethod::DensityMap => {
                density_map::check(bodies, world.kernel)?;
                Method::DensityMap
            }
            BoundaryMethod::Particles => {
                let all = particles::of_bodies(bodies, world, &kernel)?;
                Method::Particles(particles::Kernels::new(kernel, world, fluid), all)
            }
            BoundaryMethod::TubeMap => Method::TubeMap(kernel),
        };
        // The volumes of boundary particles follow from the kernel's sum among themselves.
        let is_of_maps = !matches!(method, Method::Particles(..));
        let per_rest_sum = if is_of_maps { 1.0 / world.rest_sum(fluid) } else { 1.0 };
        let volume = world.particle_volume(fluid);
        let own_density = (volume * kernel.value(0.0) / world.rest_sum(fluid)) as f32;
        Ok(Boundary {
            of_particle: Vec::new(),
            kernel,
            method,
            per_rest_sum,
            own_density,
            blocks: Vec::new(),
        })
    }

    /// Finds the contacts of all particles (positions in metres) with all bodies, block by block; `neighbours` are
    /// theirs.
    pub fn sample(&mut self, bodies: &Bodies, positions: &[DVec3], neighbours: &Neighbours) {
        self.of_particle.clear();
        self.of_particle.resize(positions.len(), Wall::default());
        self.blocks.resize_with(neighbours.lists().len(), BlockContacts::default);
        let (method, kernel, scale) = (&self.method, &self.kernel, self.per_rest_sum);
        let own = self.own_density;
        let probe = Probe { method, bodies, scale, own, support_radius: kernel.support_radius() };
        let blocks = neighbours.with(&mut self.of_particle).zip(&mut self.blocks);
        blocks.for_each(|((lists, walls), out)| {
            let first = lists.first;
            out.contacts.clear();
            out.inside.clear();
            out.drags.clear();
            for body in 0..bodies.posed().len() {
                let pairing =
                    Pairing { bodies, body, first, positions: &positions[lists.particles()], scale };
                out.touch(method, pairing);
                out.drag(method, pairing, kernel);
            }
            for contact in &out.contacts {
                walls[contact.particle as usize - first].add(contact);
            }
            out.find_pressed(walls, own, first);
            out.find_pinched(probe, &positions[lists.particles()], first);
        });
    }

    /// The contacts of particles (positions in metres) that are nobody's neighbours.
    pub fn sample_alone(&mut self, bodies: &Bodies, positions: &[DVec3]) {
        self.sample(bodies, positions, &Neighbours::none(positions.len()));
    }

    /// All contacts, in the order of the particles' blocks.
    pub fn contacts(&self) -> impl Iterator<Item = &Contact> {
        self.blocks.iter().flat_map(|block| &block.contacts)
    }

    /// Drag of all bodies whose surfaces have one, in the order of the particles' blocks.
    pub fn drags(&self) -> impl Iterator<Item = &Drag> {
        self.blocks.iter().flat_map(|block| &block.drags)
    }

    /// The same of the particles of one block.
    pub fn drags_of_block(&self, block: usize) -> &[Drag] {
        &self.blocks[block].drags
    }

    /// The contacts of a block of particles.
    pub fn contacts_of_block(&self, block: usize) -> &[Contact] {
        self.blocks.get(block).map_or(&[], |block| &block.contacts)
    }

    /// Particles that walls press, in order.
    pub fn pressed(&self) -> impl Iterator<Item = &Pressed> {
        self.blocks.iter().flat_map(|block| &block.pressed)
    }

    /// The same of one block.
    pub fn pressed_of_block(&self, block: usize) -> &[Pressed] {
        self.blocks.get(block).map_or(&[], |block| &block.pressed)
    }

    /// Largest speed of a body at a contact, m/s.
    pub fn max_speed(&self) -> f64 {
        self.contacts().map(|contact| contact.velocity.length_squared()).fold(0.0, f64::max).sqrt()
    }

    /// The particles whose centres are in a body.
    pub fn inside(&self) -> impl Iterator<Item = &Inside> {
        self.blocks.iter().flat_map(|block| &block.inside)
    }

    /// Boundary particles of all bodies; none where there are maps.
    pub fn particle_count(&self) -> usize {
        match &self.method {
            Method::Particles(_, bodies) => bodies.iter().map(|body| body.len()).sum(),
            _ => 0,
        }
    }

    /// Bytes held by contacts and boundary particles.
    pub fn memory_bytes(&self) -> usize {
        let contacts: usize = self.blocks.iter().map(|block| block.contacts.capacity()).sum();
        let particles = self.particle_count() * (size_of::<DVec3>() + size_of::<f64>());
        contacts * size_of::<Contact>() + self.of_particle.capacity() * size_of::<Wall>() + particles
    }
}

/// The closure for the fluid's particles, made by the first body's map; it must fit the others too.
fn closure(world: &World, fluid: &FluidSettings, bodies: &Bodies) -> Result<Option<Closure>, Error> {
    let radius = match world.closure.follows_volume() {
        true => 0.5 * world.rest_spacing(fluid),
        false => world.particle_radius,
    };
    let refuse = |body: usize, error: ClosureError| {
        let reason = format!("its map can't be used: {error}");
        Error::Setup { place: format!("body `{}`", bodies.name(body)), reason }
    };
    let Some(first) = bodies.posed().first() else { return Ok(None) };
    let closure = first.map.closure(world.closure, world.kernel_of_size(), radius);
    let closure = closure.map_err(|error| refuse(0, error))?;
    for (body, posed) in bodies.posed().iter().enumerate() {
        closure.check(&posed.map).map_err(|error| refuse(body, error))?;
    }
    Ok(Some(closure))
}

impl BlockContacts {
    fn touch(&mut self, method: &Method, pairing: Pairing) {
        let BlockContacts { contacts, inside, scratch, .. } = self;
        pairing.map().sample_batch(pairing.positions, &mut scratch.samples);
        inside.extend(scratch.samples.iter().enumerate().filter_map(|(i, at)| pairing.inside(i, at)));
        match method {
            Method::VolumeMap(Some(closure)) => {
                volume_map::touch(pairing, closure, &scratch.samples, contacts)
            }
            // Without bodies there is nothing to touch.
            Method::VolumeMap(None) => {}
            Method::DensityMap => density_map::touch(pairing, scratch, contacts),
            Method::Particles(kernels, all) => {
                particles::touch(pairing, kernels, &all[pairing.body], contacts);
            }
            Method::TubeMap(kernel) => tube_map::touch(pairing, kernel, scratch, contacts),
        }
    }

    /// Drag goes by the map's volume, whatever the method; after `touch`.
    fn drag(&mut self, method: &Method, pairing: Pairing, kernel: &Kernel) {
        let contact = pairing.bodies.fluid_contact(pairing.body);
        if contact == FluidContact::default() {
            return;
        }
        for (within, sample) in self.scratch.samples.iter().enumerate() {
            let Sample::Near(SurfaceWithGradient { surface: near, .. }) = sample else { continue };
            let volume = match method {
                Method::VolumeMap(Some(closure)) => closure.volume(near),
                _ => near.volume,
            };
            let (particle, body) = ((pairing.first + within) as u32, pairing.body as u32);
            let wide = volmap_runtime::Surface { volume, ..*near };
            self.drags.extend(Drag::new(particle, body, pairing.positions[within], &wide, contact, kernel));
        }
    }
}

impl Pairing<'_> {
    fn map(&self) -> &PosedMap {
        &self.bodies.posed()[self.body]
    }

    /// Whether the block's particle number `within` is in the body.
    fn inside(&self, within: usize, sample: &Sample<SurfaceWithGradient>) -> Option<Inside> {
        let way_out = match sample {
            Sample::DeepInside => None,
            Sample::Near(SurfaceWithGradient { surface: near, .. }) if near.distance < 0.0 => {
                Some(-near.distance * near.normal)
            }
            _ => return None,
        };
        Some(Inside { particle: (self.first + within) as u32, body: self.body as u32, way_out })
    }

    /// A contact of the block's particle number `within`.
    fn contact(&self, within: usize, density: f64, gradient: DVec3, point: DVec3) -> Contact {
        Contact {
            particle: (self.first + within) as u32,
            body: self.body as u32,
            site: 0,
            density: (self.scale * density) as f32,
            gradient: (self.scale * gradient).as_vec3().to_array(),
            point,
            velocity: self.bodies.velocity_at(self.body, point),
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
