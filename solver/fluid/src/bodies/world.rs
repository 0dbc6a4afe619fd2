//! The one place that calls rapier: its world is built, stepped and watched here.

use super::description::{BodyDescription, Motion};
use super::mass::Mass;
use super::spin::Turn;
use super::{Body, MOST_UNLIKE, Path};
use rapier3d_f64::dynamics::FrictionModel;
use rapier3d_f64::parry::mass_properties::MassProperties;
use rapier3d_f64::prelude::{
    ColliderBuilder, IntegrationParameters, LockedAxes, PhysicsWorld, RigidBody, RigidBodyBuilder,
    RigidBodyHandle, SharedShape,
};
use volmap_formats::mesh::guard;
use volmap_runtime::{DVec3, Pose};

/// Longest step of contacts, seconds; longer ones are split.
const LONGEST_STEP: f64 = 1.0 / 120.0;

/// Contacts are springs that follow the lighter of two bodies: under a weight of so many of them it sinks in by that
/// times a third of a millimetre. From here on they are stiffer, so that like masses keep what they had.
const LIKE_MASSES: f64 = 4.0;

/// Rapier's world.
pub(super) struct World {
    pub physics: PhysicsWorld,
    /// The least and the largest mass of its free bodies.
    masses: [f64; 2],
}

impl World {
    pub fn new(gravity: DVec3) -> World {
        let mut physics = PhysicsWorld { gravity, ..PhysicsWorld::default() };
        let parameters = &mut physics.integration_parameters;
        parameters.normalized_max_linear_velocity = f64::MAX;
        // Measured with a duck on a floor: with rapier's 0.05, contacts that are reused feed its rocking for
        // ever; so does, a little, taking four of many contacts.
        parameters.normalized_contact_recycle_distance = 0.002;
        parameters.contact_clustering = false;
        // Against closed forms, sliding friction is right to 1 %; the other model (Coulomb) lacks 6 %.
        parameters.friction_model = FrictionModel::Simplified;
        World { physics, masses: [f64::INFINITY, 0.0] }
    }

    pub fn gravity(&self) -> DVec3 {
        self.physics.gravity
    }

    /// A body that has been checked.
    pub fn add(
        &mut self,
        description: &BodyDescription,
        pose: Pose,
        mass: Option<&Mass>,
        shape: SharedShape,
    ) -> RigidBodyHandle {
        let size = shape.compute_local_aabb().extents().min_element();
        let body = match (&description.motion, mass) {
            (Motion::Free(free), Some(mass)) => {
                self.keep_in_proportion(size);
                self.stiffen(mass.mass);
                RigidBodyBuilder::dynamic()
                    .additional_mass_properties(rapier_mass(mass))
                    .linvel(free.velocity)
                    .angvel(free.angular_velocity)
                    .locked_axes(locked(free.locked_translation, free.locked_rotation))
            }
            (Motion::Prescribed(_), _) => RigidBodyBuilder::kinematic_position_based(),
            _ => RigidBodyBuilder::fixed(),
        };
        // `Turn` does what gyroscopic forces do; a body asleep would not feel the fluid.
        let body = body.pose(to_rapier(pose)).gyroscopic_forces_enabled(false).can_sleep(false);
        let collider = ColliderBuilder::new(shape)
            .density(0.0)
            .friction(description.material.friction)
            .restitution(description.material.restitution);
        let (handle, _) = self.physics.insert(body, collider);
        let PhysicsWorld { bodies, colliders, .. } = &mut self.physics;
        bodies[handle].recompute_mass_properties_from_colliders(colliders);
        handle
    }

    /// Tolerances of contacts follow the smallest free body.
    fn keep_in_proportion(&mut self, size: f64) {
        let has_free = self.physics.bodies.iter().any(|(_, body)| body.is_dynamic());
        let unit = &mut self.physics.integration_parameters.length_unit;
        *unit = if has_free { unit.min(size) } else { size };
    }

    /// Stiffness of contacts follows the free bodies' masses, of which this is one: a light one holds a heavy one as
    /// one like it, by stiffer springs in proportion, and parts of the step that are short enough for them.
    fn stiffen(&mut self, mass: f64) {
        let [least, largest] = &mut self.masses;
        (*least, *largest) = (least.min(mass), largest.max(mass));
        let unlike = (*largest / *least).min(MOST_UNLIKE);
        if unlike <= LIKE_MASSES {
            return;
        }
        let stiffer = (unlike / LIKE_MASSES).sqrt();
        let rapier = IntegrationParameters::default();
        let parameters = &mut self.physics.integration_parameters;
        parameters.contact_softness.natural_frequency = stiffer * rapier.contact_softness.natural_frequency;
        parameters.static_contact_softness.natural_frequency =
            stiffer * rapier.static_contact_softness.natural_frequency;
        let parts = (2.0 * stiffer).ceil() as usize;
        parameters.num_solver_iterations = parts.max(rapier.num_solver_iterations);
    }

    /// Pose, velocity of the centre of mass, angular velocity.
    pub fn motion(&self, handle: RigidBodyHandle) -> (Pose, DVec3, DVec3) {
        let body = &self.physics.bodies[handle];
        (from_rapier(body.position()), body.linvel(), body.angvel())
    }

    /// Goes from `time` to `time + dt` under constant forces and torques.
    pub fn step(&mut self, bodies: &[Body], forces: &[[DVec3; 2]], time: f64, dt: f64) -> Result<(), String> {
        for (body, [force, torque]) in bodies.iter().zip(forces).filter(|(body, _)| body.mass.is_some()) {
            let rapier = &mut self.physics.bodies[body.handle];
            rapier.reset_forces(false);
            rapier.reset_torques(false);
            rapier.add_force(*force, true);
            rapier.add_torque(*torque, true);
        }
        let parts = (dt / LONGEST_STEP).ceil().max(1.0);
        if parts > 1e6 {
            return Err(format!("a time step of {dt} s is too long for contacts of bodies"));
        }
        self.physics.integration_parameters.dt = dt / parts;
        for part in 1..=parts as u32 {
            self.part_step(bodies, time + dt * (f64::from(part) / parts))?;
        }
        Ok(())
    }

    /// A step of rapier, up to time `end`.
    fn part_step(&mut self, bodies: &[Body], end: f64) -> Result<(), String> {
        let dt = self.physics.integration_parameters.dt;
        let mut turns = Vec::with_capacity(bodies.len());
        for body in bodies {
            let rapier = &mut self.physics.bodies[body.handle];
            if let Motion::Prescribed(path) = &body.motion {
                rapier.set_next_kinematic_position(to_rapier(pose_at(path, end, body)));
            }
            turns.push(turning(body).map(|mass| {
                let turn = Turn::begin(mass, from_rapier(rapier.position()).rotation, rapier.angvel(), dt);
                rapier.set_angvel(turn.angular_velocity, true);
                turn
            }));
        }
        guard::quietly(|| self.physics.step())
            .map_err(|reason| format!("the collisions of bodies can't be solved: {reason}"))?;
        for (body, turn) in bodies.iter().zip(turns) {
            let rapier = &mut self.physics.bodies[body.handle];
            if let (Some(mass), Some(turn)) = (turning(body), turn) {
                let rotation = from_rapier(rapier.position()).rotation;
                rapier.set_angvel(turn.end(mass, rotation, rapier.angvel()), true);
            }
            if !is_finite(rapier) {
                let reason = "its motion is not finite any more; take a smaller time step";
                return Err(format!("body `{}`: {reason}", body.name));
            }
        }
        Ok(())
    }
}

/// The mass of a body that turns freely.
fn turning(body: &Body) -> Option<&Mass> {
    match &body.motion {
        Motion::Free(free) if free.locked_rotation == [false; 3] => body.mass.as_ref(),
        _ => None,
    }
}

fn pose_at(path: &Path, time: f64, body: &Body) -> Pose {
    path.at(time, body.start).pose
}

/// Rapier disables bodies that aren't finite.
fn is_finite(body: &RigidBody) -> bool {
    let finite = body.position().is_finite() && body.linvel().is_finite() && body.angvel().is_finite();
    finite && body.is_enabled()
}

fn rapier_mass(mass: &Mass) -> MassProperties {
    MassProperties::with_inertia_matrix(mass.centre, mass.mass, mass.inertia)
}

fn locked(translation: [bool; 3], rotation: [bool; 3]) -> LockedAxes {
    let axes = [
        LockedAxes::TRANSLATION_LOCKED_X,
        LockedAxes::TRANSLATION_LOCKED_Y,
        LockedAxes::TRANSLATION_LOCKED_Z,
        LockedAxes::ROTATION_LOCKED_X,
        LockedAxes::ROTATION_LOCKED_Y,
        LockedAxes::ROTATION_LOCKED_Z,
    ];
    let is_locked = translation.into_iter().chain(rotation);
    axes.into_iter().zip(is_locked).filter(|(_, locked)| *locked).map(|(axis, _)| axis).collect()
}

fn to_rapier(pose: Pose) -> rapier3d_f64::math::Pose {
    rapier3d_f64::math::Pose::from_parts(pose.translation, pose.rotation)
}

fn from_rapier(pose: &rapier3d_f64::math::Pose) -> Pose {
    Pose { rotation: pose.rotation, translation: pose.translation }
}
