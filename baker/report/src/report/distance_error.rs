//! The errors of distance and normal at points, against the mesh itself.

use super::model::{Model, Solid};
use super::statistics::Measurement;
use glam::DVec3;
use rayon::prelude::*;
use volmap_bake::sdf::{Neighbours, SignedDistance};
use volmap_bake::watch::{Cancelled, Watch};
use volmap_runtime::Sample;

/// Errors of the distance, metres, and of the normal, degrees, with 0 for the right angle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DistanceErrors {
    /// At every point that lies in the band.
    pub distance: Vec<Measurement>,
    /// At those that have a normal.
    pub normal: Vec<Measurement>,
}

/// Measures at the points.
///
/// # Errors
/// [`Cancelled`].
pub fn measure(
    model: &Model,
    solid: &Solid,
    points: &[DVec3],
    watch: &Watch,
) -> Result<DistanceErrors, Cancelled> {
    let work = watch.begin("measuring the distance", points.len() as u64)?;
    let mut samples: Vec<Sample> = Vec::new();
    model.map.sample_batch(points, &mut samples);
    let one = |near: &mut Neighbours, (point, sample): (&DVec3, &Sample)| {
        if work.is_cancelled() {
            return None;
        }
        work.add(1);
        let boundary = sample.near()?;
        near.know(None);
        let exact = solid.phi.near(*point, &mut near.known[0]);
        let surface = near.known[0]?.surface;
        let distance =
            Measurement { point: *point, distance: exact, value: boundary.distance, reference: exact };
        // On the line to the closest point, away from the solid.
        let side = if exact + solid.phi.thickness < 0.0 { -1.0 } else { 1.0 };
        let normal = side * (*point - surface).normalize_or_zero();
        let known = normal != DVec3::ZERO && boundary.normal != DVec3::ZERO;
        let angle =
            known.then(|| Measurement { value: angle(boundary.normal, normal), reference: 0.0, ..distance });
        Some((distance, angle))
    };
    let pairs = points.par_iter().zip(&samples);
    let found: Vec<_> = pairs.map_init(Neighbours::default, one).flatten().collect();
    work.check()?;
    Ok(DistanceErrors {
        distance: found.iter().map(|(distance, _)| *distance).collect(),
        normal: found.iter().filter_map(|(_, normal)| *normal).collect(),
    })
}

/// Between two directions, degrees; exact for small angles too (Kahan 2006, "How futile are mindless assessments").
fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length()).to_degrees()
}
