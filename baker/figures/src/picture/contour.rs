//! Curves in a slice: iso-lines of values on pixels by marching squares (Lorensen and Cline 1987 in two
//! dimensions; saddles by the mean of the corners), and where a mesh meets the plane.

use super::lattice::PixelLattice;
use glam::DVec3;
use std::collections::HashMap;
use volmap_formats::mesh::TriangleMesh;

/// A curve along the picture's axes, metres. A closed one repeats its first point.
pub type Polyline = Vec<[f64; 2]>;

/// A piece of a curve between two crossings; a crossing is known by the edge that it lies on.
type Piece = [(u64, [f64; 2]); 2];

/// Where the values at the pixels' centres pass `level`. Values that aren't finite have no curve near them.
/// `values` is as long as the lattice; otherwise there is no curve.
pub fn contours(lattice: &PixelLattice, values: &[f64], level: f64) -> Vec<Polyline> {
    let [width, height] = lattice.size;
    let mut pieces = Vec::new();
    if values.len() == lattice.len() {
        for j in 0..height.saturating_sub(1) {
            for i in 0..width.saturating_sub(1) {
                cell_pieces(lattice, values, level, [i, j], &mut pieces);
            }
        }
    }
    join(&pieces)
}

/// The pieces between four neighbouring pixels.
fn cell_pieces(lattice: &PixelLattice, values: &[f64], level: f64, [i, j]: [usize; 2], out: &mut Vec<Piece>) {
    // Counter-clockwise from the lower left; edge e runs from corner e to corner e + 1.
    let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
    let heights = corners.map(|[i, j]| values[j * lattice.size[0] + i] - level);
    if heights.iter().any(|height| !height.is_finite()) {
        return;
    }
    let above = heights.map(|height| height >= 0.0);
    let crossing = |edge: usize| {
        // From the pixel that comes first, so that both cells at an edge see the same point.
        let (mut a, mut b) = (edge, (edge + 1) % 4);
        if corners[b] < corners[a] {
            (a, b) = (b, a);
        }
        let t = heights[a] / (heights[a] - heights[b]);
        let centre =
            |corner: [usize; 2], axis: usize| lattice.low[axis] + (corner[axis] as f64 + 0.5) * lattice.pixel;
        let at = [0, 1].map(|axis| centre(corners[a], axis) * (1.0 - t) + centre(corners[b], axis) * t);
        let first = (corners[a][1] * lattice.size[0] + corners[a][0]) as u64;
        (2 * first + (edge % 2) as u64, at)
    };
    let crossed: Vec<usize> = (0..4).filter(|&edge| above[edge] != above[(edge + 1) % 4]).collect();
    match crossed[..] {
        [a, b] => out.push([crossing(a), crossing(b)]),
        [_, _, _, _] => {
            let middle_above = heights.iter().sum::<f64>() >= 0.0;
            // The two corners that differ from the middle are cut off.
            for corner in (0..4).filter(|&corner| above[corner] != middle_above) {
                out.push([crossing((corner + 3) % 4), crossing(corner)]);
            }
        }
        _ => (),
    }
}

/// Where the mesh (metres) meets the lattice's plane, also outside of its pixels. A triangle that lies in the
/// plane counts as above it.
pub fn section(mesh: &TriangleMesh, lattice: &PixelLattice) -> Vec<Polyline> {
    let axis = lattice.plane.axis.index();
    let height = |vertex: u32| mesh.vertices[vertex as usize][axis] - lattice.plane.at;
    let crossing = |a: u32, b: u32| {
        let (a, b) = (a.min(b), a.max(b));
        let t = height(a) / (height(a) - height(b));
        let point = |vertex: u32| DVec3::from(mesh.vertices[vertex as usize]);
        (u64::from(a) << 32 | u64::from(b), lattice.project(point(a) * (1.0 - t) + point(b) * t))
    };
    let mut pieces = Vec::new();
    for triangle in &mesh.triangles {
        let above = triangle.map(|vertex| height(vertex) >= 0.0);
        let alone = match above {
            [a, b, c] if a == b && b == c => continue,
            [a, b, c] if b == c && a != b => 0,
            [a, _, c] if a == c => 1,
            _ => 2,
        };
        let [a, b, c] = [0, 1, 2].map(|turn| triangle[(alone + turn) % 3]);
        pieces.push([crossing(a, b), crossing(a, c)]);
    }
    join(&pieces)
}

/// Joins pieces that share a crossing into curves as long as possible; the order of the pieces decides alone.
fn join(pieces: &[Piece]) -> Vec<Polyline> {
    let mut at_edge: HashMap<u64, Vec<usize>> = HashMap::new();
    for (number, piece) in pieces.iter().enumerate() {
        piece.iter().for_each(|(edge, _)| at_edge.entry(*edge).or_default().push(number));
    }
    let mut used = vec![false; pieces.len()];
    let follow = |used: &mut [bool], mut edge: u64, curve: &mut Polyline| {
        while let Some(&next) = at_edge[&edge].iter().find(|&&number| !used[number]) {
            used[next] = true;
            let [a, b] = pieces[next];
            let (far, point) = if a.0 == edge { b } else { a };
            curve.push(point);
            edge = far;
        }
    };
    let mut curves = Vec::new();
    for number in 0..pieces.len() {
        if std::mem::replace(&mut used[number], true) {
            continue;
        }
        let [(back, first), (front, second)] = pieces[number];
        let mut curve = vec![first, second];
        follow(&mut used, front, &mut curve);
        curve.reverse();
        follow(&mut used, back, &mut curve);
        curves.push(curve);
    }
    curves
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::lattice::{Axis, Plane};

    fn lattice(pixels: usize) -> PixelLattice {
        let plane = Plane { axis: Axis::Z, at: 0.0 };
        PixelLattice::over(plane, DVec3::splat(-1.0), DVec3::splat(1.0), pixels)
    }

    fn values(lattice: &PixelLattice, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        lattice.points().into_iter().map(f).collect()
    }

    fn length(curve: &Polyline) -> f64 {
        curve.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum()
    }

    #[test]
    fn circle_is_one_closed_curve() {
        let lattice = lattice(100);
        let curves = contours(&lattice, &values(&lattice, |p| p.truncate().length() - 0.7), 0.0);
        assert_eq!(curves.len(), 1);
        let curve = &curves[0];
        assert_eq!(curve.first(), curve.last());
        assert!((length(curve) - 0.7 * std::f64::consts::TAU).abs() < 1e-3);
        assert!(curve.iter().all(|p| (p[0].hypot(p[1]) - 0.7).abs() < 1e-4));
    }

    #[test]
    fn saddles_and_gaps() {
        let lattice = lattice(40);
        let cross = contours(&lattice, &values(&lattice, |p| p.x * p.y - 0.01), 0.0);
        assert_eq!(cross.len(), 2, "the branches of a hyperbola don't meet");
        let gap =
            contours(&lattice, &values(&lattice, |p| if p.x.abs() < 0.2 { f64::NAN } else { p.y }), 0.0);
        assert_eq!(gap.len(), 2);
        let all = values(&lattice, |p| p.x);
        assert!(contours(&lattice, &all, 7.0).is_empty() && contours(&lattice, &all[1..], 0.0).is_empty());
        let single = PixelLattice { size: [1, 1], ..lattice };
        assert!(contours(&single, &[0.0], 0.0).is_empty());
    }

    #[test]
    fn section_of_a_tetrahedron() {
        let mesh = TriangleMesh {
            vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        };
        let at = |at: f64| PixelLattice { plane: Plane { axis: Axis::Z, at }, ..lattice(10) };
        let half = section(&mesh, &at(0.5));
        assert_eq!(half.len(), 1);
        assert_eq!((half[0].len(), half[0].first()), (4, half[0].last()));
        assert!((length(&half[0]) - (1.0 + 0.5f64.sqrt())).abs() < 1e-12);
        assert_eq!(section(&mesh, &at(1.0)).len(), 1, "a point, as a curve of no length");
        assert!(section(&mesh, &at(1.01)).is_empty() && section(&mesh, &at(-0.01)).is_empty());
        assert!(section(&mesh, &at(0.0)).is_empty(), "the floor counts as above");
    }
}
