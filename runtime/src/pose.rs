//! A map placed in the world: many bodies share one map.

use crate::query::{Boundary, Sample, VolumeMap};
use glam::{DQuat, DVec3};
use std::sync::Arc;

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

/// A body: a shared map and where it stands.
#[derive(Clone, Debug)]
pub struct PosedMap {
    /// The map.
    pub map: Arc<VolumeMap>,
    /// Where it stands.
    pub pose: Pose,
}

impl PosedMap {
    /// [`VolumeMap::sample`] of a point of the world, answered in the world.
    pub fn sample(&self, point: DVec3) -> Sample {
        match self.map.sample(self.pose.to_map(point)) {
            Sample::Near(at) => {
                let normal = self.pose.rotation * at.normal;
                Sample::Near(Boundary { normal, closest_point: point - at.distance * normal, ..at })
            }
            elsewhere => elsewhere,
        }
    }

    /// [`VolumeMap::sample_batch`] of points of the world.
    pub fn sample_batch(&self, points: &[DVec3], samples: &mut Vec<Sample>) {
        samples.clear();
        samples.extend(points.iter().map(|&point| self.sample(point)));
    }

    /// [`VolumeMap::inside`] of a point of the world.
    pub fn inside(&self, point: DVec3) -> bool {
        self.map.inside(self.pose.to_map(point))
    }
}
