//! Asking a map: Bender et al. 2020, section 4.3; the density of Koschier and Bender 2017.
//!
//! The type of an answer says what is asked for. Each type has its code here, once: whoever asks links to it.

use crate::batch::answer_all;
use crate::map::VolumeMap;
use crate::pose::Pose;
use crate::sample::{MapDensity, Sample, Surface, SurfaceWithGradient, Values};
use glam::DVec3;

/// What a map can be asked for: [`Sample`], [`Sample<SurfaceWithGradient>`](SurfaceWithGradient), [`Values`], and
/// `Option<`[`MapDensity`]`>`. They cost the more the more they hold; no other type can implement it.
pub trait Answer: sealed::Answered {}

pub(crate) mod sealed {
    use super::{DVec3, Pose, VolumeMap};

    /// The code for one type of answer.
    pub trait Answered: Copy {
        /// What stands in for an answer before there is one.
        const NONE: Self;
        /// Answers all points, in the map's frame; `out` is as long.
        fn all(map: &VolumeMap, points: &[DVec3], out: &mut [Self]);
        /// The answer for a point of the world, from that of the map whose pose it is.
        fn in_world(self, pose: &Pose, point: DVec3) -> Self;
    }
}

use sealed::Answered;

impl VolumeMap {
    /// Distance, normal, closest point and volume at a point (metres, in the map's frame).
    pub fn sample(&self, point: impl Into<DVec3>) -> Sample {
        self.answer(point.into())
    }

    /// As [`VolumeMap::sample`], with the gradient of the volume.
    pub fn sample_with_gradient(&self, point: impl Into<DVec3>) -> Sample<SurfaceWithGradient> {
        self.answer(point.into())
    }

    /// Distance and volume at a point, in about two thirds of the time of [`VolumeMap::sample`].
    pub fn values(&self, point: impl Into<DVec3>) -> Values {
        self.answer(point.into())
    }

    /// Boundary density and its gradient at a point; both 0 outside the band. `None` if the map holds no density, and
    /// deep inside the solid, where it isn't known.
    ///
    /// The map holds rho_B / rho0 of Eq. 9 at its nodes, for one SPH kernel ([`VolumeMap::density_kernel`]). As in the
    /// papers, the gradient is that of the interpolated density: it jumps between cells.
    pub fn density(&self, point: impl Into<DVec3>) -> Option<MapDensity> {
        self.answer(point.into())
    }

    /// Whether a point lies in the solid: for filling a body with particles.
    pub fn inside(&self, point: impl Into<DVec3>) -> bool {
        self.values(point).distance < 0.0
    }

    /// The answers for many points into `answers`, whose old content is dropped: the same bits as one by one, two to
    /// four times as fast. What is asked for is the type of `answers`.
    pub fn sample_batch<A: Answer>(&self, points: &[DVec3], answers: &mut Vec<A>) {
        answers.resize(points.len(), A::NONE);
        A::all(self, points, answers);
    }

    pub(crate) fn answer<A: Answered>(&self, point: DVec3) -> A {
        let mut out = A::NONE;
        A::all(self, &[point], std::slice::from_mut(&mut out));
        out
    }
}

impl Answer for Sample {}

impl Answered for Sample {
    const NONE: Sample = Sample::Outside;

    fn all(map: &VolumeMap, points: &[DVec3], out: &mut [Sample]) {
        answer_all(map, points, out);
    }

    fn in_world(self, pose: &Pose, point: DVec3) -> Sample {
        self.map(|surface| surface_in_world(surface, pose, point))
    }
}

impl Answer for Sample<SurfaceWithGradient> {}

impl Answered for Sample<SurfaceWithGradient> {
    const NONE: Sample<SurfaceWithGradient> = Sample::Outside;

    fn all(map: &VolumeMap, points: &[DVec3], out: &mut [Sample<SurfaceWithGradient>]) {
        answer_all(map, points, out);
    }

    fn in_world(self, pose: &Pose, point: DVec3) -> Sample<SurfaceWithGradient> {
        self.map(|near| SurfaceWithGradient {
            surface: surface_in_world(near.surface, pose, point),
            volume_gradient: pose.rotation * near.volume_gradient,
        })
    }
}

fn surface_in_world(at: Surface, pose: &Pose, point: DVec3) -> Surface {
    let normal = pose.rotation * at.normal;
    Surface { normal, closest_point: point - at.distance * normal, ..at }
}

impl Answer for Values {}

impl Answered for Values {
    const NONE: Values = Values { distance: f64::INFINITY, volume: 0.0 };

    fn all(map: &VolumeMap, points: &[DVec3], out: &mut [Values]) {
        answer_all(map, points, out);
    }

    fn in_world(self, _: &Pose, _: DVec3) -> Values {
        self
    }
}

impl Answer for Option<MapDensity> {}

impl Answered for Option<MapDensity> {
    const NONE: Option<MapDensity> = None;

    fn all(map: &VolumeMap, points: &[DVec3], out: &mut [Option<MapDensity>]) {
        answer_all(map, points, out);
    }

    fn in_world(self, pose: &Pose, _: DVec3) -> Option<MapDensity> {
        self.map(|density| MapDensity { gradient: pose.rotation * density.gradient, ..density })
    }
}
