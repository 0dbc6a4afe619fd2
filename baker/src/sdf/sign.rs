//! Which sign a mesh can bear, and how well the two agree.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::mesh::diagnosis::Diagnosis;
use crate::mesh::parts::Bounds;
use crate::sdf::mesh_distance::MeshDistance;

/// Points of disagreement that are kept, those of the largest distance first.
const MAX_WORST: usize = 8;

/// How inside and outside are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SignMethod {
    /// What `choose_sign` finds best.
    #[default]
    Auto,
    /// Angle-weighted pseudonormals: fast, for clean closed surfaces only.
    Pseudonormal,
    /// Winding number above one half: for holes, overlaps and soups.
    Winding,
}

/// A method, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignChoice {
    /// Never `Auto`.
    pub method: SignMethod,
    /// For a report.
    pub reason: String,
}

/// Pseudonormals for a surface that is closed, oriented and manifold and has no parts that may overlap;
/// else winding numbers. What this can't see, a component that intersects itself, `MeshDistance::new`
/// looks for.
pub fn choose_sign(diagnosis: &Diagnosis) -> SignChoice {
    let findings = [
        (!diagnosis.closed, "it is not closed"),
        (!diagnosis.oriented, "its triangles do not run the same way round"),
        (!diagnosis.manifold_vertices, "parts of it touch in single vertices"),
        (diagnosis.inside_out_components.count > 0, "a part of it is inside out"),
        (diagnosis.nested_solids.count > 0, "a solid lies inside another"),
        (diagnosis.overlapping_boxes.count > 0, "parts of it may overlap"),
        (!diagnosis.nesting_complete, "it has too many parts to tell whether they overlap"),
    ];
    match findings.iter().find(|(found, _)| *found) {
        Some((_, why)) => SignChoice {
            method: SignMethod::Winding,
            reason: format!("winding number, because of the surface {why}"),
        },
        None => SignChoice {
            method: SignMethod::Pseudonormal,
            reason: "pseudonormals: the surface is closed, oriented and manifold".to_string(),
        },
    }
}

/// Where the two signs differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignComparison {
    /// Number of points that were compared.
    pub points: usize,
    /// Number of points with different signs.
    pub disagreeing: usize,
    /// Some of those and their distances from the surface, the largest first.
    pub worst: Vec<([f64; 3], f64)>,
    /// Box of all of those.
    pub bounds: Option<Bounds>,
}

/// Compares both signs at the points.
pub fn compare_signs(distance: &MeshDistance, points: &[DVec3]) -> SignComparison {
    let mut found: Vec<(DVec3, f64)> = points
        .par_iter()
        .filter_map(|&p| {
            let closest = distance.closest(p);
            let differ = distance.inside_by_pseudonormal(p, &closest) != distance.inside_by_winding(p);
            differ.then(|| (p, closest.distance_squared.sqrt()))
        })
        .collect();
    let mut bounds = Bounds::EMPTY;
    found.iter().for_each(|(p, _)| bounds.grow(*p));
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    SignComparison {
        points: points.len(),
        disagreeing: found.len(),
        worst: found
            .iter()
            .take(MAX_WORST)
            .map(|(p, d)| (p.to_array(), *d))
            .collect(),
        bounds: (!found.is_empty()).then_some(bounds),
    }
}
