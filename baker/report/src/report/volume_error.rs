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
use super::shape::ClosedForm;
use super::statistics::Measurement;
use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use volmap_bake::sdf::Neighbours;
use volmap_bake::volume_map::anywhere::Block;
use volmap_bake::watch::{Cancelled, Watch};
use volmap_runtime::layout::serendipity::{node, shape};

/// The parts of an error, m^3, signed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorParts {
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
#[schemars(rename = "Part")]
pub enum ErrorPart {
    /// See `ErrorParts`.
    InterpolationOfDistance,
    /// See `ErrorParts`.
    Quadrature,
    /// See `ErrorParts`.
    InterpolationOfVolume,
    /// See `ErrorParts`.
    Storage,
}

impl ErrorPart {
    /// In the order of the steps.
    pub const ALL: [ErrorPart; 4] = [
        ErrorPart::InterpolationOfDistance,
        ErrorPart::Quadrature,
        ErrorPart::InterpolationOfVolume,
        ErrorPart::Storage,
    ];

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            ErrorPart::InterpolationOfDistance => "interpolation of the distance",
            ErrorPart::Quadrature => "quadrature",
            ErrorPart::InterpolationOfVolume => "interpolation of the volume",
            ErrorPart::Storage => "precision and rounding of what is stored",
        }
    }

    /// Of all parts.
    pub fn of(self, parts: &ErrorParts) -> Option<f64> {
        match self {
            ErrorPart::InterpolationOfDistance => parts.interpolation_of_distance,
            ErrorPart::Quadrature => Some(parts.quadrature),
            ErrorPart::InterpolationOfVolume => Some(parts.interpolation_of_volume),
            ErrorPart::Storage => Some(parts.storage),
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
    pub parts: Option<ErrorParts>,
}

/// What to measure.
pub struct Measuring<'a> {
    /// The asset.
    pub model: &'a Model,
    /// The solid.
    pub solid: Option<&'a Solid>,
    /// The shape that the mesh stands for.
    pub shape: Option<ClosedForm>,
    /// Compare with the paper's rule on the exact distance too, at so many points.
    pub gl100_mesh_points: usize,
    /// Points at which integrals on the exact distance are found.
    pub mesh_points: usize,
}

/// Measures at the points.
///
/// # Errors
/// [`Cancelled`].
pub fn measure(
    measuring: &Measuring,
    points: &[DVec3],
    watch: &Watch,
) -> Result<Vec<VolumeSample>, Cancelled> {
    let work = watch.begin("integrating at random points", points.len() as u64)?;
    let sampler = Sampler {
        measuring,
        own: OwnIntegrals::new(measuring.model),
        exact: measuring.solid.map(|solid| ExactIntegrals::new(solid, measuring.model.radius)),
    };
    let sample = |scratch: &mut Scratch, (number, x): (usize, &DVec3)| {
        work.check()?;
        let sample = sampler.sample(number, *x, scratch);
        work.add(1);
        Ok(sample)
    };
    // In small tasks: the first points, which are compared with the mesh, take much longer.
    let tasks = points.par_iter().enumerate().with_max_len(16);
    tasks.map_init(Scratch::default, sample).collect()
}

/// Memory of a thread for one integral after the other.
#[derive(Default)]
struct Scratch {
    block: Block,
    near: Neighbours,
}

/// The integrals that samples are compared with.
struct Sampler<'a> {
    measuring: &'a Measuring<'a>,
    own: OwnIntegrals<'a>,
    exact: Option<ExactIntegrals<'a>>,
}

impl Sampler<'_> {
    /// The point of this number.
    fn sample(&self, number: usize, x: DVec3, scratch: &mut Scratch) -> VolumeSample {
        let (measuring, model) = (self.measuring, self.measuring.model);
        let found = model.map.values(x);
        let [paper, fine] = self.own.both(x, &mut scratch.block);
        let with_mesh = number < measuring.mesh_points;
        let exact = self.exact.as_ref().filter(|_| with_mesh);
        let fine_mesh = exact.map(|exact| exact.fine(x, &mut scratch.near));
        let paper_mesh = exact
            .filter(|_| number < measuring.gl100_mesh_points)
            .map(|exact| exact.paper(x, &mut scratch.near));
        let shape = measuring.shape.map(|shape| shape_volume(&shape, model.radius, x));
        let mut sample = VolumeSample {
            point: x,
            distance: found.distance,
            volume: found.volume,
            references: [Some(paper), Some(fine), paper_mesh, fine_mesh, shape],
            parts: None,
        };
        if with_mesh {
            sample.parts = self.parts(&sample, &mut scratch.block);
        }
        sample
    }

    /// None where the rule is not known, or the domain cuts what the nodes around the point see.
    fn parts(&self, sample: &VolumeSample, block: &mut Block) -> Option<ErrorParts> {
        let (model, x) = (self.measuring.model, sample.point);
        let grid = &model.field.grid;
        let at = grid.locate(x)?;
        let corner = grid.cell_corner(at.cell);
        let (low, high) = (corner - model.radius, corner + grid.cell_size + model.radius);
        if !self.own.knows(low, high) {
            return None;
        }
        let quadrature = self.own.own(x, block)?;
        let weights = shape(at.xi);
        let mut interpolated = 0.0;
        for (a, weight) in weights.into_iter().enumerate() {
            let place = corner + 0.5 * (node(a) + 1.0) * grid.cell_size;
            interpolated += weight * self.own.own(place, block)?;
        }
        let [fine, fine_mesh] =
            [Reference::FineOwn, Reference::FineMesh].map(|reference| sample.references[reference as usize]);
        let fine = fine?;
        Some(ErrorParts {
            interpolation_of_distance: fine_mesh.map(|exact| fine - exact),
            quadrature: quadrature - fine,
            interpolation_of_volume: interpolated - quadrature,
            storage: sample.volume - interpolated,
        })
    }
}

impl VolumeSample {
    /// Against a reference, where it was computed.
    pub fn against(&self, reference: Reference) -> Option<Measurement> {
        let right = self.references[reference as usize]?;
        Some(Measurement { point: self.point, distance: self.distance, value: self.volume, reference: right })
    }
}
