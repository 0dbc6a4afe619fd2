//! The inner loops of the integral, for [`LANES`] neighbouring cells at a time.
//!
//! In a cell, s = 1 - Phi / r is a polynomial of the cubic Serendipity space, whose 32 monomials have their order in
//! [`monomials`](volmap_runtime::layout::serendipity::monomials):
//! so on a line along x it is a cubic, whose coefficients are cubics in z, whose coefficients are cubics in y. Points
//! that share planes and lines share that work (sum factorisation: Orszag 1980, "Spectral methods for problems in
//! complex geometries"); a point on a known line costs 3 multiply-adds instead of 32.
//!
//! Written for vectors of any width: every lane does the same operations in the same order, with fused multiply-adds,
//! and no sum goes across lanes. So the result has the same bits on every processor.

pub mod linear;

use volmap_runtime::layout::serendipity::NODES;
use volmap_runtime::layout::serendipity::monomials::{BASE, X2, X3, Y2, Y3, Z2, Z3};

/// Cells that are worked on together.
pub const LANES: usize = 4;

/// One number of each of [`LANES`] cells.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub struct Lanes(pub [f64; LANES]);

/// The quadrature points of one class of nodes that fall into one cell, as planes of equal y, in these lines of
/// equal z; local coordinates in [-1, 1].
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// The cell along x, from the node's lattice point.
    pub step: i32,
    /// y, and how many of the lines lie in that plane.
    pub planes: Vec<(f64, u32)>,
    /// z, and how many of the points lie on that line.
    pub lines: Vec<(f64, u32)>,
    /// x and weight.
    pub points: Vec<[f64; 2]>,
    /// The integral where gamma* is 1: the sum of the weights.
    pub total: f64,
    /// The integrals of the monomials, for [`linear::accumulate`] alone.
    pub moments: Vec<f64>,
}

/// What gamma*(Phi) is in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Content {
    /// 0: the whole cell is at least r away from the solid.
    Zero,
    /// 1: the whole cell is solid.
    One,
    /// Not known.
    Mixed,
}

/// Up to `S` cells in a row along x: their contents and polynomials, monomial by monomial. As `S`, a multiple of
/// [`LANES`], is known to the compiler, so are the places of all monomials.
#[derive(Clone, Debug)]
pub struct Window<const S: usize> {
    /// Per cell, what it holds.
    pub contents: Box<[u8; S]>,
    /// Per monomial (or node, before [`to_monomials`]), a number for each cell.
    pub values: Box<[[f64; S]; NODES]>,
    /// Cells in use.
    pub width: usize,
}

impl<const S: usize> Default for Window<S> {
    fn default() -> Self {
        // By way of the heap: the stack of a thread may be too small.
        let values = vec![[0.0; S]; NODES].into_boxed_slice();
        let values = values.try_into().unwrap_or_else(|_| unreachable!("as many rows as nodes"));
        Window { contents: Box::new([Content::Zero as u8; S]), values, width: 0 }
    }
}

/// Adds the integrals over a row of cells to the sums of the nodes: `sums[n]` gets, for each group, its integral over
/// cell `first + step + n` of the window.
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
                true => Lanes([group.total; LANES]),
                false => integrate(group, &cells),
            };
            for (sum, integral) in sums.iter_mut().zip(integrals.0) {
                *sum += integral;
            }
        }
    }
}

/// The integral of gamma* over a group where it is 1, by the same operations as elsewhere.
pub fn total(group: &Group) -> f64 {
    let mut values = [[0.0; LANES]; NODES];
    values[BASE] = [1.0; LANES];
    integrate(group, &Cells { values: &values, cell: 0 }).0[0]
}

/// [`LANES`] cells of a window.
struct Cells<'a, const S: usize> {
    values: &'a [[f64; S]; NODES],
    cell: usize,
}

impl<const S: usize> Cells<'_, S> {
    #[inline(always)]
    fn get(&self, a: usize) -> Lanes {
        let mut out = Lanes::default();
        out.0.copy_from_slice(&self.values[a][self.cell..][..LANES]);
        out
    }
}

/// Weighted sum of gamma* over the points of the group. With a = clamp(s, 0, 1), gamma* is 2 a^3 - 8 (a - 1/2)_+^3:
/// Eq. 13 of Bender et al. 2020 in truncated powers.
#[inline(always)]
fn integrate<const S: usize>(group: &Group, cells: &Cells<S>) -> Lanes {
    let mut sums = [Lanes::default(); 2];
    let mut points = group.points.as_slice();
    if group.planes.len() == group.lines.len() {
        // A line a plane: the plane needs not be kept.
        for (&(y, _), &(z, count)) in group.planes.iter().zip(&group.lines) {
            let own = points.split_off(..count as usize).unwrap_or_default();
            Plane::new(cells, y).line(z).sum(own, &mut sums);
        }
    } else {
        let mut lines = group.lines.as_slice();
        for &(y, count) in &group.planes {
            let plane = Plane::new(cells, y);
            for &(z, count) in lines.split_off(..count as usize).unwrap_or_default() {
                let own = points.split_off(..count as usize).unwrap_or_default();
                plane.line(z).sum(own, &mut sums);
            }
        }
    }
    from_powers(sums)
}

/// The integral of gamma* from those of a^3 and (a - 1/2)_+^3.
#[inline(always)]
pub fn from_powers([outer, inner]: [Lanes; 2]) -> Lanes {
    outer.scale(2.0).sub(inner.scale(8.0))
}

/// s in a plane of constant y: x^a z^c at a + 2 c, then z^2, z^3 for a = 0, 1 and x^2, x^3 for c = 0, 1.
#[derive(Default)]
struct Plane {
    base: [Lanes; 4],
    z2: [Lanes; 2],
    z3: [Lanes; 2],
    x2: [Lanes; 2],
    x3: [Lanes; 2],
}

impl Plane {
    #[inline(always)]
    fn new<const S: usize>(m: &Cells<S>, y: f64) -> Plane {
        let mut plane = Plane::default();
        for at in 0..4 {
            let (a, c) = (at & 1, at >> 1);
            let low = BASE + a + 4 * c;
            let cubic = m.get(Y3 + at).times_plus(y, m.get(Y2 + at));
            plane.base[at] = cubic.times_plus(y, m.get(low + 2)).times_plus(y, m.get(low));
        }
        for i in 0..2 {
            plane.z2[i] = m.get(Z2 + i + 2).times_plus(y, m.get(Z2 + i));
            plane.z3[i] = m.get(Z3 + i + 2).times_plus(y, m.get(Z3 + i));
            plane.x2[i] = m.get(X2 + 2 * i + 1).times_plus(y, m.get(X2 + 2 * i));
            plane.x3[i] = m.get(X3 + 2 * i + 1).times_plus(y, m.get(X3 + 2 * i));
        }
        plane
    }

    /// The cubic in x at constant z.
    #[inline(always)]
    fn line(&self, z: f64) -> Line {
        let mut line = Line::default();
        for a in 0..2 {
            let high = self.z3[a].times_plus(z, self.z2[a]);
            line.0[a] = high.times_plus(z, self.base[a + 2]).times_plus(z, self.base[a]);
        }
        line.0[2] = self.x2[1].times_plus(z, self.x2[0]);
        line.0[3] = self.x3[1].times_plus(z, self.x3[0]);
        line
    }
}

/// s on a line along x: the coefficients of 1, x, x^2, x^3.
#[derive(Default)]
pub struct Line(pub [Lanes; 4]);

impl Line {
    /// Adds the weighted a^3 and (a - 1/2)_+^3 of points on the line.
    #[inline(always)]
    fn sum(&self, points: &[[f64; 2]], sums: &mut [Lanes; 2]) {
        for &[x, weight] in points {
            self.add(x, weight, sums);
        }
    }

    /// The same for one point.
    #[inline(always)]
    pub fn add(&self, x: f64, weight: f64, [outer, inner]: &mut [Lanes; 2]) {
        let a = self.at(x).clamp_unit();
        let b = a.above_half();
        *outer = a.mul(a).mul(a).times_plus(weight, *outer);
        *inner = b.mul(b).mul(b).times_plus(weight, *inner);
    }

    #[inline(always)]
    fn at(&self, x: f64) -> Lanes {
        let [c0, c1, c2, c3] = self.0;
        c3.times_plus(x, c2).times_plus(x, c1).times_plus(x, c0)
    }
}

// Loops and no closures: a closure would be compiled without the features of the function it is called from, unless it
// happens to be inlined.
impl Lanes {
    #[inline(always)]
    fn times_plus(self, factor: f64, addend: Lanes) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i].mul_add(factor, addend.0[i]);
        }
        out
    }

    #[inline(always)]
    fn mul(self, other: Lanes) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i] * other.0[i];
        }
        out
    }

    #[inline(always)]
    fn add(self, other: Lanes) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i] + other.0[i];
        }
        out
    }

    #[inline(always)]
    fn sub(self, other: Lanes) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i] - other.0[i];
        }
        out
    }

    #[inline(always)]
    fn scale(self, factor: f64) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i] * factor;
        }
        out
    }

    #[inline(always)]
    fn clamp_unit(self) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = max(min(self.0[i], 1.0), 0.0);
        }
        out
    }

    #[inline(always)]
    fn above_half(self) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = max(self.0[i] - 0.5, 0.0);
        }
        out
    }
}

/// Not `f64::min`, which must care about NaN; fields hold none.
#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Turns the values of s at the cells' nodes into coefficients of the monomials, in place.
#[inline(always)]
pub fn to_monomials<const S: usize>(window: &mut Window<S>) {
    for cell in (0..window.width).step_by(LANES) {
        let monomials = monomials(&Cells { values: &window.values, cell });
        for (a, monomial) in monomials.iter().enumerate() {
            window.values[a][cell..][..LANES].copy_from_slice(&monomial.0);
        }
    }
}

/// Corners: (1 +- x)(1 +- y)(1 +- z)(9 (x^2 + y^2 + z^2) - 19) / 64. Edges along x: the sum P and difference Q of the
/// two nodes' values give (1 - x^2)(P + Q x) (1 +- y)(1 +- z), factors 9/64 and 27/64; along y and z alike.
#[inline(always)]
fn monomials<const S: usize>(nodes: &Cells<S>) -> [Lanes; NODES] {
    let mut corner = [Lanes::default(); 8];
    let mut out = [Lanes::default(); NODES];
    for (i, value) in corner.iter_mut().enumerate() {
        *value = nodes.get(i).scale(1.0 / 64.0);
    }
    for axis in 0..3 {
        hadamard(&mut corner, axis);
    }
    for i in 0..8 {
        out[BASE + i] = corner[i].scale(-19.0);
    }
    for axis in 0..3 {
        let (mut sums, mut differences) = ([Lanes::default(); 4], [Lanes::default(); 4]);
        for i in 0..4 {
            let (lower, upper) = (nodes.get(8 + 8 * axis + 2 * i), nodes.get(8 + 8 * axis + 2 * i + 1));
            sums[i] = lower.add(upper).scale(9.0 / 64.0);
            differences[i] = upper.sub(lower).scale(27.0 / 64.0);
        }
        for side in 0..2 {
            hadamard(&mut sums, side);
            hadamard(&mut differences, side);
        }
        for i in 0..4 {
            let (even, odd) = (with_power(i, axis, 0), with_power(i, axis, 1));
            out[BASE + even] = out[BASE + even].add(sums[i]);
            out[BASE + odd] = out[BASE + odd].add(differences[i]);
            out[X2 + 8 * axis + i] = corner[even].scale(9.0).sub(sums[i]);
            out[X3 + 8 * axis + i] = corner[odd].scale(9.0).sub(differences[i]);
        }
    }
    out
}

/// Index of a monomial of powers 0 and 1 from that of its other two axes and its power along `axis`.
#[inline(always)]
fn with_power(others: usize, axis: usize, power: usize) -> usize {
    let low = others & ((1 << axis) - 1);
    low | power << axis | (others >> axis) << (axis + 1)
}

/// Values at the two sides of an axis to the coefficients of 1 and x.
#[inline(always)]
fn hadamard<const N: usize>(values: &mut [Lanes; N], axis: usize) {
    for i in 0..N {
        if i >> axis & 1 == 0 {
            let (low, high) = (values[i], values[i | 1 << axis]);
            values[i] = low.add(high);
            values[i | 1 << axis] = high.sub(low);
        }
    }
}

/// What gamma* is in each cell of a window of monomials: every monomial is within [-1, 1], squares within [0, 1].
#[inline(always)]
pub fn classify<const S: usize>(window: &mut Window<S>) {
    for cell in (0..window.width).step_by(LANES) {
        let cells = Cells { values: &window.values, cell };
        let (mut low, mut high) = (cells.get(BASE), cells.get(BASE));
        for a in 1..NODES {
            let term = cells.get(a);
            let square = [X2, Y2, Z2].contains(&a);
            for lane in 0..LANES {
                let size = term.0[lane].abs();
                low.0[lane] -= if square && term.0[lane] > 0.0 { 0.0 } else { size };
                high.0[lane] += if square && term.0[lane] < 0.0 { 0.0 } else { size };
            }
        }
        for lane in 0..LANES {
            let content = match (high.0[lane] <= 0.0, low.0[lane] >= 1.0) {
                (true, _) => Content::Zero,
                (_, true) => Content::One,
                _ => Content::Mixed,
            };
            window.contents[cell + lane] = content as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::volume_map::dispatch;
    use crate::volume_map::extension::extension;
    use glam::DVec3;
    use volmap_runtime::layout::serendipity::monomials::POWERS;
    use volmap_runtime::layout::serendipity::{node, shape};

    pub fn window(width: usize, value: impl Fn(usize, usize) -> f64) -> Window<24> {
        let mut window = Window { width, ..Window::default() };
        window.contents.fill(Content::Mixed as u8);
        for (a, row) in window.values.iter_mut().enumerate() {
            row[..width].iter_mut().enumerate().for_each(|(cell, v)| *v = value(cell, a));
        }
        window
    }

    /// s at a point of a cell, by the monomials.
    pub fn evaluate(window: &Window<24>, cell: usize, p: [f64; 3]) -> f64 {
        let term = |i: usize| (0..3).map(|a| p[a].powi(POWERS[i][a].into())).product::<f64>();
        (0..NODES).map(|i| window.values[i][cell] * term(i)).sum()
    }

    #[test]
    fn monomials_are_the_element() {
        let mut random = Random::knuth(1);
        let values: Vec<f64> = (0..NODES * 8).map(|_| random.signed()).collect();
        let mut cells = window(8, |cell, a| values[a * 8 + cell]);
        to_monomials(&mut cells);
        for _ in 0..100 {
            let p = [random.signed(), random.signed(), random.signed()];
            for cell in 0..8 {
                let shapes = shape(DVec3::from(p));
                let expected: f64 = (0..NODES).map(|a| shapes[a] * values[a * 8 + cell]).sum();
                assert!((evaluate(&cells, cell, p) - expected).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn contents_of_linear_functions_are_exact() {
        for (offset, expected) in
            [(-3.5, Content::Zero), (-3.499, Content::Mixed), (4.499, Content::Mixed), (4.501, Content::One)]
        {
            let mut cells = window(4, |_, a| node(a).dot(DVec3::new(1.0, 2.0, -0.5)) + offset);
            to_monomials(&mut cells);
            // Rounding of the highest value, 0, may show.
            cells.values[0].iter_mut().for_each(|base| *base -= 1e-12);
            classify(&mut cells);
            assert_eq!(cells.contents[..4], [expected as u8; 4], "{offset}");
        }
    }

    #[test]
    fn contents_hold_at_every_point() {
        let mut random = Random::knuth(7);
        let mut seen = [0; 3];
        for _ in 0..400 {
            let (offset, size) = (3.0 * random.signed() + 0.5, random.signed());
            let values: Vec<f64> = (0..NODES).map(|_| offset + 0.3 * size * random.signed()).collect();
            let mut cells = window(4, |_, a| values[a]);
            to_monomials(&mut cells);
            classify(&mut cells);
            seen[cells.contents[0] as usize] += 1;
            for _ in 0..50 {
                let s = evaluate(&cells, 0, [random.signed(), random.signed(), random.signed()]);
                assert!(cells.contents[0] != Content::Zero as u8 || s <= 1e-14);
                assert!(cells.contents[0] != Content::One as u8 || s >= 1.0 - 1e-14);
            }
        }
        assert!(seen.iter().all(|&n| n > 20), "{seen:?}");
    }

    pub fn group(random: &mut Random) -> Group {
        let mut group = Group { step: 1, ..Group::default() };
        for plane in 0..3u32 {
            group.planes.push((random.signed(), plane + 1));
            for line in 0..=plane {
                group.lines.push((random.signed(), line + 1));
                (0..=line).for_each(|_| group.points.push([random.signed(), random.signed() + 1.0]));
            }
        }
        group.total = total(&group);
        group
    }

    #[test]
    fn accumulate_sums_the_extension_function() {
        let mut random = Random::knuth(3);
        let groups = [group(&mut random)];
        let values: Vec<f64> = (0..NODES * 12).map(|_| 0.5 + 0.7 * random.signed()).collect();
        let mut cells = window(12, |cell, a| values[a * 12 + cell]);
        to_monomials(&mut cells);
        cells.contents[3..7].fill(Content::One as u8);
        cells.contents[7..11].fill(Content::Zero as u8);
        let mut sums = [0.25; 8];
        accumulate(&groups, &cells, 2, &mut sums);
        for lane in 0..8 {
            let (mut expected, mut lines, mut points) =
                (0.25, groups[0].lines.iter(), groups[0].points.iter());
            for &(y, count) in &groups[0].planes {
                for &(z, count) in lines.by_ref().take(count as usize) {
                    for &[x, weight] in points.by_ref().take(count as usize) {
                        let phi = 1.0 - evaluate(&cells, 3 + lane, [x, y, z]);
                        expected += weight * extension(phi, 1.0);
                    }
                }
            }
            match lane {
                0..4 => assert_eq!(sums[lane], 0.25 + groups[0].total),
                _ => assert_eq!(sums[lane], 0.25),
            }
            let weights: f64 = groups[0].points.iter().map(|p| p[1]).sum();
            assert!((groups[0].total - weights).abs() < 1e-14);
            // The same cells, not known to be of one kind.
            let mut mixed = cells.clone();
            mixed.contents.fill(Content::Mixed as u8);
            let mut sums = [0.25; 8];
            accumulate(&groups, &mixed, 2, &mut sums);
            assert!((sums[lane] - expected).abs() < 1e-13, "{} {expected}", sums[lane]);
        }
    }

    #[test]
    fn dispatched_kernel_has_the_bits_of_the_portable_one() {
        let mut random = Random::knuth(5);
        let groups: Vec<Group> = (0..5).map(|_| group(&mut random)).collect();
        let values: Vec<f64> = (0..NODES * 24).map(|_| 0.5 + 0.8 * random.signed()).collect();
        let run = |kernel: dispatch::Kernel<24>| {
            let mut cells = window(24, |cell, a| values[a * 24 + cell]);
            (kernel.to_monomials)(&mut cells);
            let mut sums = [0.0; 20];
            (kernel.accumulate)(&groups, &cells, 0, &mut sums);
            (kernel.classify)(&mut cells);
            (
                cells.contents,
                cells.values.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>(),
                sums.map(f64::to_bits),
            )
        };
        assert_eq!(run(dispatch::kernel()), run(dispatch::portable()));
    }
}
