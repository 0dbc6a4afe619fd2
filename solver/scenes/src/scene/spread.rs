//! Points spread over a surface or a box.

use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::DVec3;

/// Points on a body's surface, about so many.
const POINTS: f64 = 4000.0;
/// Triangles are cut into the square of this many at most.
const FINEST: f64 = 64.0;

/// The middles of equal parts of the triangles, no wider than a particle, or than what [`POINTS`] parts would be.
pub(super) fn spread(mesh: &TriangleMesh, rp: f64) -> Vec<DVec3> {
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| DVec3::from(mesh.vertices[corner as usize]));
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let total: f64 = mesh.triangles.iter().map(|triangle| area(corners(triangle))).sum();
    let widest = (2.0 * rp).max((2.0 * total / POINTS).sqrt());
    // Of finer meshes, not each triangle.
    let stride = (mesh.triangles.len() as f64 / (4.0 * POINTS)).ceil().max(1.0) as usize;
    let mut points = Vec::new();
    for triangle in mesh.triangles.iter().step_by(stride) {
        let [a, b, c] = corners(triangle);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let parts = (longest / widest).ceil().clamp(1.0, FINEST) as u32;
        let at = |n: u32| (f64::from(n) + 1.0 / 3.0) / f64::from(parts);
        let rows = (0..parts).flat_map(|i| (0..parts - i).map(move |j| (i, j)));
        points.extend(rows.map(|(i, j)| a + at(i) * (b - a) + at(j) * (c - a)));
    }
    points
}

/// The middles of equal parts of a face of a box, that across an axis at a place along it; `parts` are those along each
/// axis.
pub(super) fn face([low, high]: [DVec3; 2], axis: usize, at: f64, parts: [u32; 3]) -> Vec<DVec3> {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let along = |axis: usize, n: u32| {
        low[axis] + (high[axis] - low[axis]) * (f64::from(n) + 0.5) / f64::from(parts[axis])
    };
    let point = |(a, b): (u32, u32)| {
        let mut x = DVec3::splat(at);
        (x[u], x[v]) = (along(u, a), along(v, b));
        x
    };
    (0..parts[u]).flat_map(|a| (0..parts[v]).map(move |b| (a, b))).map(point).collect()
}
