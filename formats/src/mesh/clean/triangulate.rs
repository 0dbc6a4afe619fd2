//! Polygons to triangles.
//!
//! The polygon's plane is that of its vector area (Newell's method: Sutherland, Sproull and
//! Schumacker 1974). Convex polygons become the fan whose smallest triangle is largest; others are
//! clipped ear by ear (Meisters 1975).

use glam::DVec3;

/// Tests of a point in an ear, for a whole mesh: about a second. Real meshes need a tiny part.
const MAX_TESTS: u64 = 500_000_000;
/// Beyond this many corners the fan of a convex polygon starts anywhere.
const MAX_FAN_CHOICES: usize = 64;

/// How a polygon was split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As it should be.
    Clean,
    /// Ear clipping failed: a fan.
    Fan,
}

/// Splits polygons; holds what is reused between them.
pub struct Triangulator {
    flat: Vec<[f64; 2]>,
    tests_left: u64,
}

/// Twice the area of a triangle, positive if counter-clockwise.
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn length(v: DVec3) -> f64 {
    v.x.hypot(v.y).hypot(v.z)
}

impl Triangulator {
    pub fn new() -> Triangulator {
        Triangulator { flat: Vec::new(), tests_left: MAX_TESTS }
    }

    /// Appends the polygon's triangles; those with repeated corners are left out.
    pub fn add(&mut self, positions: &[[f64; 3]], corners: &[u32], triangles: &mut Vec<[u32; 3]>) -> Outcome {
        let mut push = |[a, b, c]: [usize; 3]| {
            let t = [corners[a], corners[b], corners[c]];
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                triangles.push(t);
            }
        };
        let count = corners.len();
        if count <= 3 {
            if count == 3 {
                push([0, 1, 2]);
            }
            return Outcome::Clean;
        }
        let fan = |start: usize| (1..count - 1).map(move |k| [start, start + k, start + k + 1]);
        let wrap = |t: [usize; 3]| t.map(|k| k % count);
        if self.flatten(positions, corners) {
            if let Some(start) = self.best_fan() {
                fan(start).for_each(|t| push(wrap(t)));
                return Outcome::Clean;
            }
            if let Some(ears) = self.clip() {
                ears.into_iter().for_each(&mut push);
                return Outcome::Clean;
            }
        }
        fan(0).for_each(|t| push(wrap(t)));
        Outcome::Fan
    }

    /// Projects the corners onto the plane of the vector area, scaled to size 1. False: no area.
    fn flatten(&mut self, positions: &[[f64; 3]], corners: &[u32]) -> bool {
        let at = |k: usize| DVec3::from(positions[corners[k % corners.len()] as usize]);
        let far = |m: f64, k: usize| (at(k) - at(0)).to_array().iter().fold(m, |m, c| m.max(c.abs()));
        let size = (0..corners.len()).fold(0.0, far);
        if size == 0.0 || !size.is_finite() {
            return false;
        }
        let local = |k: usize| (at(k) - at(0)) / size;
        let normal = (0..corners.len()).fold(DVec3::ZERO, |sum, k| sum + local(k).cross(local(k + 1)));
        if length(normal) <= 1e-14 {
            return false;
        }
        let n = normal / length(normal);
        // The axis that is least along the normal.
        let least = (0..3).fold(0, |k, i| if n[i].abs() < n[k].abs() { i } else { k });
        let u = n.cross(DVec3::AXES[least]);
        let u = u / length(u);
        let v = n.cross(u);
        self.flat.clear();
        self.flat.extend((0..corners.len()).map(|k| [local(k).dot(u), local(k).dot(v)]));
        true
    }

    /// Where the fan with the largest smallest triangle starts, if all of one's triangles are
    /// positive and turn around the polygon once: then it is star-shaped from that corner.
    fn best_fan(&self) -> Option<usize> {
        let count = self.flat.len();
        let at = |k: usize| self.flat[k % count];
        let convex = (0..count).all(|k| area(at(k), at(k + 1), at(k + 2)) >= -1e-14);
        if !convex || count > MAX_FAN_CHOICES && self.turns() > 1 {
            return None;
        }
        let choices = if count > MAX_FAN_CHOICES { 1 } else { count };
        let smallest = |start: usize| {
            let areas = (1..count - 1).map(|k| area(at(start), at(start + k), at(start + k + 1)));
            areas.fold(f64::INFINITY, f64::min)
        };
        let mut best = (1e-14, None);
        for start in 0..choices {
            let value = smallest(start);
            // Equal but for rounding: the earlier one.
            if value > best.0 * (1.0 + 1e-9) {
                best = (value, Some(start));
            }
        }
        best.1.filter(|_| self.turns() == 1)
    }

    /// How often the outline of a polygon without right turns goes round.
    fn turns(&self) -> usize {
        let count = self.flat.len();
        let direction = |k: usize| {
            let (p, q) = (self.flat[k % count], self.flat[(k + 1) % count]);
            (q[1] - p[1]).atan2(q[0] - p[0])
        };
        let full = 2.0 * std::f64::consts::PI;
        let turn = |k: usize| {
            let angle = (direction(k + 1) - direction(k)).rem_euclid(full);
            // A tiny right turn.
            if angle > full - 1e-6 { angle - full } else { angle }
        };
        ((0..count).map(turn).sum::<f64>() / full).round() as usize
    }

    /// Ear clipping. `None`: there is no ear left, or no time.
    fn clip(&mut self) -> Option<Vec<[usize; 3]>> {
        let mut left: Vec<usize> = (0..self.flat.len()).collect();
        let mut ears = Vec::with_capacity(left.len());
        let mut from = 0;
        while left.len() > 3 {
            let count = left.len();
            let corner = |k: usize| {
                let k = k % count;
                [left[(k + count - 1) % count], left[k], left[(k + 1) % count]]
            };
            // Starting after the last ear gives rounder triangles than a fan. Flat corners last.
            let mut found = None;
            for flat in [false, true] {
                found = (from..from + count).find(|&k| self.is_ear(corner(k), &left, flat));
                if found.is_some() {
                    break;
                }
            }
            let at = found? % count;
            ears.push(corner(at));
            left.remove(at);
            from = at;
        }
        let last = [left[0], left[1], left[2]];
        let [a, b, c] = last.map(|k| self.flat[k]);
        ears.push(last);
        (area(a, b, c) >= -1e-12).then_some(ears)
    }

    /// Whether the triangle is convex and has no other corner in it or on its rim.
    fn is_ear(&mut self, [a, b, c]: [usize; 3], left: &[usize], flat: bool) -> bool {
        let [pa, pb, pc] = [a, b, c].map(|k| self.flat[k]);
        let size = area(pa, pb, pc);
        if size <= if flat { -1e-14 } else { 1e-14 } {
            return false;
        }
        if self.tests_left < left.len() as u64 {
            return false;
        }
        self.tests_left -= left.len() as u64;
        // Bridges to holes repeat corners: those don't block.
        let same = |p: [f64; 2]| p == pa || p == pb || p == pc;
        let inside = |p: [f64; 2]| {
            if flat {
                // A flat ear is blocked by corners between its ends only.
                return area(pa, pb, p) > 1e-14 && area(pb, pc, p) > 1e-14 && area(pc, pa, p) > 1e-14;
            }
            area(pa, pb, p) >= 0.0 && area(pb, pc, p) >= 0.0 && area(pc, pa, p) >= 0.0
        };
        !left.iter().map(|&k| self.flat[k]).any(|p| !same(p) && inside(p))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(points: &[[f64; 2]]) -> (Outcome, Vec<[u32; 3]>, f64) {
        // Tilted, so that the projection matters.
        let positions: Vec<_> = points.iter().map(|p| [p[0], p[1], 0.5 * p[0] + 3.0]).collect();
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let mut triangles = Vec::new();
        let outcome = Triangulator::new().add(&positions, &corners, &mut triangles);
        let at = |k: u32| points[k as usize];
        let areas = triangles.iter().map(|t| area(at(t[0]), at(t[1]), at(t[2])));
        // A simple polygon's triangles are all positive; the sum of sizes is then the area.
        (outcome, triangles.clone(), areas.map(f64::abs).sum::<f64>() / 2.0)
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]];
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 1.0],
            [3.0, 3.0],
            [2.0, 1.0],
            [1.0, 3.0],
            [0.5, 1.0],
            [0.0, 3.0],
        ];
        let ell = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        for (points, exact) in [(&arrow[..], 1.0), (&ell[..], 3.0), (&comb[..], 10.0)] {
            for shift in 0..points.len() {
                let mut turned = points.to_vec();
                turned.rotate_left(shift);
                let (outcome, triangles, sum) = split(&turned);
                assert_eq!(outcome, Outcome::Clean);
                assert_eq!(triangles.len(), points.len() - 2);
                assert!((sum - exact).abs() < 1e-12, "{sum} {exact}");
            }
        }
    }

    #[test]
    fn collinear_corners_give_no_flat_triangles() {
        let points = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 2.0], [0.0, 1.0]];
        let (outcome, triangles, sum) = split(&points);
        assert_eq!((outcome, triangles.len()), (Outcome::Clean, 4));
        assert!((sum - 2.0).abs() < 1e-12);
        for t in triangles {
            let [a, b, c] = t.map(|k| points[k as usize]);
            assert!(area(a, b, c) > 0.1);
        }
    }

    #[test]
    fn a_keyhole_is_split_and_a_bow_tie_falls_back() {
        // A square with a square hole, joined by a bridge.
        let points = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let (outcome, _, sum) = split(&points);
        assert_eq!(outcome, Outcome::Clean);
        assert!((sum - 12.0).abs() < 1e-12, "{sum}");
        let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]];
        assert_eq!(split(&bow).1.len(), 2);
    }

    #[test]
    fn a_star_goes_round_twice_and_is_no_fan() {
        let star: Vec<[f64; 2]> =
            (0..5).map(|k| (f64::from(k) * 144.0).to_radians().sin_cos()).map(|(s, c)| [c, s]).collect();
        assert_eq!(split(&star).1.len(), 3);
    }

    #[test]
    fn a_huge_comb_ends_in_time() {
        let teeth = 20_000;
        let mut points = vec![[f64::from(teeth), -1.0], [f64::from(teeth), 0.0]];
        points.extend((0..teeth).rev().map(|k| [f64::from(k), f64::from(k % 2)]));
        points.push([0.0, -1.0]);
        let start = std::time::Instant::now();
        split(&points);
        assert!(start.elapsed().as_secs() < 20);
    }
}
