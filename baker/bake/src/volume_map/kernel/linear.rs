//! The inner loops for the linear extension function of density maps, gamma = max(s, 0): Eq. 11 of Bender et al. 2020.
//!
//! Where s >= 0 in a whole cell, the integral over it is linear in the 32 coefficients: their products with the
//! integrals of the monomials, a multiply-add each, however many points there are.

use super::{
    BASE, Cells, Content, Group, LANES, Lanes, Line, NODES, Plane, Window, X2, X3, Y2, Y3, Z2, Z3, max,
};

/// As [`super::accumulate`], where [`Content::One`] means s >= 1: the groups need their moments.
#[inline(always)]
pub fn accumulate<const S: usize>(groups: &[Group], window: &Window<S>, first: i32, sums: &mut [f64]) {
    const ZERO: [u8; LANES] = [Content::Zero as u8; LANES];
    const ONE: [u8; LANES] = [Content::One as u8; LANES];
    for group in groups {
        let start = (first + group.step) as usize;
        for (chunk, sums) in sums.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let cells = Cells { values: &window.values, cell: start + chunk * LANES };
            let contents = &window.contents[cells.cell..][..LANES];
            if contents == ZERO {
                continue;
            }
            let integrals = match contents == ONE {
                true => products(&group.moments, &cells),
                false => integrate(group, &cells),
            };
            for (sum, integral) in sums.iter_mut().zip(integrals.0) {
                *sum += integral;
            }
        }
    }
}

#[inline(always)]
fn products<const S: usize>(moments: &[f64], cells: &Cells<S>) -> Lanes {
    let mut sums = [Lanes::default(); 2];
    for (pair, two) in moments.as_chunks::<2>().0.iter().enumerate() {
        for (part, &moment) in two.iter().enumerate() {
            sums[part] = cells.get(2 * pair + part).times_plus(moment, sums[part]);
        }
    }
    sums[0].add(sums[1])
}

/// Weighted sum of max(s, 0) over the points of the group.
#[inline(always)]
fn integrate<const S: usize>(group: &Group, cells: &Cells<S>) -> Lanes {
    let mut sums = [Lanes::default(); 2];
    let (mut points, mut lines) = (group.points.as_slice(), group.lines.as_slice());
    for &(y, count) in &group.planes {
        let plane = Plane::new(cells, y);
        for &(z, count) in lines.split_off(..count as usize).unwrap_or_default() {
            let own = points.split_off(..count as usize).unwrap_or_default();
            sum(&plane.line(z), own, &mut sums);
        }
    }
    sums[0].add(sums[1])
}

/// Two sums, which don't wait for each other.
#[inline(always)]
fn sum(line: &Line, points: &[[f64; 2]], [even, odd]: &mut [Lanes; 2]) {
    let (pairs, rest) = points.as_chunks::<2>();
    for [[x, weight], [next_x, next_weight]] in pairs {
        *even = positive(line.at(*x)).times_plus(*weight, *even);
        *odd = positive(line.at(*next_x)).times_plus(*next_weight, *odd);
    }
    for [x, weight] in rest {
        *even = positive(line.at(*x)).times_plus(*weight, *even);
    }
}

#[inline(always)]
fn positive(s: Lanes) -> Lanes {
    let mut out = s;
    for i in 0..LANES {
        out.0[i] = max(s.0[i], 0.0);
    }
    out
}

/// The integrals of the monomials over a group.
pub fn moments(group: &Group) -> Vec<f64> {
    let mut out = vec![0.0; NODES];
    let (mut points, mut lines) = (group.points.iter(), group.lines.iter());
    for &(y, count) in &group.planes {
        for &(z, count) in lines.by_ref().take(count as usize) {
            for &[x, weight] in points.by_ref().take(count as usize) {
                for (sum, monomial) in out.iter_mut().zip(monomials([x, y, z])) {
                    *sum += weight * monomial;
                }
            }
        }
    }
    out
}

/// The monomials at a point, in their order.
fn monomials([x, y, z]: [f64; 3]) -> [f64; NODES] {
    let product = |i: usize, a: f64, b: f64| [1.0, a][i & 1] * [1.0, b][i >> 1 & 1];
    let mut out = [0.0; NODES];
    for i in 0..8 {
        out[BASE + i] = product(i, x, y) * [1.0, z][i >> 2];
    }
    for i in 0..4 {
        for (square, cube, along, others) in [(X2, X3, x, [y, z]), (Y2, Y3, y, [x, z]), (Z2, Z3, z, [x, y])] {
            let across = product(i, others[0], others[1]);
            out[square + i] = along * along * across;
            out[cube + i] = along * along * along * across;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::tests::{evaluate, group, window};
    use super::super::to_monomials;
    use super::*;
    use crate::random::Random;
    use crate::volume_map::dispatch;

    /// The sum that [`accumulate`] is to add for a cell.
    fn plain(group: &Group, window: &Window<24>, cell: usize) -> f64 {
        let (mut sum, mut lines, mut points) = (0.0, group.lines.iter(), group.points.iter());
        for &(y, count) in &group.planes {
            for &(z, count) in lines.by_ref().take(count as usize) {
                for &[x, weight] in points.by_ref().take(count as usize) {
                    sum += weight * evaluate(window, cell, [x, y, z]).max(0.0);
                }
            }
        }
        sum
    }

    #[test]
    fn accumulate_sums_the_linear_extension_function() {
        let mut random = Random::knuth(11);
        for offset in [-0.2, 0.3, 4.0] {
            let mut own = group(&mut random);
            own.moments = moments(&own);
            let values: Vec<f64> = (0..NODES * 12).map(|_| offset + 0.7 * random.signed()).collect();
            let mut cells = window(12, |cell, a| values[a * 12 + cell]);
            to_monomials(&mut cells);
            for content in [Content::Mixed, Content::One, Content::Zero] {
                if content == Content::One && offset < 4.0 {
                    continue;
                }
                cells.contents.fill(content as u8);
                let mut sums = [0.25; 8];
                accumulate(std::slice::from_ref(&own), &cells, 2, &mut sums);
                for (lane, sum) in sums.iter().enumerate() {
                    let added = if content == Content::Zero { 0.0 } else { plain(&own, &cells, 3 + lane) };
                    assert!((sum - 0.25 - added).abs() < 1e-12, "{offset} {content:?}: {sum} {added}");
                }
            }
        }
    }

    #[test]
    fn dispatched_kernel_has_the_bits_of_the_portable_one() {
        let mut random = Random::knuth(13);
        let mut groups: Vec<Group> = (0..5).map(|_| group(&mut random)).collect();
        groups.iter_mut().for_each(|own| own.moments = moments(own));
        let values: Vec<f64> = (0..NODES * 24).map(|_| 0.5 + 0.8 * random.signed()).collect();
        let run = |accumulate: fn(&[Group], &Window<24>, i32, &mut [f64])| {
            let mut cells = window(24, |cell, a| values[a * 24 + cell]);
            to_monomials(&mut cells);
            cells.contents[8..16].fill(Content::One as u8);
            let mut sums = [0.0; 20];
            accumulate(&groups, &cells, 0, &mut sums);
            sums.map(f64::to_bits)
        };
        assert_eq!(run(dispatch::linear_kernel().accumulate), run(accumulate));
    }
}
