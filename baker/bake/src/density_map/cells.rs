//! Sets of cells and the values at their nodes, put together and taken apart.

use volmap_formats::asset::CellRun;
use volmap_runtime::layout::{Family, Nodes};

/// The cells of `runs` that are not in `others`; both sorted by (k, j, i) and without overlap.
pub fn without(runs: &[CellRun], others: &[CellRun]) -> Vec<CellRun> {
    let mut out = Vec::new();
    let mut others = others.iter().peekable();
    for run in runs {
        let row = (run.k, run.j);
        while others
            .next_if(|other| (other.k, other.j, other.i + other.len) <= (row.0, row.1, run.i))
            .is_some()
        {}
        let (mut first, end) = (run.i, run.i + run.len);
        while let Some(other) = others.peek().filter(|other| (other.k, other.j) == row && other.i < end) {
            if other.i > first {
                out.push(CellRun { i: first, len: other.i - first, ..*run });
            }
            first = other.i + other.len;
            if first >= end {
                break;
            }
            others.next();
        }
        if first < end {
            out.push(CellRun { i: first, len: end - first, ..*run });
        }
    }
    out
}

/// Copies the values of the nodes that both sets of cells of one grid have.
pub fn copy(from: &Nodes, values: &[f64], to: &Nodes, out: &mut [f64]) {
    for family in Family::ALL {
        let per_point = family.nodes_per_point();
        let mut targets = to.intervals(family).peekable();
        for (j, k, own) in from.intervals(family) {
            while let Some(&(y, z, target)) = targets.peek() {
                if (z, y) < (k, j) || (z, y) == (k, j) && target.end <= own.first {
                    targets.next();
                    continue;
                }
                if (z, y) > (k, j) || target.first >= own.end {
                    break;
                }
                let (first, end) = (target.first.max(own.first), target.end.min(own.end));
                let source = (own.start + (first - own.first) * per_point) as usize;
                let place = (target.start + (first - target.first) * per_point) as usize;
                let length = ((end - first) * per_point) as usize;
                out[place..][..length].copy_from_slice(&values[source..][..length]);
                if target.end > own.end {
                    break;
                }
                targets.next();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec3;
    use proptest::prelude::*;

    const RESOLUTION: [u32; 3] = [9, 3, 2];

    /// Runs of the cells that are marked; neighbours joined or not.
    fn runs(marks: &[bool], joined: bool) -> Vec<CellRun> {
        let mut out: Vec<CellRun> = Vec::new();
        for (cell, _) in marks.iter().enumerate().filter(|(_, mark)| **mark) {
            let cell = cell as u32;
            let (i, j, k) = (cell % 9, cell / 9 % 3, cell / 27);
            match out.last_mut().filter(|run| joined && (run.k, run.j, run.i + run.len) == (k, j, i)) {
                Some(run) => run.len += 1,
                None => out.push(CellRun { i, j, k, len: 1 }),
            }
        }
        out
    }

    fn marks(runs: &[CellRun]) -> Vec<bool> {
        let mut out = vec![false; 54];
        for run in runs {
            (run.i..run.i + run.len).for_each(|i| out[(i + 9 * (run.j + 3 * run.k)) as usize] = true);
        }
        out
    }

    /// A number for each node that tells its place.
    fn places(nodes: &Nodes) -> Vec<f64> {
        let mut out = Vec::new();
        for family in Family::ALL {
            for (j, k, it) in nodes.intervals(family) {
                for i in it.first..it.end {
                    let place = f64::from(i + 10 * (j + 10 * (k + 10 * family as u32)));
                    out.extend((0..family.nodes_per_point()).map(|t| place + 0.25 * f64::from(t)));
                }
            }
        }
        out
    }

    proptest! {
        #[test]
        fn sets_come_apart_and_together(
            a in prop::collection::vec(any::<bool>(), 54),
            b in prop::collection::vec(any::<bool>(), 54),
            joined in any::<[bool; 2]>(),
        ) {
            let (first, second) = (runs(&a, joined[0]), runs(&b, joined[1]));
            let rest = without(&first, &second);
            let expected: Vec<bool> = a.iter().zip(&b).map(|(a, b)| *a && !b).collect();
            prop_assert_eq!(marks(&rest), expected);
            let nodes = |runs: &[CellRun]| Nodes::new(UVec3::from(RESOLUTION), runs).unwrap();
            let (all, new, known) = (nodes(&first), nodes(&rest), nodes(&second));
            let mut out = vec![-1.0; all.count()];
            copy(&new, &places(&new), &all, &mut out);
            copy(&known, &places(&known), &all, &mut out);
            prop_assert_eq!(out, places(&all));
        }
    }
}
