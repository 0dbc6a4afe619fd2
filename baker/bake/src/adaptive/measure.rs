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
const POINTS: usize = 100;
/// Points among which those are found.
pub(super) const CANDIDATES: usize = 3000;

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

/// What errors are measured by: all that doesn't depend on the map.
pub(super) struct Reference<'a, D> {
    phi: &'a D,
    radius: f64,
    rule: Rule,
    points: Vec<Place>,
}

/// A point in the fluid near the surface, and what is there.
struct Place {
    at: DVec3,
    /// Phi, metres.
    distance: f64,
    /// Within a support radius of the surface, where that has one.
    normal: Option<DVec3>,
    /// V on the tree, m^3: tells where to look.
    estimate: f64,
    /// V on the exact distance, m^3, if it was integrated.
    exact: Option<f64>,
}

impl<'a, D: SignedDistance> Reference<'a, D> {
    /// At these points; `estimate` is by the same rule.
    pub fn new(
        phi: &'a D,
        radius: f64,
        rule: Rule,
        estimate: &TreeIntegrator,
        points: &[DVec3],
    ) -> Reference<'a, D> {
        let place = |&at: &DVec3| {
            let distance = phi.at(at);
            let normal = if distance <= radius { exact_normal(phi, at, radius) } else { None };
            Place { at, distance, normal, estimate: estimate.volume(at), exact: None }
        };
        Reference { phi, radius, rule, points: points.par_iter().map(place).collect() }
    }

    /// Measures a map: its errors, and the points at which one of them is larger than its tolerance.
    ///
    /// # Errors
    /// Cancelled.
    pub fn errors(
        &mut self,
        map: &VolumeMap,
        tolerances: &Tolerances,
        work: &Work,
    ) -> Result<(MapErrors, Vec<DVec3>), Error> {
        let ball = 4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3);
        let random = self.points.len().min(POINTS);
        let measured: Vec<usize> = (0..random).chain(self.worst(map)).collect();
        self.integrate(&measured, work)?;
        let error = |&n: &usize| {
            let Place { at, exact, .. } = &self.points[n];
            exact.map_or(0.0, |exact| (map.values(*at).volume - exact).abs() / ball)
        };
        let errors: Vec<f64> = measured.iter().map(error).collect();
        let volume = MeasuredError::of(&errors, &errors[..random]);
        let missed = measured.iter().zip(&errors).filter(|(_, error)| **error > SPARE * tolerances.volume);
        let mut missed: Vec<DVec3> = missed.map(|(n, _)| self.points[*n].at).collect();
        let (distance, normal) = self.of_surface(map, tolerances, &mut missed);
        Ok((MapErrors { volume, distance, normal }, missed))
    }

    /// Points but the first where the volume looks most wrong.
    fn worst(&self, map: &VolumeMap) -> impl Iterator<Item = usize> + use<D> {
        let looks = |(n, place): (usize, &Place)| ((map.values(place.at).volume - place.estimate).abs(), n);
        let mut order: Vec<(f64, usize)> =
            self.points.par_iter().enumerate().skip(POINTS).map(looks).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order.into_iter().take(POINTS).map(|(_, n)| n)
    }

    /// Makes the exact volume known at points.
    fn integrate(&mut self, which: &[usize], work: &Work) -> Result<(), Error> {
        let open: Vec<usize> = which.iter().copied().filter(|n| self.points[*n].exact.is_none()).collect();
        let places: Vec<DVec3> = open.iter().map(|n| self.points[*n].at).collect();
        let exact = integrals(self.phi, &along_curve(self.rule.points()), self.radius, &places, work)?;
        open.into_iter().zip(exact).for_each(|(n, exact)| self.points[n].exact = Some(exact));
        Ok(())
    }

    /// Of distance and normal.
    fn of_surface(
        &self,
        map: &VolumeMap,
        tolerances: &Tolerances,
        missed: &mut Vec<DVec3>,
    ) -> (MeasuredError, MeasuredError) {
        let error = |place: &Place| {
            let near = map.sample(place.at).near()?;
            let of_distance = (near.distance - place.distance).abs() / self.radius;
            let of_normal = place.normal.map(|normal| normal.angle_between(near.normal));
            (place.distance <= self.radius).then_some((place.at, of_distance, of_normal))
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
