//! Bodies: what the fluid touches, at rest, moved by a script or by forces. `rapier3d` moves the free ones
//! and keeps them apart; the fluid sees maps with poses.
//!
//! ```text
//! BodyDescription -> mass, shape -> Bodies
//! per step: apply (the fluid's forces) -> step -> posed, velocity_at
//! ```
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 5.3, for the two-way
//! coupling.
//!
//! Guaranteed: the same bytes on any number of threads; a restored snapshot goes on with the same bits; no
//! input makes a step panic. A free body without forces keeps its momentum and angular momentum to rounding.

mod description;
mod mass;
mod path;
mod shape;
mod snapshot;
mod spin;
mod world;

pub use description::{BodyDescription, ContactMaterial, FluidContact, FreeBody, Motion, Weight};
pub use mass::Mass;
pub use path::{Interpolation, Key, Keys, Moving, Path, Spin};

use crate::Error;
use rapier3d_f64::prelude::RigidBodyHandle;
use std::sync::Arc;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DVec3, Pose, PosedMap};
use world::World;

/// A free body holds another one up to so many times as heavy; a heavier one sinks into it, by 1.2 mm times the ratio
/// of their masses over this.
pub const MOST_UNLIKE: f64 = 1000.0;

/// All bodies of a simulation, and its time.
pub struct Bodies {
    bodies: Vec<Body>,
    posed: Vec<PosedMap>,
    velocities: Vec<Velocity>,
    /// Force and torque about the centre of mass for the next step.
    forces: Vec<[DVec3; 2]>,
    world: World,
    steps: u64,
    time: f64,
}

/// What doesn't change of a body.
struct Body {
    name: String,
    mesh: Option<Arc<TriangleMesh>>,
    start: Pose,
    motion: Motion,
    fluid_contact: FluidContact,
    /// Of free bodies.
    mass: Option<Mass>,
    handle: RigidBodyHandle,
}

/// A body's velocity at a point and its angular velocity.
#[derive(Clone, Copy)]
struct Velocity {
    at: DVec3,
    linear: DVec3,
    angular: DVec3,
}

/// A body as it is now, for output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Where its map stands.
    pub pose: Pose,
    /// Centre of mass of a free body; of others the map's origin. Metres, in the world.
    pub centre: DVec3,
    /// Velocity of `centre`, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
}

/// Sums over the free bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// kg m/s.
    pub momentum: DVec3,
    /// About the world's origin, kg m^2/s.
    pub angular_momentum: DVec3,
    /// Joule.
    pub kinetic_energy: f64,
    /// Joule; 0 with the centre of mass at the origin.
    pub potential_energy: f64,
}

/// Equal cells that stand for those of several sizes, at most.
const MOST_CELLS: u64 = 1 << 22;

impl Bodies {
    /// Bodies at time 0; gravity in m/s^2.
    ///
    /// # Errors
    /// [`Error::Setup`] for a body that can't be: no volume, not finite, no collision shape, an impossible
    /// path.
    pub fn new(descriptions: Vec<BodyDescription>, gravity: DVec3) -> Result<Bodies, Error> {
        if !gravity.is_finite() {
            return Err(refusal("gravity".into(), "it is not finite"));
        }
        let mut world = World::new(gravity);
        let mut shapes = shape::Shapes::default();
        let (mut bodies, mut posed) = (Vec::new(), Vec::new());
        for body in descriptions {
            let refuse = |reason: String| refusal(format!("body `{}`", body.name), reason);
            let start = body.checked_start().map_err(refuse)?;
            let mass = body.mass().map_err(refuse)?;
            let shape = shapes.get(&body, mass.is_some()).map_err(refuse)?;
            let pose = match &body.motion {
                Motion::Prescribed(path) => path.at(0.0, start).pose,
                Motion::Static | Motion::Free(_) => start,
            };
            let handle = world.add(&body, pose, mass.as_ref(), shape);
            posed.push(PosedMap { map: body.map, pose });
            let BodyDescription { name, mesh, motion, fluid_contact, .. } = body;
            bodies.push(Body { name, mesh, start, motion, fluid_contact, mass, handle });
        }
        let rest = Velocity { at: DVec3::ZERO, linear: DVec3::ZERO, angular: DVec3::ZERO };
        let count = bodies.len();
        let forces = vec![[DVec3::ZERO; 2]; count];
        let velocities = vec![rest; count];
        let mut all = Bodies { bodies, posed, velocities, forces, world, steps: 0, time: 0.0 };
        all.refresh();
        Ok(all)
    }

    /// The maps, where the bodies stand now; in the order of the descriptions.
    pub fn posed(&self) -> &[PosedMap] {
        &self.posed
    }

    /// Seconds since the start.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// A body's name.
    pub fn name(&self, body: usize) -> &str {
        &self.bodies[body].name
    }

    /// How a body's surface feels to the fluid.
    pub fn fluid_contact(&self, body: usize) -> FluidContact {
        self.bodies[body].fluid_contact
    }

    /// A body's mesh in its map's frame, if it was given.
    pub fn mesh(&self, body: usize) -> Option<&Arc<TriangleMesh>> {
        self.bodies[body].mesh.as_ref()
    }

    /// Whether forces move a body.
    pub fn is_free(&self, body: usize) -> bool {
        self.bodies[body].mass.is_some()
    }

    /// Mass and inertia of a free body, in the map's frame.
    pub fn mass(&self, body: usize) -> Option<&Mass> {
        self.bodies[body].mass.as_ref()
    }

    /// Velocity of a body's material at a point of the world, m/s.
    pub fn velocity_at(&self, body: usize, point: DVec3) -> DVec3 {
        let velocity = &self.velocities[body];
        velocity.linear + velocity.angular.cross(point - velocity.at)
    }

    /// Centre of mass of a free body, the map's origin of another; metres, in the world.
    pub fn center_of_mass(&self, body: usize) -> DVec3 {
        self.velocities[body].at
    }

    /// Adds to the force (N) and the torque about the centre of mass (N m) that act all through the next
    /// step. Bodies that aren't free ignore it.
    pub fn apply(&mut self, body: usize, force: DVec3, torque_about_centre_of_mass: DVec3) {
        self.forces[body][0] += force;
        self.forces[body][1] += torque_about_centre_of_mass;
    }

    /// Linear and angular acceleration (m/s^2, rad/s^2) that a force (N) and a torque about the centre of mass (N m)
    /// give a body; none if it isn't free, or along axes that are locked.
    pub fn response(&self, body: usize, force: DVec3, torque: DVec3) -> [DVec3; 2] {
        let (Motion::Free(free), Some(mass)) = (&self.bodies[body].motion, &self.bodies[body].mass) else {
            return [DVec3::ZERO; 2];
        };
        let unlocked =
            |locked: [bool; 3]| DVec3::from_array(locked.map(|locked| if locked { 0.0 } else { 1.0 }));
        let turning = unlocked(free.locked_rotation);
        let angular = mass.angular_velocity(self.posed[body].pose.rotation, torque * turning);
        [force / mass.mass * unlocked(free.locked_translation), angular * turning]
    }

    /// The same by gravity and all that was applied since the last step.
    pub fn acceleration(&self, body: usize) -> [DVec3; 2] {
        let [force, torque] = self.forces[body];
        let weight = self.bodies[body].mass.as_ref().map_or(0.0, |mass| mass.mass) * self.world.gravity();
        self.response(body, force + weight, torque)
    }

    /// Kinetic energy (J) that a body has after `dt` seconds of gravity and all that was applied since the last step; 0
    /// if it isn't free.
    pub(crate) fn energy_after(&self, body: usize, dt: f64) -> f64 {
        let Some(mass) = &self.bodies[body].mass else { return 0.0 };
        let (now, [linear, angular]) = (&self.velocities[body], self.acceleration(body));
        let (linear, angular) = (now.linear + dt * linear, now.angular + dt * angular);
        let spin = mass.angular_momentum(self.posed[body].pose.rotation, angular);
        0.5 * (mass.mass * linear.length_squared() + angular.dot(spin))
    }

    /// A body as it is now.
    pub fn state(&self, body: usize) -> BodyState {
        let velocity = &self.velocities[body];
        BodyState {
            pose: self.posed[body].pose,
            centre: velocity.at,
            velocity: velocity.linear,
            angular_velocity: velocity.angular,
        }
    }

    /// Momentum and energy of the free bodies.
    pub fn totals(&self) -> Totals {
        let mut totals = Totals::default();
        for ((body, posed), velocity) in self.bodies.iter().zip(&self.posed).zip(&self.velocities) {
            let Some(mass) = &body.mass else { continue };
            let momentum = mass.mass * velocity.linear;
            let spin = mass.angular_momentum(posed.pose.rotation, velocity.angular);
            totals.momentum += momentum;
            totals.angular_momentum += velocity.at.cross(momentum) + spin;
            totals.kinetic_energy += 0.5 * (velocity.linear.dot(momentum) + velocity.angular.dot(spin));
            totals.potential_energy -= mass.mass * self.world.gravity().dot(velocity.at);
        }
        totals
    }

    /// Goes on by `dt` seconds and forgets the forces.
    ///
    /// # Errors
    /// [`Error::Simulation`] for forces that aren't finite, or motions that have become so.
    pub fn step(&mut self, dt: f64) -> Result<(), Error> {
        let failure = |reason: String| Error::Simulation { step: self.steps, time: self.time, reason };
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(failure(format!("a time step of {dt} s")));
        }
        for (body, forces) in self.bodies.iter().zip(&self.forces) {
            if !forces.iter().all(|force| force.is_finite()) {
                let reason = "the fluid's force on it is not finite; take a smaller time step";
                return Err(failure(format!("body `{}`: {reason}", body.name)));
            }
        }
        self.world.step(&self.bodies, &self.forces, self.time, dt).map_err(failure)?;
        self.forces.fill([DVec3::ZERO; 2]);
        self.steps += 1;
        self.time += dt;
        self.refresh();
        Ok(())
    }

    /// Takes poses and velocities over from paths and from rapier.
    fn refresh(&mut self) {
        for (at, body) in self.bodies.iter().enumerate() {
            let (pose, velocity) = match (&body.motion, &body.mass) {
                (Motion::Prescribed(path), _) => {
                    let moving = path.at(self.time, body.start);
                    let (linear, angular) = (moving.velocity, moving.angular_velocity);
                    (moving.pose, Velocity { at: moving.pose.translation, linear, angular })
                }
                (Motion::Free(_), Some(mass)) => {
                    let (pose, linear, angular) = self.world.motion(body.handle);
                    (pose, Velocity { at: pose.to_world(mass.centre), linear, angular })
                }
                _ => {
                    let [linear, angular] = [DVec3::ZERO; 2];
                    (body.start, Velocity { at: body.start.translation, linear, angular })
                }
            };
            self.posed[at].pose = pose;
            self.velocities[at] = velocity;
        }
    }
}

fn refusal(place: String, reason: impl Into<String>) -> Error {
    Error::Setup { place, reason: reason.into() }
}
