//! A map placed in the world: many bodies share one map.

use crate::batch::{Answer, answer_all};
use crate::query::{Boundary, Sample, Values, VolumeMap};
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

/// Points that are brought into the map's frame at a time.
const BLOCK: usize = 512;

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
        self.in_world(point, self.map.sample(self.pose.to_map(point)))
    }

    /// [`VolumeMap::sample_batch`] of points of the world.
    pub fn sample_batch(&self, points: &[DVec3], samples: &mut Vec<Sample>) {
        samples.resize(points.len(), Sample::Outside);
        self.in_blocks(points, samples);
        for (&point, sample) in points.iter().zip(samples) {
            *sample = self.in_world(point, *sample);
        }
    }

    /// [`VolumeMap::sample_with_gradient`] of a point of the world, answered in the world.
    pub fn sample_with_gradient(&self, point: DVec3) -> (Sample, DVec3) {
        let (sample, gradient) = self.map.sample_with_gradient(self.pose.to_map(point));
        (self.in_world(point, sample), self.pose.rotation * gradient)
    }

    /// [`VolumeMap::sample_with_gradient_batch`] of points of the world.
    pub fn sample_with_gradient_batch(&self, points: &[DVec3], samples: &mut Vec<(Sample, DVec3)>) {
        samples.resize(points.len(), (Sample::Outside, DVec3::ZERO));
        self.in_blocks(points, samples);
        for (&point, (sample, gradient)) in points.iter().zip(samples) {
            *sample = self.in_world(point, *sample);
            *gradient = self.pose.rotation * *gradient;
        }
    }

    /// [`VolumeMap::values`] of a point of the world.
    pub fn values(&self, point: DVec3) -> Values {
        self.map.values(self.pose.to_map(point))
    }

    /// [`VolumeMap::values_batch`] of points of the world.
    pub fn values_batch(&self, points: &[DVec3], values: &mut Vec<Values>) {
        values.resize(points.len(), Values::default());
        self.in_blocks(points, values);
    }

    /// [`VolumeMap::inside`] of a point of the world.
    pub fn inside(&self, point: DVec3) -> bool {
        self.map.inside(self.pose.to_map(point))
    }

    /// The map's answers for points of the world.
    pub(crate) fn in_blocks<A: Answer>(&self, points: &[DVec3], out: &mut [A]) {
        let mut local = [DVec3::ZERO; BLOCK];
        for (points, out) in points.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
            for (local, &point) in local.iter_mut().zip(points) {
                *local = self.pose.to_map(point);
            }
            answer_all(&self.map, &local[..points.len()], out);
        }
    }

    fn in_world(&self, point: DVec3, sample: Sample) -> Sample {
        match sample {
            Sample::Near(at) => {
                let normal = self.pose.rotation * at.normal;
                Sample::Near(Boundary { normal, closest_point: point - at.distance * normal, ..at })
            }
            elsewhere => elsewhere,
        }
    }
}
