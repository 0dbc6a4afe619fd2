//! Where a body stands.

use glam::{DQuat, DVec3};

/// A rigid motion: first the rotation, then the translation (metres).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation from the map's frame to the world's, of length 1.
    pub rotation: DQuat,
    /// Place of the map's origin in the world.
    pub translation: DVec3,
}

impl Default for Pose {
    fn default() -> Self {
        Pose { rotation: DQuat::IDENTITY, translation: DVec3::ZERO }
    }
}

impl Pose {
    /// A point of the map's frame, in the world.
    pub fn to_world(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// A point of the world, in the map's frame.
    pub fn to_map(&self, point: DVec3) -> DVec3 {
        self.rotation.conjugate() * (point - self.translation)
    }
}
