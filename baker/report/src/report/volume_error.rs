//! The error of the volume at random points of the band, against every reference, and its parts.
//!
//! From the right volume to the asset's answer, one step at a time:
//!
//! ```text
//! fine rule, exact distance -> fine rule, own distance    interpolation of Phi
//!                           -> own rule, own distance     quadrature
//!                           -> that at nodes, in between  interpolation of V
//!                           -> what is stored             precision, rounding
//! ```
//! The four differences add up to the whole error.

use super::model::{Model, Solid};
use super::reference::{ExactIntegrals, OwnIntegrals, Reference, shape_volume};
use super::shape::Shape;
use super::statistics::Measurement;
use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use volmap_bake::sdf::Neighbours;
use volmap_bake::volume_map::anywhere::Block;
use volmap_bake::work::Work;
use volmap_runtime::layout::serendipity::{node, shape};

/// The parts of an error, m^3, signed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// Because Phi is a polynomial on each cell.
    pub interpolation_of_distance: Option<f64>,
    /// Because the rule is what it is.
    pub quadrature: f64,
    /// Because V is a polynomial on each cell.
    pub interpolation_of_volume: f64,
    /// Because numbers are stored in few bits.
    pub storage: f64,
}

/// Names of the parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// See [`Parts`].
    InterpolationOfDistance,
    /// See [`Parts`].
    Quadrature,
    /// See [`Parts`].
    InterpolationOfVolume,
    /// See [`Parts`].
    Storage,
}

impl Part {
    /// In the order of the steps.
    pub const ALL: [Part; 4] =
        [Part::InterpolationOfDistance, Part::Quadrature, Part::InterpolationOfVolume, Part::Storage];

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Part::InterpolationOfDistance => "interpolation of the distance",
            Part::Quadrature => "quadrature",
            Part::InterpolationOfVolume => "interpolation of the volume",
            Part::Storage => "precision and rounding of what is stored",
        }
    }

    /// Of all parts.
    pub fn of(self, parts: &Parts) -> Option<f64> {
        match self {
            Part::InterpolationOfDistance => parts.interpolation_of_distance,
            Part::Quadrature => Some(parts.quadrature),
            Part::InterpolationOfVolume => Some(parts.interpolation_of_volume),
            Part::Storage => Some(parts.storage),
        }
    }
}

/// What is known at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeSample {
    /// Where, metres.
    pub point: DVec3,
    /// The asset's signed distance there, metres.
    pub distance: f64,
    /// The asset's volume, m^3.
    pub volume: f64,
    /// By the order of [`Reference::ALL`], where it was computed.
    pub references: [Option<f64>; Reference::ALL.len()],
    /// Parts, where they are known.
    pub parts: Option<Parts>,
}

/// What to measure.
pub struct Measuring<'a> {
    /// The asset.
    pub model: &'a Model,
    /// The solid.
    pub solid: Option<&'a Solid>,
    /// The shape that the mesh stands for.
    pub shape: Option<Shape>,
    /// Compare with the paper's rule on the exact distance too, at so many points.
    pub gl100_mesh_points: usize,
    /// Points at which integrals on the exact distance are found.
    pub mesh_points: usize,
}

/// Measures at the points; each counts as work.
pub fn measure(measuring: &Measuring, points: &[DVec3], work: &Work) -> Vec<VolumeSample> {
    let own = OwnIntegrals::new(measuring.model);
    let exact = measuring.solid.map(|solid| ExactIntegrals::new(solid, measuring.model.radius));
    let sample = |(block, near): &mut (Block, Neighbours), (number, x): (usize, &DVec3)| {
        let sample = sample(measuring, &own, exact.as_ref(), (number, *x), (block, near));
        work.add(1);
        sample
    };
    // In small tasks: the first points, which are compared with the mesh, take much longer.
    let tasks = points.par_iter().enumerate().with_max_len(16);
    tasks.map_init(Default::default, sample).collect()
}

fn sample(
    measuring: &Measuring,
    own: &OwnIntegrals,
    exact: Option<&ExactIntegrals>,
    (number, x): (usize, DVec3),
    (block, near): (&mut Block, &mut Neighbours),
) -> VolumeSample {
    let model = measuring.model;
    let found = model.map.values(x);
    let [paper, fine] = own.both(x, block);
    let exact = exact.filter(|_| number < measuring.mesh_points);
    let fine_mesh = exact.map(|exact| exact.fine(x, near));
    let paper_mesh = exact.filter(|_| number < measuring.gl100_mesh_points).map(|exact| exact.paper(x, near));
    let shape = measuring.shape.map(|shape| shape_volume(&shape, model.radius, x));
    let parts = (number < measuring.mesh_points)
        .then(|| parts(model, own, (x, found.volume), [Some(fine), fine_mesh], block))
        .flatten();
    VolumeSample {
        point: x,
        distance: found.distance,
        volume: found.volume,
        references: [Some(paper), Some(fine), paper_mesh, fine_mesh, shape],
        parts,
    }
}

/// None where the rule is not known, or the domain cuts what the nodes around the point see.
fn parts(
    model: &Model,
    own: &OwnIntegrals,
    (x, stored): (DVec3, f64),
    [fine, fine_mesh]: [Option<f64>; 2],
    block: &mut Block,
) -> Option<Parts> {
    let grid = &model.field.grid;
    let at = grid.locate(x)?;
    let corner = grid.cell_corner(at.cell);
    let (low, high) = (corner - model.radius, corner + grid.cell_size + model.radius);
    if !own.knows(low, high) {
        return None;
    }
    let quadrature = own.own(x, block)?;
    let weights = shape(at.xi);
    let mut interpolated = 0.0;
    for (a, weight) in weights.into_iter().enumerate() {
        let place = corner + 0.5 * (node(a) + 1.0) * grid.cell_size;
        interpolated += weight * own.own(place, block)?;
    }
    let fine = fine?;
    Some(Parts {
        interpolation_of_distance: fine_mesh.map(|exact| fine - exact),
        quadrature: quadrature - fine,
        interpolation_of_volume: interpolated - quadrature,
        storage: stored - interpolated,
    })
}

impl VolumeSample {
    /// Against a reference, where it was computed.
    pub fn against(&self, reference: Reference) -> Option<Measurement> {
        let right = self.references[reference as usize]?;
        Some(Measurement { point: self.point, distance: self.distance, value: self.volume, reference: right })
    }
}
