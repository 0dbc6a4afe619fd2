//! The state of a simulation at one moment, for those who write or draw it.

use volmap_formats::export::points::Values;
use volmap_runtime::{DVec3, Pose};

/// Particles and bodies. The lists have one element a particle, in any order.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Time simulated, seconds.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Particle radius, metres.
    pub particle_radius: f64,
    /// Mass of a particle, kg.
    pub particle_mass: f64,
    /// Rest density of the fluid, kg/m^3.
    pub rest_density: f64,
    /// A point near the fluid, metres, if all lies so far from the origin that single precision is too coarse for
    /// places; see [`particles::write`](super::particles::write).
    pub origin: Option<DVec3>,
    /// Places, metres.
    pub positions: &'a [DVec3],
    /// Velocities, m/s.
    pub velocities: &'a [[f32; 3]],
    /// Density in parts of the rest density. Files have kg/m^3.
    pub density: &'a [f32],
    /// Pressure, Pa.
    pub pressure: &'a [f32],
    /// A number that a particle keeps, whatever the order.
    pub ids: &'a [u32],
    /// What forces have each particle carry, with its name.
    pub channels: &'a [(&'static str, Values<'a>)],
    /// Rigid bodies, in the order of the scene.
    pub bodies: &'a [BodyFrame<'a>],
}

/// A body's place and motion.
#[derive(Clone, Copy, Debug)]
pub struct BodyFrame<'a> {
    /// Its name in the scene.
    pub name: &'a str,
    /// From its mesh's frame to the world.
    pub pose: Pose,
    /// Velocity of its centre of mass, m/s.
    pub velocity: DVec3,
    /// Angular velocity in the world, rad/s.
    pub angular_velocity: DVec3,
}
