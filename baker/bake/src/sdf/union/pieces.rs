//! A triangle cut into convex pieces along segments: binary space partition, each cut extended through the piece in
//! which it lies.

use glam::DVec3;

use super::cuts::{Cut, clip, inward_lines};

/// A piece, and the cuts that are left in it.
struct Work {
    polygon: Vec<DVec3>,
    segments: Vec<[DVec3; 2]>,
}

/// The convex pieces of a triangle with unit `normal`. No cut goes through the inside of one, but for `tolerance`.
pub fn pieces(corners: &[DVec3; 3], normal: DVec3, cuts: &[Cut], tolerance: f64) -> Vec<Vec<DVec3>> {
    let segments = cuts.iter().map(|cut| cut.segment).collect();
    let mut work = vec![Work { polygon: corners.to_vec(), segments }];
    let mut done = Vec::new();
    while let Some(mut piece) = work.pop() {
        if piece.segments.is_empty() {
            done.push(piece.polygon);
            continue;
        }
        // One from the middle: along a curve of cuts, halves are more even.
        let [from, to] = piece.segments.remove(piece.segments.len() / 2);
        let across = normal.cross(to - from).normalize_or_zero();
        match halves(&piece.polygon, from, across, tolerance) {
            Some(halves) => {
                work.extend(halves.map(|polygon| within(polygon, normal, &piece.segments, tolerance)))
            }
            None => work.push(piece),
        }
    }
    done
}

fn within(polygon: Vec<DVec3>, normal: DVec3, segments: &[[DVec3; 2]], tolerance: f64) -> Work {
    let lines = inward_lines(&polygon, normal, tolerance);
    let segments = segments.iter().filter_map(|segment| clip(*segment, &lines, tolerance)).collect();
    Work { polygon, segments }
}

/// Both sides of a line through `point`; None where it doesn't go through the inside.
fn halves(polygon: &[DVec3], point: DVec3, across: DVec3, tolerance: f64) -> Option<[Vec<DVec3>; 2]> {
    let sides: Vec<f64> = polygon.iter().map(|corner| across.dot(*corner - point)).collect();
    let is_far = |sign: f64| sides.iter().any(|side| sign * side > tolerance);
    if !(is_far(1.0) && is_far(-1.0)) {
        return None;
    }
    let half = |sign: f64| {
        let mut out = Vec::with_capacity(polygon.len() + 1);
        for (i, corner) in polygon.iter().enumerate() {
            let j = (i + 1) % polygon.len();
            let (here, there) = (sign * sides[i], sign * sides[j]);
            if here >= -tolerance {
                out.push(*corner);
            }
            if here.min(there) < -tolerance && here.max(there) > tolerance {
                // The same bits from both sides of the line.
                let t = sides[i] / (sides[i] - sides[j]);
                out.push(corner.lerp(polygon[j], t));
            }
        }
        out
    };
    Some([half(1.0), half(-1.0)])
}
