//! Where two triangles meet: along a segment where they cross (Möller 1997, "A Fast Triangle-Triangle Intersection
//! Test"), along an edge that lies in the other's plane, or along all edges where they cover each other in one plane.

use glam::DVec3;

/// A triangle of the mesh.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Its corners.
    pub corners: [DVec3; 3],
    /// Its number in the mesh.
    pub number: u32,
}

/// A segment along which a triangle is cut.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// The triangle that is cut.
    pub triangle: u32,
    /// Ends of the segment, on the triangle to rounding.
    pub segment: [DVec3; 2],
}

/// What meetings do to triangles.
#[derive(Clone, Debug, Default)]
pub struct Meetings {
    /// Where triangles are cut.
    pub cuts: Vec<Cut>,
    /// Triangles that lie, in part at least, on another of a lower number that faces the same way: that one counts.
    pub covered: Vec<(u32, u32)>,
}

/// A triangle with its plane, and how far the other's corners are from it: 0 to rounding.
struct Side<'a> {
    triangle: &'a Triangle,
    normal: DVec3,
    /// Distances of this triangle's corners from the other's plane.
    distances: [f64; 3],
}

/// A point where two triangles cross or cover each other, if they do, and what that does to them.
pub fn contact(a: &Triangle, b: &Triangle, tolerance: f64, found: &mut Meetings) -> Option<DVec3> {
    if are_neighbours(a, b, tolerance) {
        return None;
    }
    let [normal_a, normal_b] = [a, b].map(|t| unit_normal(&t.corners));
    if normal_a == DVec3::ZERO || normal_b == DVec3::ZERO {
        return None;
    }
    let a = Side { triangle: a, normal: normal_a, distances: distances(a, b, normal_b, tolerance) };
    let b = Side { triangle: b, normal: normal_b, distances: distances(b, a.triangle, normal_a, tolerance) };
    if a.is_flat() || b.is_flat() {
        return covering(&a, &b, tolerance, found);
    }
    let crossing = if a.crosses() && b.crosses() { crossing(&a, &b, tolerance, found) } else { None };
    // An edge in the other's plane cuts the other.
    let along_a = edge_in_plane(&a, &b, tolerance, found);
    let along_b = edge_in_plane(&b, &a, tolerance, found);
    crossing.or(along_a).or(along_b)
}

/// Whether they share an edge without lying on each other.
fn are_neighbours(a: &Triangle, b: &Triangle, tolerance: f64) -> bool {
    let mut apart = b.corners.iter().filter(|corner| !a.corners.contains(corner));
    let (Some(corner), None) = (apart.next(), apart.next()) else { return false };
    let [p, q, r] = a.corners;
    let normal = (q - p).cross(r - p);
    let distance = normal.dot(*corner - p).abs();
    distance * distance > tolerance * tolerance * normal.length_squared()
}

impl Side<'_> {
    fn is_flat(&self) -> bool {
        self.distances == [0.0; 3]
    }

    fn crosses(&self) -> bool {
        self.distances.iter().any(|&d| d < 0.0) && self.distances.iter().any(|&d| d > 0.0)
    }

    /// The two points where its sides meet the other's plane.
    fn points_on_plane(&self) -> [DVec3; 2] {
        let (corners, distances) = (&self.triangle.corners, &self.distances);
        let mut points = [DVec3::ZERO; 2];
        let mut count = 0;
        for i in 0..3 {
            let j = (i + 1) % 3;
            let point = if distances[i] == 0.0 {
                corners[i]
            } else if distances[i] * distances[j] < 0.0 {
                corners[i].lerp(corners[j], distances[i] / (distances[i] - distances[j]))
            } else {
                continue;
            };
            points[count.min(1)] = point;
            count += 1;
        }
        points
    }
}

fn unit_normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*b - *a).cross(*c - *a).normalize_or_zero()
}

/// Distances of the corners of `of` from the plane of `other`; shared corners are on it.
fn distances(of: &Triangle, other: &Triangle, normal: DVec3, tolerance: f64) -> [f64; 3] {
    of.corners.map(|corner| {
        if other.corners.contains(&corner) {
            return 0.0;
        }
        let distance = normal.dot(corner - other.corners[0]);
        if distance.abs() <= tolerance { 0.0 } else { distance }
    })
}

/// The segment that both have in common on the line of their planes.
fn crossing(a: &Side, b: &Side, tolerance: f64, found: &mut Meetings) -> Option<DVec3> {
    let direction = a.normal.cross(b.normal).normalize_or_zero();
    let origin = a.triangle.corners[0];
    let range = |side: &Side| {
        let mut ends = side.points_on_plane().map(|point| ((point - origin).dot(direction), point));
        if ends[0].0 > ends[1].0 {
            ends.swap(0, 1);
        }
        ends
    };
    let ([a_low, a_high], [b_low, b_high]) = (range(a), range(b));
    let low = if a_low.0 > b_low.0 { a_low } else { b_low };
    let high = if a_high.0 < b_high.0 { a_high } else { b_high };
    if high.0 - low.0 <= tolerance {
        return None;
    }
    let segment = [low.1, high.1];
    found.cuts.extend([a, b].map(|side| Cut { triangle: side.triangle.number, segment }));
    Some(0.5 * (low.1 + high.1))
}

/// Cuts `other` along an edge of `of` that lies in its plane, and inside of it.
fn edge_in_plane(of: &Side, other: &Side, tolerance: f64, found: &mut Meetings) -> Option<DVec3> {
    let edge = (0..3).find(|&i| of.distances[i] == 0.0 && of.distances[(i + 1) % 3] == 0.0)?;
    let ends = [of.triangle.corners[edge], of.triangle.corners[(edge + 1) % 3]];
    if ends.iter().all(|end| other.triangle.corners.contains(end)) {
        return None;
    }
    cut_by(ends, other, tolerance, found)
}

/// Two triangles in one plane.
fn covering(a: &Side, b: &Side, tolerance: f64, found: &mut Meetings) -> Option<DVec3> {
    if !(a.is_flat() && b.is_flat()) || is_apart(a, b, tolerance) || is_apart(b, a, tolerance) {
        return None;
    }
    for (of, other) in [(a, b), (b, a)] {
        for i in 0..3 {
            let corners = &of.triangle.corners;
            cut_by([corners[i], corners[(i + 1) % 3]], other, tolerance, found);
        }
    }
    if a.normal.dot(b.normal) > 0.0 {
        let [one, other] = [a.triangle.number, b.triangle.number];
        found.covered.push((one.max(other), one.min(other)));
    }
    Some(a.triangle.corners.iter().chain(&b.triangle.corners).sum::<DVec3>() / 6.0)
}

/// Whether an edge of `of` parts the two.
fn is_apart(of: &Side, other: &Side, tolerance: f64) -> bool {
    inward_lines(&of.triangle.corners, of.normal, tolerance)
        .iter()
        .any(|(point, inward)| other.triangle.corners.iter().all(|v| inward.dot(*v - *point) <= tolerance))
}

fn cut_by(ends: [DVec3; 2], other: &Side, tolerance: f64, found: &mut Meetings) -> Option<DVec3> {
    let lines = inward_lines(&other.triangle.corners, other.normal, tolerance);
    let segment = clip(ends, &lines, tolerance)?;
    found.cuts.push(Cut { triangle: other.triangle.number, segment });
    Some(0.5 * (segment[0] + segment[1]))
}

/// A point of each side of a convex polygon, and the direction inwards. Sides as short as rounding have none.
pub fn inward_lines(corners: &[DVec3], normal: DVec3, tolerance: f64) -> Vec<(DVec3, DVec3)> {
    let next = corners.iter().cycle().skip(1);
    let sides = corners.iter().zip(next).filter(|(p, q)| p.distance(**q) > tolerance);
    sides.map(|(p, q)| (*p, normal.cross(*q - *p).normalize_or_zero())).collect()
}

/// The part of a segment inside a convex polygon; None where that is a point, or lies along a side.
pub fn clip([from, to]: [DVec3; 2], lines: &[(DVec3, DVec3)], tolerance: f64) -> Option<[DVec3; 2]> {
    let (mut start, mut end) = (0.0f64, 1.0f64);
    for (point, inward) in lines {
        let (first, last) = (inward.dot(from - *point), inward.dot(to - *point));
        if first < 0.0 && last < 0.0 {
            return None;
        }
        if first < 0.0 {
            start = start.max(first / (first - last));
        } else if last < 0.0 {
            end = end.min(first / (first - last));
        }
    }
    let segment = [from.lerp(to, start), from.lerp(to, end)];
    let middle = 0.5 * (segment[0] + segment[1]);
    let is_inside = lines.iter().all(|(point, inward)| inward.dot(middle - *point) > tolerance);
    (start < end && segment[0].distance(segment[1]) > tolerance && is_inside).then_some(segment)
}
