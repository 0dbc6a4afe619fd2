//! From polygons as a file has them to a tidy triangle mesh.
//!
//! weld vertices -> triangulate polygons, drop collapsed ones -> drop vertices that nothing refers to
//! -> drop duplicate triangles. Order is kept, so the result is a function of the input alone.

mod duplicates;
mod triangulate;
mod weld;

use self::triangulate::{Outcome, Triangulator};
use super::TriangleMesh;
use super::error::MeshError;
use super::raw::RawMesh;
use super::skipped::Skipped;
use glam::DVec3;

/// A triangle's sides are numbered, and a bit is left for their directions.
const MAX_TRIANGLES: usize = (1 << 31) / 3;

/// How to clean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CleanSettings {
    /// Vertices within this distance become one, in the file's unit. 0: only equal positions.
    pub weld_tolerance: f64,
}

/// What cleaning found and did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CleanReport {
    /// Objects that were joined (0: the format doesn't say).
    pub objects: usize,
    /// The file's unit in metres, where the format defines it.
    pub unit: Option<f64>,
    /// Faces of the file that are triangles.
    pub triangles: usize,
    /// Faces of the file with four corners.
    pub quads: usize,
    /// Faces of the file with five or more corners.
    pub polygons: usize,
    /// Polygons whose ear clipping failed (they intersect themselves): split as fans.
    pub fan_fallbacks: usize,
    /// Vertices that were merged into others.
    pub welded: usize,
    /// Dropped: faces whose corners were not three different vertices after welding.
    pub degenerate: usize,
    /// Kept: triangles with three different vertices, but no area to rounding. Dropping them would
    /// open a closed mesh; they add nothing to areas, volumes and distances.
    pub zero_area: usize,
    /// Dropped: triangles with the same vertices and the same orientation as an earlier one.
    pub duplicates: usize,
    /// Dropped: vertices that no triangle refers to.
    pub unreferenced: usize,
    /// Elements of the file that hold no surface.
    pub skipped: Skipped,
    /// What else the reader left out, or took otherwise than one may expect: a sentence each, for warnings.
    pub notes: Vec<String>,
}

/// Welds, triangulates and drops what is degenerate or double. See [`CleanReport`].
///
/// # Errors
/// [`MeshError`] if positions or indices of `raw` are invalid, a setting is out of range, or no
/// triangle is left.
pub fn clean(raw: RawMesh, settings: &CleanSettings) -> Result<(TriangleMesh, CleanReport), MeshError> {
    let tolerance = settings.weld_tolerance;
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        return Err(MeshError::Setting(format!("the weld tolerance must be 0 or positive, not {tolerance}")));
    }
    raw.check()?;
    raw.check_not_empty()?;
    let mut report = CleanReport {
        objects: raw.objects,
        unit: raw.unit,
        skipped: raw.skipped,
        notes: raw.notes.clone(),
        ..CleanReport::default()
    };
    let target = weld::weld(&raw.positions, tolerance);
    report.welded = target.iter().enumerate().filter(|&(k, &to)| to as usize != k).count();
    let triangles = triangulate_all(&raw, &target, &mut report);
    if triangles.is_empty() {
        return Err(MeshError::AllDegenerate { faces: raw.faces.len(), weld_tolerance: tolerance });
    }
    if triangles.len() > MAX_TRIANGLES {
        let problem = format!("{} triangles: at most {MAX_TRIANGLES} fit; split the mesh", triangles.len());
        return Err(MeshError::TooLarge { problem });
    }
    drop((target, raw.faces));
    let vertices = raw.positions.len();
    let mut mesh = compact(raw.positions, triangles);
    report.unreferenced = vertices - report.welded - mesh.vertices.len();
    report.duplicates = duplicates::drop_duplicates(&mut mesh);
    let area_free = |t: &&[u32; 3]| has_no_area(t.map(|v| mesh.vertices[v as usize].into()));
    report.zero_area = mesh.triangles.iter().filter(area_free).count();
    Ok((mesh, report))
}

fn triangulate_all(raw: &RawMesh, target: &[u32], report: &mut CleanReport) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(raw.faces.len());
    let mut triangulator = Triangulator::new();
    let mut corners: Vec<u32> = Vec::new();
    for face in raw.faces.iter() {
        match face.len() {
            3 => report.triangles += 1,
            4 => report.quads += 1,
            _ => report.polygons += 1,
        }
        corners.clear();
        corners.extend(face.iter().map(|&corner| target[corner as usize]));
        if let [a, b, c] = corners[..] {
            match a != b && b != c && c != a {
                true => triangles.push([a, b, c]),
                false => report.degenerate += 1,
            }
            continue;
        }
        corners.dedup();
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        let before = triangles.len();
        let outcome = triangulator.add(&raw.positions, &corners, &mut triangles);
        report.fan_fallbacks += usize::from(outcome == Outcome::Fan);
        report.degenerate += usize::from(triangles.len() == before);
    }
    triangles
}

/// Only the vertices that are used, in their order, and -0 as 0.
fn compact(mut positions: Vec<[f64; 3]>, mut triangles: Vec<[u32; 3]>) -> TriangleMesh {
    let mut new = vec![u32::MAX; positions.len()];
    for &corner in triangles.iter().flatten() {
        new[corner as usize] = 0;
    }
    let mut count = 0;
    for (k, new) in new.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
        *new = count as u32;
        positions[count] = positions[k].map(|c| c + 0.0);
        count += 1;
    }
    positions.truncate(count);
    positions.shrink_to_fit();
    for corner in triangles.iter_mut().flatten() {
        *corner = new[*corner as usize];
    }
    TriangleMesh { vertices: positions, triangles }
}

/// Without a thought for NaN, unlike `f64::max`.
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Whether the height over the longest edge is below rounding of the coordinates.
fn has_no_area([a, b, c]: [DVec3; 3]) -> bool {
    let coordinates = [a, b, c].map(|p| p.to_array());
    let size = coordinates.as_flattened().iter().fold(0.0f64, |max, c| larger(max, c.abs()));
    if size == 0.0 {
        return true;
    }
    if surely_has_area([a, b, c], size) {
        return false;
    }
    // Scaled, so that tiny and huge meshes neither underflow nor overflow.
    let (u, v, w) = ((b - a) / size, (c - a) / size, (c - b) / size);
    let longest = u.length_squared().max(v.length_squared()).max(w.length_squared()).sqrt();
    u.cross(v).length() <= 4.0 * f64::EPSILON * longest
}

/// True only for triangles that [`has_no_area`] would deny: its test with a wider limit and without
/// roots and divisions, where nothing can underflow or overflow.
fn surely_has_area([a, b, c]: [DVec3; 3], size: f64) -> bool {
    const WIDER: f64 = 64.0 * f64::EPSILON;
    let (u, v, w) = (b - a, c - a, c - b);
    let longest_squared = larger(larger(u.length_squared(), v.length_squared()), w.length_squared());
    (1e-50..1e50).contains(&size)
        && u.cross(v).length_squared() > WIDER * WIDER * longest_squared * (size * size)
}
