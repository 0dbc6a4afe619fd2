//! The error of a density map at points, against Eq. 9 of Bender et al. 2020 on the exact distance to the mesh.

use super::model::{Model, Solid};
use super::reference::PAPER_RULE;
use super::statistics::Measurement;
use glam::DVec3;
use rayon::prelude::*;
use volmap_bake::density_map::DensitySettings;
use volmap_bake::density_map::oracle::extension;
use volmap_bake::sdf::{Neighbours, SignedDistance};
use volmap_bake::volume_map::quadrature::{Point, along_curve};
use volmap_bake::watch::{Cancelled, Watch};
use volmap_formats::asset::DensityField;

/// Points that are compared, at most: an integral of order 100 on the exact distance takes some 20 ms.
pub const POINTS: usize = 200;

/// Errors in rest densities at the first of the points that have a density; none if the kernel is not known.
///
/// # Errors
/// [`Cancelled`].
pub fn measure(
    model: &Model,
    density: &DensityField,
    solid: &Solid,
    points: &[DVec3],
    watch: &Watch,
) -> Result<Option<Vec<Measurement>>, Cancelled> {
    let Ok(kernel) = density.kernel.parse() else { return Ok(None) };
    let settings = DensitySettings { kernel, rule: PAPER_RULE, extension: 1.0 };
    let rule = along_curve(settings.points());
    let integral =
        Integral { solid, rule: &rule, radius: model.radius, extension_length: density.extension_length };
    let known: Vec<(DVec3, f64)> =
        points.iter().filter_map(|&x| Some((x, model.map.density(x)?.value))).take(POINTS).collect();
    let work = watch.begin("integrating the density", known.len() as u64)?;
    let error = |near: &mut Neighbours, &(point, value): &(DVec3, f64)| {
        work.check()?;
        let distance = model.map.values(point).distance;
        let measured = Measurement { point, distance, value, reference: integral.at(point, near) };
        work.add(1);
        Ok(measured)
    };
    known.par_iter().map_init(Neighbours::default, error).collect::<Result<_, _>>().map(Some)
}

/// Eq. 9 on the exact distance; the weights of the rule hold W.
struct Integral<'a> {
    solid: &'a Solid,
    rule: &'a [Point],
    /// Support radius, metres.
    radius: f64,
    /// Distance from the surface over which the density fades out, metres.
    extension_length: f64,
}

impl Integral<'_> {
    /// At a point: its places in groups that lie close together.
    fn at(&self, x: DVec3, near: &mut Neighbours) -> f64 {
        let mut sum = 0.0;
        for points in self.rule.chunks(Neighbours::MAX) {
            let mut places = [x; Neighbours::MAX];
            places.iter_mut().zip(points).for_each(|(place, point)| *place += self.radius * point.position);
            let places = &places[..points.len()];
            self.solid.phi.prepare(places, near, true);
            for ((point, place), known) in points.iter().zip(places).zip(&mut near.known) {
                let distance = self.solid.phi.near(*place, known);
                sum += point.weight * extension(distance, self.extension_length);
            }
        }
        sum
    }
}
