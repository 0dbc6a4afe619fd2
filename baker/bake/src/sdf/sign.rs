//! How inside and outside are told apart, and where the two ways differ.

use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mesh::diagnosis::Diagnosis;
use crate::mesh::parts::Bounds;
use crate::sdf::mesh_distance::MeshDistance;

/// Points of disagreement that are kept, those of the largest distance first.
const MAX_WORST: usize = 8;

/// How inside and outside are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum SignMethod {
    /// What `choose_sign` finds best.
    #[default]
    Auto,
    /// Angle-weighted pseudonormals: fast, right only for closed, oriented surfaces that don't intersect
    /// themselves.
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

/// Winding numbers, whatever the mesh, and how far they can be trusted.
///
/// Pseudonormals are wrong wherever a surface intersects itself, and no cheap test rules that out: of 84
/// closed meshes from modelling, scanning and CAD that were tried, 6 of a single component did (two of
/// them because concave polygons had been cut into fans), one in so small a place that it showed at 1 of
/// 41,000 points near the surface. Winding numbers take the union, and cost about as much as the
/// distance. Pseudonormals are there for comparison, and on demand.
pub fn choose_sign(diagnosis: &Diagnosis) -> SignChoice {
    let trust = if diagnosis.balanced {
        "exact, because every edge is run through as often one way as the other"
    } else if !diagnosis.oriented {
        "doubtful, because triangles do not run the same way round"
    } else {
        "an approximation near holes, because the surface is not closed"
    };
    SignChoice { method: SignMethod::Winding, reason: format!("winding number: {trust}") }
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

/// Triangles at whose centroids the signs are compared, at most.
const MAX_CENTROIDS: usize = 1 << 16;
/// Points spread evenly over the area.
const SPREAD_POINTS: usize = 1 << 13;

/// Points on both sides of the surface, a little off it: at the triangles' centroids, and, as a few large
/// triangles may hide what happens between, spread over the area.
pub fn points_near_surface(corners: &[[DVec3; 3]]) -> Vec<DVec3> {
    let mut lower = DVec3::INFINITY;
    let mut upper = DVec3::NEG_INFINITY;
    for corner in corners.iter().flatten() {
        lower = lower.min(*corner);
        upper = upper.max(*corner);
    }
    let size = (upper - lower).length();
    let stride = corners.len().div_ceil(MAX_CENTROIDS);
    let centroids =
        corners.iter().step_by(stride).map(|triangle| (at_weights(triangle, 1.0 / 3.0, 1.0 / 3.0), triangle));
    centroids
        .chain(spread_over_area(corners).into_iter().map(|(point, triangle)| (point, &corners[triangle])))
        .enumerate()
        .flat_map(|(i, (point, [a, b, c]))| {
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let offset = normal * size * [1e-5, 1e-3, 2e-2][i % 3];
            [point - offset, point + offset]
        })
        .collect()
}

/// Points at equal steps of summed area, and the indices of their triangles, at weights inside these that fill them
/// evenly: the plastic number's sequence of Roberts 2018.
pub fn spread_over_area(corners: &[[DVec3; 3]]) -> Vec<(DVec3, usize)> {
    let area = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a).length();
    let step = corners.iter().map(area).sum::<f64>() / SPREAD_POINTS as f64;
    let mut points = Vec::with_capacity(SPREAD_POINTS);
    let mut summed = 0.0;
    for (index, triangle) in corners.iter().enumerate() {
        summed += area(triangle);
        while points.len() < SPREAD_POINTS && (points.len() as f64 + 0.5) * step < summed {
            let k = points.len() as f64;
            let (u, v) = ((k * 0.754877666246693).fract(), (k * 0.569840290998053).fract());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            points.push((at_weights(triangle, u, v), index));
        }
    }
    points
}

fn at_weights([a, b, c]: &[DVec3; 3], u: f64, v: f64) -> DVec3 {
    *a + (*b - *a) * u + (*c - *a) * v
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
        worst: found.iter().take(MAX_WORST).map(|(p, d)| (p.to_array(), *d)).collect(),
        bounds: (!found.is_empty()).then_some(bounds),
    }
}
