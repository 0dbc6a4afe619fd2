//! Rotation of free bodies: rapier keeps the angular velocity of a body that turns freely, nature keeps the
//! angular momentum. So a step gets the angular velocity of its middle, found by the implicit midpoint rule,
//! and what rapier changes of it (contacts, torques) is added to the angular momentum. Simo and Wong 1991,
//! *Unconditionally Stable Algorithms for Rigid Body Dynamics that Exactly Preserve Energy and Momentum*.

use super::mass::Mass;
use volmap_runtime::{DQuat, DVec3};

/// Iterations for the middle; each gains a factor of the angle of a step.
const ITERATIONS: usize = 4;

/// A body's rotation in a step.
pub(super) struct Turn {
    /// At the step's begin.
    rotation: DQuat,
    angular_momentum: DVec3,
    /// That of the middle, which rapier gets.
    pub angular_velocity: DVec3,
}

impl Turn {
    /// A step of `dt` seconds begins.
    pub fn begin(mass: &Mass, rotation: DQuat, angular_velocity: DVec3, dt: f64) -> Turn {
        let angular_momentum = mass.angular_momentum(rotation, angular_velocity);
        let mut middle = angular_velocity;
        for _ in 0..ITERATIONS {
            let half = DQuat::from_scaled_axis(middle * (0.5 * dt)) * rotation;
            middle = mass.angular_velocity(half, angular_momentum);
        }
        Turn { rotation, angular_momentum, angular_velocity: middle }
    }

    /// The step has ended with this rotation and rapier's angular velocity; the right one.
    pub fn end(&self, mass: &Mass, rotation: DQuat, angular_velocity: DVec3) -> DVec3 {
        // Rapier's inertia is that of the step's begin.
        let gained = mass.angular_momentum(self.rotation, angular_velocity - self.angular_velocity);
        mass.angular_velocity(rotation, self.angular_momentum + gained)
    }
}
