//! Many points at a time: locate and find a block of them, then evaluate those of the band by fours.
//!
//! Points that lie in one cell, as sorted particles do, share its differences; others are laid side by side. Both give
//! the bits of a point by itself, for each number goes through the same operations.

#[cfg(target_arch = "x86_64")]
use crate::avx2;
use crate::element::{Cube, Cubes, Numbers, Rows, Shared, Weights, differences};
use crate::finder::{Finder, Frame};
use crate::grid::Grid;
use crate::lanes::{LANES, Lanes, Plain, Vectorized};
use crate::layout::{Found, Place};
use crate::map::{Content, VolumeMap};
use crate::sample::{MapDensity, Sample, Surface, SurfaceWithGradient, Values};
use crate::storage::{Pairs, RealPairs, Singles, Storage, rows};
use glam::{DVec3, UVec3};
use volmap_formats::asset::Exterior;

/// Points of a block.
const BLOCK: usize = 64;

/// What a batch answers of each point.
pub(crate) trait Evaluate: Copy {
    fn outside(map: &VolumeMap) -> Self;
    fn deep_inside(map: &VolumeMap) -> Self;
    /// Answers the points `which` of `out`, at most four, which are in the band.
    fn near<V: Lanes, F: Frame<V>>(at: &Evaluated<V, F>, which: &[u32], out: &mut [Self]);

    /// Answers all points from the fields that hold the answer.
    #[inline(always)]
    fn all<V: Lanes>(map: &VolumeMap, points: &[DVec3], out: &mut [Self]) {
        match &map.content {
            Content::Uniform(cells, fields) => match fields {
                Pairs::F32(nodes) => answers::<V, _, _, Self>(map, cells, nodes.as_slice(), points, out),
                Pairs::F64(nodes) => answers::<V, _, _, Self>(map, cells, nodes.as_slice(), points, out),
                Pairs::Rounded(multiples) => answers::<V, _, _, Self>(map, cells, multiples, points, out),
            },
            Content::Adaptive(cells, fields) => match fields {
                RealPairs::F32(nodes) => answers::<V, _, _, Self>(map, cells, nodes.as_slice(), points, out),
                RealPairs::F64(nodes) => answers::<V, _, _, Self>(map, cells, nodes.as_slice(), points, out),
            },
        }
    }
}

impl Evaluate for Values {
    #[inline(always)]
    fn outside(_: &VolumeMap) -> Values {
        Values { distance: f64::INFINITY, volume: 0.0 }
    }

    #[inline(always)]
    fn deep_inside(map: &VolumeMap) -> Values {
        Values { distance: f64::NEG_INFINITY, volume: map.quadrature.ball_volume }
    }

    #[inline(always)]
    fn near<V: Lanes, F: Frame<V>>(at: &Evaluated<V, F>, which: &[u32], out: &mut [Values]) {
        let distance = at.distance.value(&at.weights);
        let volume = at.frame.volume(at.frame.wall(distance), at.volume.value(&at.weights)).array();
        let distance = distance.array();
        for (lane, &point) in which.iter().enumerate() {
            out[point as usize] = Values { distance: distance[lane], volume: volume[lane] };
        }
    }
}

impl Evaluate for Sample {
    #[inline(always)]
    fn outside(_: &VolumeMap) -> Sample {
        Sample::Outside
    }

    #[inline(always)]
    fn deep_inside(_: &VolumeMap) -> Sample {
        Sample::DeepInside
    }

    #[inline(always)]
    fn near<V: Lanes, F: Frame<V>>(at: &Evaluated<V, F>, which: &[u32], out: &mut [Sample]) {
        let seen = at.seen();
        for (lane, &point) in which.iter().enumerate() {
            out[point as usize] = Sample::Near(seen.surface(lane));
        }
    }
}

impl Evaluate for Sample<SurfaceWithGradient> {
    #[inline(always)]
    fn outside(_: &VolumeMap) -> Sample<SurfaceWithGradient> {
        Sample::Outside
    }

    #[inline(always)]
    fn deep_inside(_: &VolumeMap) -> Sample<SurfaceWithGradient> {
        Sample::DeepInside
    }

    #[inline(always)]
    fn near<V: Lanes, F: Frame<V>>(
        at: &Evaluated<V, F>,
        which: &[u32],
        out: &mut [Sample<SurfaceWithGradient>],
    ) {
        let seen = at.seen();
        let slope = at.frame.volume_slope(seen.wall, at.volume.gradient(&at.weights), seen.slope);
        let gradients = at.per_point(slope);
        for (lane, &point) in which.iter().enumerate() {
            let (surface, volume_gradient) = (seen.surface(lane), in_lane(&gradients, lane));
            out[point as usize] = Sample::Near(SurfaceWithGradient { surface, volume_gradient });
        }
    }
}

impl Evaluate for Option<MapDensity> {
    #[inline(always)]
    fn outside(_: &VolumeMap) -> Option<MapDensity> {
        Some(MapDensity::default())
    }

    #[inline(always)]
    fn deep_inside(_: &VolumeMap) -> Option<MapDensity> {
        None
    }

    #[inline(always)]
    fn near<V: Lanes, F: Frame<V>>(at: &Evaluated<V, F>, which: &[u32], out: &mut [Option<MapDensity>]) {
        let value = at.volume.value(&at.weights).array();
        let gradients = at.per_point(at.volume.gradient(&at.weights));
        for (lane, &point) in which.iter().enumerate() {
            out[point as usize] =
                Some(MapDensity { value: value[lane], gradient: in_lane(&gradients, lane) });
        }
    }

    #[inline(always)]
    fn all<V: Lanes>(map: &VolumeMap, points: &[DVec3], out: &mut [Option<MapDensity>]) {
        let Content::Uniform(cells, _) = &map.content else { return out.fill(None) };
        match map.density.as_ref().map(|density| &density.numbers) {
            Some(Singles::F32(nodes)) => answers::<V, _, _, Self>(map, cells, nodes.as_slice(), points, out),
            Some(Singles::F64(nodes)) => answers::<V, _, _, Self>(map, cells, nodes.as_slice(), points, out),
            Some(Singles::Rounded(steps)) => answers::<V, _, _, Self>(map, cells, steps, points, out),
            None => out.fill(None),
        }
    }
}

/// Four points in the band and the element there.
pub(crate) struct Evaluated<V, F> {
    points: [V; 3],
    weights: Weights<V>,
    distance: Cubes<V>,
    volume: Cubes<V>,
    frame: F,
}

impl<V: Lanes, F: Frame<V>> Evaluated<V, F> {
    #[inline(always)]
    fn new(numbers: &impl Numbers<V>, points: [V; 3], f: [V; 3], frame: F) -> Evaluated<V, F> {
        let weights = Weights::new(f);
        let [distance, volume] = Cubes::of_both(numbers, &weights);
        Evaluated { points, weights, distance, volume, frame }
    }

    #[inline(always)]
    fn seen(&self) -> Seen<V, F::Wall> {
        let distance = self.distance.value(&self.weights);
        let wall = self.frame.wall(distance);
        let volume = self.frame.volume(wall, self.volume.value(&self.weights)).array();
        let slope = self.distance.gradient(&self.weights);
        let per_cell = self.frame.per_cell();
        let n = unit([slope[0] * per_cell[0], slope[1] * per_cell[1], slope[2] * per_cell[2]]);
        let [x, y, z] = self.points;
        Seen {
            closest: arrays([x - distance * n[0], y - distance * n[1], z - distance * n[2]]),
            normal: arrays(n),
            distance: distance.array(),
            volume,
            wall,
            slope,
        }
    }

    /// Gradients with respect to the points, from slopes in their cells.
    #[inline(always)]
    fn per_point(&self, slope: [V; 3]) -> [[f64; LANES]; 3] {
        let per_cell = self.frame.per_cell();
        arrays([slope[0] * per_cell[0], slope[1] * per_cell[1], slope[2] * per_cell[2]])
    }
}

/// The surface as four points see it.
struct Seen<V, W> {
    distance: [f64; LANES],
    volume: [f64; LANES],
    normal: [[f64; LANES]; 3],
    closest: [[f64; LANES]; 3],
    /// What a flat wall adds to the volume.
    wall: W,
    /// The distance's, in the cell.
    slope: [V; 3],
}

impl<V, W> Seen<V, W> {
    #[inline(always)]
    fn surface(&self, lane: usize) -> Surface {
        Surface {
            distance: self.distance[lane],
            normal: in_lane(&self.normal, lane),
            closest_point: in_lane(&self.closest, lane),
            volume: self.volume[lane],
        }
    }
}

// No closures here: they would not be compiled for the processor that has the lanes.
#[inline(always)]
fn arrays<V: Lanes>([x, y, z]: [V; 3]) -> [[f64; LANES]; 3] {
    [x.array(), y.array(), z.array()]
}

#[inline(always)]
fn in_lane([x, y, z]: &[[f64; LANES]; 3], lane: usize) -> DVec3 {
    DVec3::new(x[lane], y[lane], z[lane])
}

/// Vectors of length 1, or zero where that can't be.
#[inline(always)]
fn unit<V: Lanes>(v: [V; 3]) -> [V; 3] {
    let square = (v[0] * v[0] + v[1] * v[1]) + v[2] * v[2];
    let inverse = (V::splat(1.0) / square.sqrt()).zero_unless_below(V::splat(f64::INFINITY));
    [v[0] * inverse, v[1] * inverse, v[2] * inverse]
}

/// Answers for all points, with the widest vectors that this processor has; `out` is as long as `points`.
pub(crate) fn answer_all<A: Evaluate>(map: &VolumeMap, points: &[DVec3], out: &mut [A]) {
    let all = All { map, points, out };
    #[cfg(target_arch = "x86_64")]
    let Some(all) = avx2::run(all) else { return };
    all.run::<Plain>();
}

/// Points and where their answers go.
struct All<'a, A> {
    map: &'a VolumeMap,
    points: &'a [DVec3],
    out: &'a mut [A],
}

impl<A: Evaluate> Vectorized for All<'_, A> {
    #[inline(always)]
    fn run<V: Lanes>(self) {
        A::all::<V>(self.map, self.points, self.out);
    }
}

/// A map, its cells, and the values at its nodes.
struct Asked<'a, S: ?Sized, C> {
    map: &'a VolumeMap,
    cells: &'a C,
    fields: &'a S,
}

#[inline(always)]
fn answers<V: Lanes, S: Storage + ?Sized, C: Finder, A: Evaluate>(
    map: &VolumeMap,
    cells: &C,
    fields: &S,
    points: &[DVec3],
    out: &mut [A],
) {
    let asked = &Asked { map, cells, fields };
    match (points, &mut *out) {
        ([point], [out]) => one::<V, S, C, A>(asked, *point, out),
        _ => blocks::<V, S, C, A>(asked, points, out),
    }
}

#[inline(always)]
fn blocks<V: Lanes, S: Storage + ?Sized, C: Finder, A: Evaluate>(
    asked: &Asked<S, C>,
    points: &[DVec3],
    out: &mut [A],
) {
    let mut near = Near {
        count: 0,
        index: [0; BLOCK],
        place: [Place::NONE; BLOCK],
        f: [[0.0; BLOCK]; 3],
        points: [[0.0; BLOCK]; 3],
    };
    let mut padded = [DVec3::NAN; BLOCK];
    let mut shared = Differences::none();
    for (points, out) in points.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let block = match points.first_chunk() {
            Some(block) => block,
            None => {
                padded[..points.len()].copy_from_slice(points);
                &padded
            }
        };
        collect::<V, C, A>(asked.map, asked.cells, block, out, &mut near);
        near.pad();
        let fours = near.count.div_ceil(LANES);
        for four in 0..fours {
            let points: [V; 3] = near.four(&near.points, four);
            let f: [V; 3] = near.four(&near.f, four);
            let places = near.place.as_chunks::<LANES>().0[four];
            let which = &near.index[LANES * four..near.count.min(LANES * (four + 1))];
            if places == [places[0]; LANES] {
                shared.load::<V, S, C>(asked, places[0]);
                let frame = asked.cells.frame(asked.map.per_cell, &places, &f);
                A::near(&Evaluated::new(&shared.numbers, points, f, frame), which, out);
            } else {
                let apart = Apart::load(asked, places);
                let frame = asked.cells.frame(asked.map.per_cell, &places, &f);
                A::near(&Evaluated::new(&apart, points, f, frame), which, out);
            }
        }
    }
}

/// Points of a block that lie in the band.
struct Near {
    count: usize,
    /// Which of the block.
    index: [u32; BLOCK],
    place: [Place; BLOCK],
    /// Place in the cell, 0 to 1 along each axis.
    f: [[f64; BLOCK]; 3],
    points: [[f64; BLOCK]; 3],
}

impl Near {
    /// Fills the last four up with copies.
    #[inline(always)]
    fn pad(&mut self) {
        for n in self.count..self.count.next_multiple_of(LANES).min(BLOCK) {
            self.place[n] = self.place[n - 1];
            for axis in 0..3 {
                self.f[axis][n] = self.f[axis][n - 1];
                self.points[axis][n] = self.points[axis][n - 1];
            }
        }
    }

    #[inline(always)]
    fn four<V: Lanes>(&self, of: &[[f64; BLOCK]; 3], four: usize) -> [V; 3] {
        let axis = |axis: usize| V::new(of[axis].as_chunks::<LANES>().0[four]);
        [axis(0), axis(1), axis(2)]
    }
}

/// Answers the points beyond the band, and lists the others. There are as many as `out` is long.
#[inline(always)]
fn collect<V: Lanes, C: Finder, A: Evaluate>(
    map: &VolumeMap,
    cells: &C,
    points: &[DVec3; BLOCK],
    out: &mut [A],
    near: &mut Near,
) {
    let mut hint = cells.hint();
    near.count = 0;
    let fours = points.as_chunks::<LANES>().0.iter().zip(out.chunks_mut(LANES));
    for (four, (points, out)) in fours.enumerate() {
        let located = locate::<V>(&map.grid, points);
        for (lane, (&point, out)) in points.iter().zip(out).enumerate() {
            if located.within >> lane & 1 == 0 {
                *out = beyond(map, point);
                continue;
            }
            let mut f = located.f(lane);
            match cells.place(located.cell(lane), &mut f, &mut hint) {
                Found::Band(place) => {
                    let n = near.count % BLOCK;
                    near.index[n] = (LANES * four + lane) as u32;
                    near.place[n] = place;
                    for axis in 0..3 {
                        near.f[axis][n] = f[axis];
                        near.points[axis][n] = point[axis];
                    }
                    near.count += 1;
                }
                Found::Solid => *out = A::deep_inside(map),
                Found::Fluid => *out = A::outside(map),
            }
        }
    }
}

/// Beyond the domain.
fn beyond<A: Evaluate>(map: &VolumeMap, point: DVec3) -> A {
    match map.exterior {
        Exterior::Solid if point.is_finite() => A::deep_inside(map),
        _ => A::outside(map),
    }
}

/// Cells of four points.
struct Located {
    /// Bit by bit, whether the point is in the domain; for the others the rest means nothing.
    within: u32,
    cell: [[u32; LANES]; 3],
    /// Place in the cell, 0 to 1 along each axis.
    f: [[f64; LANES]; 3],
}

/// As [`Grid::locate`], by fours.
#[inline(always)]
fn locate<V: Lanes>(grid: &Grid, points: &[DVec3; LANES]) -> Located {
    /// The sum of an integer and this has the integer in its low bits.
    const INTEGERS: f64 = (1u64 << 52) as f64;
    let mut within = u32::MAX;
    let mut f = [[0.0; LANES]; 3];
    let mut cell = [[0u32; LANES]; 3];
    for axis in 0..3 {
        let x = V::new([points[0][axis], points[1][axis], points[2][axis], points[3][axis]]);
        let n = f64::from(grid.resolution[axis]);
        let u = (x - V::splat(grid.origin[axis])) / V::splat(grid.cell_size[axis]) + V::splat(0.0);
        within &= u.within(V::splat(n));
        let first = u.floor().min(V::splat(n - 1.0));
        f[axis] = (u - first).array();
        let integers = (first + V::splat(INTEGERS)).array();
        for lane in 0..LANES {
            cell[axis][lane] = integers[lane].to_bits() as u32;
        }
    }
    Located { within, cell, f }
}

impl Located {
    #[inline(always)]
    fn cell(&self, lane: usize) -> UVec3 {
        UVec3::new(self.cell[0][lane], self.cell[1][lane], self.cell[2][lane])
    }

    #[inline(always)]
    fn f(&self, lane: usize) -> DVec3 {
        DVec3::new(self.f[0][lane], self.f[1][lane], self.f[2][lane])
    }
}

/// The differences of one cell.
struct Differences {
    place: Place,
    numbers: Shared,
}

impl Differences {
    fn none() -> Differences {
        Differences { place: Place::NONE, numbers: Shared([[[0.0; 4]; 4]; 4]) }
    }

    #[inline(always)]
    fn load<V: Lanes, S: Storage + ?Sized, C: Finder>(&mut self, asked: &Asked<S, C>, place: Place) {
        if self.place == place {
            return;
        }
        let starts = asked.cells.starts(place);
        for (cube, numbers) in self.numbers.0.iter_mut().enumerate() {
            let rows: Rows<V> = differences(rows(asked.fields, &starts, cube));
            for (row, numbers) in rows.into_iter().zip(numbers) {
                let [d, v, upper_d, upper_v] = row.array();
                *numbers = [d, v, upper_d - d, upper_v - v];
            }
        }
        self.place = place;
    }
}

/// Each of four points in a cell of its own.
struct Apart<V>([[Rows<V>; 4]; LANES]);

impl<V: Lanes> Apart<V> {
    /// All cells before any is needed: their memory is waited for at once.
    #[inline(always)]
    fn load<S: Storage + ?Sized, C: Finder>(asked: &Asked<S, C>, [a, b, c, d]: [Place; LANES]) -> Apart<V> {
        Apart([
            all_differences(asked, a),
            all_differences(asked, b),
            all_differences(asked, c),
            all_differences(asked, d),
        ])
    }
}

#[inline(always)]
fn all_differences<V: Lanes, S: Storage + ?Sized, C: Finder>(
    asked: &Asked<S, C>,
    place: Place,
) -> [Rows<V>; 4] {
    let (starts, fields) = (asked.cells.starts(place), asked.fields);
    [
        differences(rows(fields, &starts, 0)),
        differences(rows(fields, &starts, 1)),
        differences(rows(fields, &starts, 2)),
        differences(rows(fields, &starts, 3)),
    ]
}

impl<V: Lanes> Numbers<V> for Apart<V> {
    #[inline(always)]
    fn cube(&self, cube: usize) -> Cube<V> {
        let [a, b, c, d] = &self.0;
        let mut out = [[V::splat(0.0); 4]; 4];
        for (row, out) in out.iter_mut().enumerate() {
            let four = [a[cube][row], b[cube][row], c[cube][row], d[cube][row]];
            let [lower_d, lower_v, upper_d, upper_v] = V::transpose(four);
            *out = [lower_d, lower_v, upper_d - lower_d, upper_v - lower_v];
        }
        out
    }
}

/// The answer for one point.
#[inline(always)]
fn one<V: Lanes, S: Storage + ?Sized, C: Finder, A: Evaluate>(
    asked: &Asked<S, C>,
    point: DVec3,
    out: &mut A,
) {
    let (map, cells) = (asked.map, asked.cells);
    let Some((cell, mut f)) = map.grid.cell_and_place(point) else {
        *out = beyond(map, point);
        return;
    };
    match cells.place(cell, &mut f, &mut cells.hint()) {
        Found::Band(place) => {
            let mut shared = Differences::none();
            shared.load::<V, S, C>(asked, place);
            let (point, f) = (in_all_lanes(point), in_all_lanes(f));
            let frame = cells.frame::<V>(map.per_cell, &[place; LANES], &f);
            let evaluated = Evaluated::new(&shared.numbers, point, f, frame);
            A::near(&evaluated, &[0], std::slice::from_mut(out));
        }
        Found::Solid => *out = A::deep_inside(map),
        Found::Fluid => *out = A::outside(map),
    }
}

#[inline(always)]
fn in_all_lanes<V: Lanes>(v: DVec3) -> [V; 3] {
    [V::splat(v.x), V::splat(v.y), V::splat(v.z)]
}

#[cfg(test)]
#[path = "../tests/analytic/mod.rs"]
mod analytic;

#[cfg(test)]
mod tests {
    use super::analytic::{Random, adaptive_ball, asset, single, with_density};
    use super::*;
    use volmap_formats::asset::{CellRun, GridSpec};

    /// One copy for each type of answer: to compile them takes long.
    #[inline(never)]
    fn plainly<A: Evaluate>(map: &VolumeMap, points: &[DVec3], out: &mut [A]) {
        All { map, points, out }.run::<Plain>();
    }

    #[test]
    fn wide_vectors_have_the_bits_of_plain_ones() {
        let grid = GridSpec { origin: [-1.0, -2.0, 0.5], cell_size: [0.3, 0.2, 0.25], resolution: [5, 4, 3] };
        let band = (0..12).map(|row| CellRun { i: row % 2, j: row % 4, k: row / 4, len: 3 }).collect();
        let wave = |x: DVec3| (x.x * 5.0 + x.y * 7.0).sin() + x.z * x.z;
        let double = with_density(asset(grid, [band, Vec::new()], wave, |x| 0.01 * wave(x)), 300.0);
        for asset in [single(&double), double, adaptive_ball(3), single(&adaptive_ball(3))] {
            let map = VolumeMap::from_asset(&asset).unwrap();
            let mut random = Random(9);
            let (low, high) = (map.grid.origin, map.grid.max_corner());
            let mut points: Vec<DVec3> = (0..4_003).map(|_| random.point(low - 0.1, high + 0.1)).collect();
            points.sort_by_key(|&x| map.grid.locate(x).map(|at| (at.cell.z, at.cell.y, at.cell.x)));
            points.extend((0..1_000).map(|_| random.point(low, high)));
            let (mut wide, mut plain) =
                (vec![Sample::Outside; points.len()], vec![Sample::Outside; points.len()]);
            answer_all(&map, &points, &mut wide);
            plainly(&map, &points, &mut plain);
            let near = wide.iter().filter(|sample| sample.near().is_some()).count();
            assert!((1_000..points.len()).contains(&near), "{near}");
            let bits = |samples: &[Sample]| format!("{samples:?}");
            assert_eq!(bits(&wide), bits(&plain));
            let (mut wide, mut others) = (vec![None::<MapDensity>; points.len()], vec![None; points.len()]);
            answer_all(&map, &points, &mut wide);
            plainly(&map, &points, &mut others);
            assert_eq!(format!("{wide:?}"), format!("{others:?}"));
            let mut sloped = vec![Sample::<SurfaceWithGradient>::Outside; points.len()];
            let mut others = sloped.clone();
            answer_all(&map, &points, &mut sloped);
            plainly(&map, &points, &mut others);
            assert_eq!(format!("{sloped:?}"), format!("{others:?}"));
            assert!(sloped.iter().map(|near| near.map(|near| near.surface)).eq(plain.iter().copied()));
            for (&point, &expected) in points.iter().zip(&plain) {
                let mut alone = Sample::Outside;
                plainly(&map, &[point], std::slice::from_mut(&mut alone));
                assert_eq!(alone, expected);
            }
        }
    }
}
