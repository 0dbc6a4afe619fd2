//! Triangles of a level set in a cube that is split into six tetrahedra around its diagonal (Kuhn 1960), so that cubes
//! side by side fit: no ambiguous cases, hence closed surfaces. Payne and Toga 1990, *Surface Mapping Brain Function on
//! 3D Models*.
//!
//! A corner of the cube is a mask, bit a for the upper side of axis a. The edges of the tetrahedra go from a mask to
//! one that has its bits and more.

/// An edge from a corner of the cube to a higher one.
pub type Edge = [u8; 2];

/// The axes in the order in which a path along the cube's edges takes them from corner 0 to corner 7, and whether the
/// tetrahedron of its four corners is right-handed.
const PATHS: [([u8; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([0, 2, 1], false),
    ([2, 1, 0], false),
    ([1, 0, 2], false),
];

/// Calls `triangle` with the three edges whose crossings make a triangle, for all triangles of the cube. `inside` has a
/// bit for each of the 8 corners. Normals point outside.
pub fn triangles(inside: u8, triangle: &mut impl FnMut([Edge; 3])) {
    for ([a, b, _], right_handed) in PATHS {
        let mut corners = [0, 1 << a, 1 << a | 1 << b, 7];
        if !right_handed {
            corners.swap(0, 1);
        }
        tetrahedron(corners, inside, triangle);
    }
}

/// `corners` are right-handed.
fn tetrahedron(corners: [u8; 4], inside: u8, triangle: &mut impl FnMut([Edge; 3])) {
    let is_inside = |n: usize| inside >> corners[n] & 1 == 1;
    let (within, without): (Vec<usize>, Vec<usize>) = (0..4).partition(|&n| is_inside(n));
    let mut order: Vec<usize> =
        if within.len() == 3 { [without, within].concat() } else { [within, without].concat() };
    let inversions =
        (0..4).flat_map(|n| (0..n).map(move |m| (m, n))).filter(|&(m, n)| order[m] > order[n]).count();
    if inversions % 2 == 1 {
        order.swap(2, 3);
    }
    let edge = |m: usize, n: usize| {
        let (a, b) = (corners[order[m]], corners[order[n]]);
        [a.min(b), a.max(b)]
    };
    match (0..4).filter(|&n| is_inside(n)).count() {
        1 => triangle([edge(0, 1), edge(0, 2), edge(0, 3)]),
        3 => triangle([edge(0, 1), edge(0, 3), edge(0, 2)]),
        2 => {
            triangle([edge(0, 2), edge(0, 3), edge(1, 3)]);
            triangle([edge(0, 2), edge(1, 3), edge(1, 2)]);
        }
        _ => (),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::collections::HashMap;

    fn corner(mask: u8) -> DVec3 {
        DVec3::new((mask & 1).into(), (mask >> 1 & 1).into(), (mask >> 2 & 1).into())
    }

    #[test]
    fn triangles_face_outside_and_close_within_the_cube() {
        for inside in 0..=255u8 {
            let mut borders: HashMap<[Edge; 2], i32> = HashMap::new();
            triangles(inside, &mut |edges: [Edge; 3]| {
                let [a, b, c] = edges.map(|[a, b]| 0.5 * (corner(a) + corner(b)));
                let normal = (b - a).cross(c - a);
                for [low, high] in edges {
                    assert_eq!(low & high, low, "a path goes up");
                    let is_inside = |mask: u8| inside >> mask & 1 == 1;
                    assert_ne!(is_inside(low), is_inside(high));
                    let outward = corner(high) - corner(low);
                    assert!(
                        normal.dot(if is_inside(low) { outward } else { -outward }) > 0.0,
                        "{inside:08b}"
                    );
                }
                for n in 0..3 {
                    let (from, to) = (edges[n], edges[(n + 1) % 3]);
                    let sign = if from < to { 1 } else { -1 };
                    *borders.entry([from.min(to), from.max(to)]).or_default() += sign;
                }
            });
            // What is left open lies on a face of the cube.
            for ([[a, b], [c, d]], _) in borders.iter().filter(|(_, sum)| **sum != 0) {
                let on_face = (a & b & c & d) | !(a | b | c | d) & 7;
                assert_ne!(on_face, 0, "{inside:08b}");
            }
        }
    }
}
