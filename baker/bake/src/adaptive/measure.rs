//! How exact an adaptive map is, measured on the map as it will be stored, against the exact distance and a converged
//! rule.

use super::volume::TreeIntegrator;
use crate::error::Error;
use crate::sdf::SignedDistance;
use crate::settings::Tolerances;
use crate::tolerance::{MeasuredError, integrals};
use crate::volume_map::quadrature::{Rule, along_curve};
use crate::watch::Work;
use glam::DVec3;
use rayon::prelude::*;
use volmap_runtime::VolumeMap;

/// Points at which the exact volume is integrated: as many at random as where the error looks largest.
const POINTS: usize = 150;

/// Part of the tolerance of the volume above which a point is missed: other points have larger errors than those few.
const SPARE: f64 = 0.9;

/// Errors of a map near the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapErrors {
    /// Of the volume, parts of the full ball.
    pub volume: MeasuredError,
    /// Of the distance within a support radius of the surface, parts of the support radius.
    pub distance: MeasuredError,
    /// Of the normal there, radians, where the surface has one; the largest of 99 % of the points.
    pub normal: MeasuredError,
}

/// What errors are measured by.
pub(super) struct Reference<'a, D> {
    pub phi: &'a D,
    pub radius: f64,
    pub rule: Rule,
    /// A finer rule on the tree: tells where to look.
    pub estimate: &'a TreeIntegrator<'a>,
    /// In the fluid near the surface.
    pub points: &'a [DVec3],
}

impl<D: SignedDistance> Reference<'_, D> {
    /// Measures a map: its errors, and the points at which one of them is larger than its tolerance.
    ///
    /// # Errors
    /// Cancelled.
    pub fn errors(
        &self,
        map: &VolumeMap,
        tolerances: &Tolerances,
        work: &Work,
    ) -> Result<(MapErrors, Vec<DVec3>), Error> {
        let ball = 4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3);
        let looks = |x: &DVec3| (map.values(*x).volume - self.estimate.volume(*x)).abs();
        let mut order: Vec<(f64, usize)> =
            self.points.par_iter().enumerate().skip(POINTS).map(|(n, x)| (looks(x), n)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let worst = order.iter().take(POINTS).map(|(_, n)| self.points[*n]);
        let random = self.points.len().min(POINTS);
        let points: Vec<DVec3> = self.points[..random].iter().copied().chain(worst).collect();
        let exact = integrals(self.phi, &along_curve(self.rule.points()), self.radius, &points, work)?;
        let errors: Vec<f64> =
            points.iter().zip(exact).map(|(x, exact)| (map.values(*x).volume - exact).abs() / ball).collect();
        let volume = MeasuredError { points: points.len(), ..MeasuredError::of(&errors, &errors[..random]) };
        let missed = points.iter().zip(&errors).filter(|(_, error)| **error > SPARE * tolerances.volume);
        let mut missed: Vec<DVec3> = missed.map(|(x, _)| *x).collect();
        let (distance, normal) = self.of_surface(map, tolerances, &mut missed);
        Ok((MapErrors { volume, distance, normal }, missed))
    }

    /// Of distance and normal.
    fn of_surface(
        &self,
        map: &VolumeMap,
        tolerances: &Tolerances,
        missed: &mut Vec<DVec3>,
    ) -> (MeasuredError, MeasuredError) {
        let error = |x: &DVec3| {
            let exact = self.phi.at(*x);
            let near = map.sample(*x).near()?;
            let of_distance = (near.distance - exact).abs() / self.radius;
            (exact <= self.radius).then(|| (*x, of_distance, self.normal_error(*x, near.normal)))
        };
        let found: Vec<(DVec3, f64, Option<f64>)> = self.points.par_iter().filter_map(error).collect();
        let is_missed = |(_, distance, normal): &&(DVec3, f64, Option<f64>)| {
            let of_normal = normal.zip(tolerances.normal).is_some_and(|(found, most)| found > most);
            *distance > tolerances.distance || of_normal
        };
        missed.extend(found.iter().filter(is_missed).map(|(x, ..)| *x));
        let distances: Vec<f64> = found.iter().map(|(_, distance, _)| *distance).collect();
        let mut normals: Vec<f64> = found.iter().filter_map(|(.., normal)| *normal).collect();
        normals.sort_by(f64::total_cmp);
        normals.truncate(normals.len() * 99 / 100);
        (MeasuredError::of(&distances, &distances), MeasuredError::of(&normals, &normals))
    }

    /// The angle between a direction and the exact normal, radians; none where the distance has a kink.
    fn normal_error(&self, x: DVec3, direction: DVec3) -> Option<f64> {
        exact_normal(self.phi, x, self.radius).map(|normal| normal.angle_between(direction))
    }
}

/// Step of differences, in support radii.
const STEP: f64 = 1e-4;
/// The gradient of a distance has length 1 where it has one.
const KINK: f64 = 1e-3;

/// The gradient of the distance; none at a kink.
pub(super) fn exact_normal(phi: &impl SignedDistance, x: DVec3, radius: f64) -> Option<DVec3> {
    let step = STEP * radius;
    let slope = |axis: DVec3| (phi.at(x + step * axis) - phi.at(x - step * axis)) / (2.0 * step);
    let gradient = DVec3::from(DVec3::AXES.map(slope));
    ((gradient.length() - 1.0).abs() < KINK).then(|| gradient.normalize())
}
