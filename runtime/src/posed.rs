//! A map placed in the world: many bodies share one map.

use crate::map::VolumeMap;
use crate::pose::Pose;
use crate::query::Answer;
use crate::query::sealed::Answered;
use crate::sample::{MapDensity, Sample, SurfaceWithGradient, Values};
use glam::DVec3;
use std::sync::Arc;

/// Points that are brought into the map's frame at a time.
const BLOCK: usize = 512;

/// A body: a shared map and where it stands. It answers what the map does, for points of the world, in the world.
#[derive(Clone, Debug)]
pub struct PosedMap {
    /// The map.
    pub map: Arc<VolumeMap>,
    /// Where it stands.
    pub pose: Pose,
}

impl PosedMap {
    /// [`VolumeMap::sample`] of a point of the world (metres).
    pub fn sample(&self, point: impl Into<DVec3>) -> Sample {
        self.answer(point.into())
    }

    /// [`VolumeMap::sample_with_gradient`] of a point of the world.
    pub fn sample_with_gradient(&self, point: impl Into<DVec3>) -> Sample<SurfaceWithGradient> {
        self.answer(point.into())
    }

    /// [`VolumeMap::values`] of a point of the world.
    pub fn values(&self, point: impl Into<DVec3>) -> Values {
        self.answer(point.into())
    }

    /// [`VolumeMap::density`] of a point of the world.
    pub fn density(&self, point: impl Into<DVec3>) -> Option<MapDensity> {
        self.answer(point.into())
    }

    /// [`VolumeMap::inside`] of a point of the world.
    pub fn inside(&self, point: impl Into<DVec3>) -> bool {
        self.values(point).distance < 0.0
    }

    /// [`VolumeMap::sample_batch`] of points of the world.
    pub fn sample_batch<A: Answer>(&self, points: &[DVec3], answers: &mut Vec<A>) {
        answers.resize(points.len(), A::NONE);
        let mut local = [DVec3::ZERO; BLOCK];
        for (points, answers) in points.chunks(BLOCK).zip(answers.chunks_mut(BLOCK)) {
            for (local, &point) in local.iter_mut().zip(points) {
                *local = self.pose.to_map(point);
            }
            A::all(&self.map, &local[..points.len()], answers);
            for (answer, &point) in answers.iter_mut().zip(points) {
                *answer = answer.in_world(&self.pose, point);
            }
        }
    }

    fn answer<A: Answered>(&self, point: DVec3) -> A {
        let answer: A = self.map.answer(self.pose.to_map(point));
        answer.in_world(&self.pose, point)
    }
}
