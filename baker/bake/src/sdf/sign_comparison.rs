//! Where the two ways to tell inside from outside differ.

use super::mesh_distance::MeshDistance;
use crate::mesh::parts::Bounds;
use crate::watch::{Cancelled, Work};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Points of disagreement that are kept, those of the largest distance first.
const MAX_WORST: usize = 8;

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

/// Points that are compared between two looks at whether to stop.
const BLOCK: usize = 256;

/// Compares both signs at the points, each of which counts as work.
///
/// # Errors
/// [`Cancelled`].
pub fn compare_signs(
    distance: &MeshDistance,
    points: &[DVec3],
    work: &Work,
) -> Result<SignComparison, Cancelled> {
    let differs = |p: &DVec3| {
        let closest = distance.closest(*p);
        let differ = distance.inside_by_pseudonormal(*p, &closest) != distance.inside_by_winding(*p);
        differ.then(|| (*p, closest.distance_squared.sqrt()))
    };
    let block = |points: &[DVec3]| -> Result<Vec<(DVec3, f64)>, Cancelled> {
        work.check()?;
        let found = points.iter().filter_map(differs).collect();
        work.add(points.len() as u64);
        Ok(found)
    };
    let found: Result<Vec<_>, Cancelled> = points.par_chunks(BLOCK).map(block).collect();
    let mut found = found?.concat();
    let mut bounds = Bounds::EMPTY;
    found.iter().for_each(|(p, _)| bounds.grow(*p));
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(SignComparison {
        points: points.len(),
        disagreeing: found.len(),
        worst: found.iter().take(MAX_WORST).map(|(p, d)| (p.to_array(), *d)).collect(),
        bounds: (!found.is_empty()).then_some(bounds),
    })
}
