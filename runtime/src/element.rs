//! The cubic Serendipity element (`serendipity.rs`) by its structure, for four points at a time.
//!
//! With f = (1 + xi) / 2 in [0, 1] and h(f) = 9/2 f (1 - f), e(f) = (3 f - 1) h(f), the sum of the 32 products is
//!
//! ```text
//! (1 - h(fx) - h(fy) - h(fz)) T  +  h(fx) X + e(fx) X'  +  h(fy) Y + e(fy) Y'  +  h(fz) Z + e(fz) Z'
//! ```
//!
//! with T trilinear from the corners, X bilinear in fy and fz from the lower nodes of the x-edges, X' the same from the
//! differences "upper minus lower node", and so on. So 32 nodes are four cubes of 8: the corners and the edges of each
//! axis. In differences of a cube along its axes the trilinear polynomial is the one that Horner's scheme evaluates:
//! a + p A + s (B + p C), its derivatives come nearly for nothing, and the differences depend on the cell only.

use crate::lanes::Lanes;

/// A cube's nodes in four rows, (second axis, third axis) = (0, 0), (1, 0), (0, 1), (1, 1), each of the two along its
/// first axis (the corner's x, or the edge's own): distance and volume of the lower, distance and volume of the upper.
pub(crate) type Rows<V> = [V; 4];

/// The differences of a cube by row and place in the row, for four points: of distance and volume of the lower nodes,
/// and of distance and volume "upper minus lower".
pub(crate) type Cube<V> = [[V; 4]; 4];

/// Which field: its place in a row.
#[derive(Clone, Copy)]
enum Field {
    Distance = 0,
    Volume = 1,
}

/// Differences of a cube along its second and third axes. (Those along the first, within the rows, are left to who
/// lays the rows out.)
#[inline(always)]
pub(crate) fn differences<V: Lanes>([a, b, c, d]: Rows<V>) -> Rows<V> {
    let (second, third) = (b - a, c - a);
    [a, second, third, (d - c) - second]
}

/// Factors of the formula at the top and their derivatives with respect to f, each by axis.
pub(crate) struct Weights<V> {
    f: [V; 3],
    h: [V; 3],
    e: [V; 3],
    dh: [V; 3],
    de: [V; 3],
    corner: V,
}

impl<V: Lanes> Weights<V> {
    #[inline(always)]
    pub fn new(f: [V; 3]) -> Weights<V> {
        let c = V::splat;
        let zero = [c(0.0); 3];
        let mut w = Weights { f, h: zero, e: zero, dh: zero, de: zero, corner: c(1.0) };
        for axis in 0..3 {
            let f = f[axis];
            let (slant, h, dh) = (c(3.0) * f - c(1.0), c(4.5) * (f - f * f), c(4.5) - c(9.0) * f);
            (w.h[axis], w.dh[axis]) = (h, dh);
            w.e[axis] = slant * h;
            w.de[axis] = slant * dh + c(3.0) * h;
        }
        w.corner = c(1.0) - ((w.h[0] + w.h[1]) + w.h[2]);
        w
    }
}

/// A bilinear function and its slopes.
#[derive(Clone, Copy)]
struct Patch<V> {
    value: V,
    second: V,
    third: V,
}

impl<V: Lanes> Patch<V> {
    /// From the differences of its four numbers.
    #[inline(always)]
    fn new([a, second, third, both]: [V; 4], p: V, s: V) -> Patch<V> {
        let rise = third + both * p;
        Patch { value: (a + second * p) + rise * s, second: second + both * s, third: rise }
    }
}

/// A cube's first axis: its lower nodes and the differences to the upper ones.
#[derive(Clone, Copy)]
struct Pair<V> {
    lower: Patch<V>,
    rise: Patch<V>,
}

/// The differences of the cells of four points.
pub(crate) trait Numbers<V> {
    /// Of corners, x-edges, y-edges or z-edges.
    fn cube(&self, cube: usize) -> Cube<V>;
}

/// All four points in one cell.
pub(crate) struct Shared(pub [[[f64; 4]; 4]; 4]);

impl<V: Lanes> Numbers<V> for Shared {
    #[inline(always)]
    fn cube(&self, cube: usize) -> Cube<V> {
        let mut out = [[V::splat(0.0); 4]; 4];
        for (out, row) in out.iter_mut().zip(&self.0[cube]) {
            *out = [V::splat(row[0]), V::splat(row[1]), V::splat(row[2]), V::splat(row[3])];
        }
        out
    }
}

impl<V: Lanes> Pair<V> {
    #[inline(always)]
    fn new([a, b, c, d]: &Cube<V>, field: Field, p: V, s: V) -> Pair<V> {
        let (lower, rise) = (field as usize, 2 + field as usize);
        Pair {
            lower: Patch::new([a[lower], b[lower], c[lower], d[lower]], p, s),
            rise: Patch::new([a[rise], b[rise], c[rise], d[rise]], p, s),
        }
    }

    #[inline(always)]
    fn of_both(cube: &Cube<V>, p: V, s: V) -> [Pair<V>; 2] {
        [Pair::new(cube, Field::Distance, p, s), Pair::new(cube, Field::Volume, p, s)]
    }

    #[inline(always)]
    fn value(&self, lower: V, rise: V) -> V {
        self.lower.value * lower + self.rise.value * rise
    }

    #[inline(always)]
    fn second(&self, lower: V, rise: V) -> V {
        self.lower.second * lower + self.rise.second * rise
    }

    #[inline(always)]
    fn third(&self, lower: V, rise: V) -> V {
        self.lower.third * lower + self.rise.third * rise
    }
}

/// The four cubes of one field at the points.
pub(crate) struct Cubes<V> {
    corners: Pair<V>,
    x: Pair<V>,
    y: Pair<V>,
    z: Pair<V>,
}

impl<V: Lanes> Cubes<V> {
    /// Of distance and volume. A cube at a time, for that many numbers fit into the registers.
    #[inline(always)]
    pub fn of_both(numbers: &impl Numbers<V>, w: &Weights<V>) -> [Cubes<V>; 2] {
        let [fx, fy, fz] = w.f;
        let [corners, corners_v] = Pair::of_both(&numbers.cube(0), fy, fz);
        let [x, x_v] = Pair::of_both(&numbers.cube(1), fy, fz);
        let [y, y_v] = Pair::of_both(&numbers.cube(2), fx, fz);
        let [z, z_v] = Pair::of_both(&numbers.cube(3), fx, fy);
        [Cubes { corners, x, y, z }, Cubes { corners: corners_v, x: x_v, y: y_v, z: z_v }]
    }

    #[inline(always)]
    fn corner(&self, w: &Weights<V>) -> V {
        self.corners.lower.value + self.corners.rise.value * w.f[0]
    }

    #[inline(always)]
    pub fn value(&self, w: &Weights<V>) -> V {
        let edges =
            (self.x.value(w.h[0], w.e[0]) + self.y.value(w.h[1], w.e[1])) + self.z.value(w.h[2], w.e[2]);
        self.corner(w) * w.corner + edges
    }

    /// With respect to f.
    #[inline(always)]
    pub fn gradient(&self, w: &Weights<V>) -> [V; 3] {
        let Weights { f, h, e, dh, de, corner: factor } = w;
        let corner = self.corner(w);
        let corner_y = self.corners.lower.second + self.corners.rise.second * f[0];
        let corner_z = self.corners.lower.third + self.corners.rise.third * f[0];
        let x = self.x.value(dh[0], de[0]) + (self.y.second(h[1], e[1]) + self.z.second(h[2], e[2]));
        let y = self.y.value(dh[1], de[1]) + (self.x.second(h[0], e[0]) + self.z.third(h[2], e[2]));
        let z = self.z.value(dh[2], de[2]) + (self.x.third(h[0], e[0]) + self.y.third(h[1], e[1]));
        [
            (self.corners.rise.value * *factor - corner * dh[0]) + x,
            (corner_y * *factor - corner * dh[1]) + y,
            (corner_z * *factor - corner * dh[2]) + z,
        ]
    }
}
