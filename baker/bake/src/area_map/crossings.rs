//! Lines of an outline that cross or lie on each other: what they enclose twice is outside by the even-odd rule, which
//! is seldom meant.

use glam::DVec2;
use std::collections::HashSet;

/// A point of a segment that is there twice.
pub fn doubled(segments: &[[DVec2; 2]]) -> Option<DVec2> {
    let sorted = |[a, b]: &[DVec2; 2]| {
        let key = |p: &DVec2| [p.x, p.y].map(|x| (x + 0.0).to_bits());
        let (a, b) = (key(a), key(b));
        if a < b { [a, b] } else { [b, a] }
    };
    let mut seen = HashSet::new();
    segments.iter().find(|ends| !seen.insert(sorted(ends))).map(|[a, b]| 0.5 * (*a + *b))
}

/// How many pairs of segments cross or lie on each other, and where the first do. Each pair is looked at whose ranges
/// along x overlap.
pub fn crossings(segments: &[[DVec2; 2]]) -> Option<(usize, DVec2)> {
    let mut order: Vec<&[DVec2; 2]> = segments.iter().collect();
    order.sort_by(|a, b| a[0].x.min(a[1].x).total_cmp(&b[0].x.min(b[1].x)));
    let mut found: Option<(usize, DVec2)> = None;
    for (i, first) in order.iter().enumerate() {
        let end = first[0].x.max(first[1].x);
        let near = order[i + 1..].iter().take_while(|second| second[0].x.min(second[1].x) <= end);
        for at in near.filter_map(|second| crossing(first, second)) {
            found = Some(found.map_or((1, at), |(count, at)| (count + 1, at)));
        }
    }
    found
}

/// Where two segments cross, or lie on each other for a length.
fn crossing([a, b]: &[DVec2; 2], [c, d]: &[DVec2; 2]) -> Option<DVec2> {
    let (along, other) = (*b - *a, *d - *c);
    let size = along.length().max(other.length());
    let rounding = 1e-12 * size * size;
    let [to_c, to_d] = [*c, *d].map(|p| along.perp_dot(p - *a));
    if to_c.abs() <= rounding && to_d.abs() <= rounding {
        let mut ends = [*c, *d].map(|p| (p - *a).dot(along) / along.length_squared());
        ends.sort_by(f64::total_cmp);
        let (start, end) = (ends[0].max(0.0), ends[1].min(1.0));
        return (end - start > 1e-9).then(|| *a + 0.5 * (start + end) * along);
    }
    let [to_a, to_b] = [*a, *b].map(|p| other.perp_dot(p - *c));
    let opposite = |x: f64, y: f64| x.abs() > rounding && y.abs() > rounding && (x < 0.0) != (y < 0.0);
    (opposite(to_c, to_d) && opposite(to_a, to_b)).then(|| *a + along * (to_a / (to_a - to_b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(rings: &[&[[f64; 2]]]) -> Vec<[DVec2; 2]> {
        let sides = |ring: &&[[f64; 2]]| {
            let points: Vec<DVec2> = ring.iter().map(|&point| point.into()).collect();
            (0..points.len()).map(|i| [points[i], points[(i + 1) % points.len()]]).collect::<Vec<_>>()
        };
        rings.iter().flat_map(sides).collect()
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn crossing_and_doubled_lines_are_found() {
        let moved = SQUARE.map(|[x, y]| [x + 0.5, y + 0.25]);
        let (count, at) = crossings(&outline(&[&SQUARE, &moved])).unwrap();
        assert_eq!(count, 2);
        assert!(at == DVec2::new(0.5, 1.0) || at == DVec2::new(1.0, 0.25), "{at}");
        // Beside each other: they share a side.
        let beside = SQUARE.map(|[x, y]| [x + 1.0, y]);
        assert_eq!(crossings(&outline(&[&SQUARE, &beside])).map(|found| found.0), Some(1));
        assert!(doubled(&outline(&[&SQUARE, &SQUARE])).is_some());
    }

    #[test]
    fn lines_that_only_meet_or_nest_do_not_cross() {
        let inner = SQUARE.map(|[x, y]| [0.25 + 0.5 * x, 0.25 + 0.5 * y]);
        let corner = SQUARE.map(|[x, y]| [x + 1.0, y + 1.0]);
        for rings in [vec![&SQUARE[..]], vec![&SQUARE[..], &inner[..]], vec![&SQUARE[..], &corner[..]]] {
            let found = outline(&rings);
            assert_eq!(crossings(&found), None);
            assert_eq!(doubled(&found), None);
        }
    }
}
