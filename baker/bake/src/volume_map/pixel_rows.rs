//! Eq. 12 of Bender et al. 2020 at the pixels of a slice (its Fig. 6), on a discretised distance:
//!
//! ```text
//! V(x) = integral of gamma*(Phi(x + xi)) over |xi| <= r  =  sum over q of w_q gamma*(Phi(x + r xi_q))
//! ```
//! Rows of pixels run along an axis, here called x, and all have their pixels at the same places on it. So where the
//! points of a rule on one line along x fall, in which cell and at which place in it, is the same for all rows and
//! all lines of the same points: it is found once. On such a line s = 1 - Phi / r is a cubic in each cell, found
//! once for all pixels of a row. [`LANES`] neighbouring rows are worked on together.

use super::anywhere::{Integrator, LineRule, floor};
use super::cell_cut::{BlockCell, surface_at};
use super::dispatch;
use super::kernel::{Content, LANES, Lanes, from_powers};
use super::pixel_line::{LineOnRows, Profile, Run};
use super::quadrature::Point;
use crate::watch::{Cancelled, Work};
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use std::array::from_fn;
use std::collections::HashMap;
use volmap_runtime::layout::serendipity::NODES;
use volmap_runtime::layout::serendipity::monomials::POWERS;

/// Pixels on a plane.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// Axes of space along a row, from row to row and across the plane: 0, 1 and 2 in any order.
    pub axes: [usize; 3],
    /// Places of a row's pixels on the first axis, metres.
    pub along: Vec<f64>,
    /// Places of the rows on the second axis, metres.
    pub across: Vec<f64>,
    /// Place of the plane on the third axis, metres.
    pub plane: f64,
    /// Row by row, which pixels are of interest.
    pub wanted: Vec<bool>,
}

/// Boundary volume at the wanted pixels by a rule, m^3, row by row; elsewhere 0. Each pixel counts as work.
///
/// # Errors
/// [`Cancelled`].
pub fn volumes(
    integrator: &Integrator,
    rule: &[Point],
    pixels: &Pixels,
    work: &Work,
) -> Result<Vec<f64>, Cancelled> {
    let count = pixels.along.len();
    let mut out = vec![0.0; count * pixels.across.len()];
    if out.is_empty() {
        return Ok(out);
    }
    let plan = Plan::new(integrator, rule, pixels);
    let groups = out.par_chunks_mut(LANES * count).enumerate();
    groups.for_each_init(Scratch::default, |scratch, (number, out)| {
        if !work.is_cancelled() {
            plan.rows(number * LANES, scratch, out);
            work.add(out.len() as u64);
        }
    });
    work.check()?;
    Ok(out)
}

/// All that the rows share. Axes are the pixels' own, lengths are in cells of the grid.
struct Plan<'a> {
    integrator: &'a Integrator<'a>,
    pixels: &'a Pixels,
    along: Vec<f64>,
    across: Vec<f64>,
    plane: f64,
    reach: DVec3,
    resolution: IVec3,
    /// The monomials of a cell with its axes exchanged, as places in those that it has.
    order: [usize; NODES],
    rule: LineRule,
    /// For each line of the rule, its profile.
    profile_of: Vec<usize>,
    profiles: Vec<Profile>,
    /// Cells that a row of pixels may need: the first and how many.
    first: i32,
    count: usize,
    kernel: fn(&LineOnRows, &mut [[Lanes; 2]]),
}

/// What a thread reuses from rows to rows.
#[derive(Default)]
struct Scratch {
    /// Of the pixels along, those that one of the rows wants.
    wanted: Vec<bool>,
    cells: Cells,
    sums: Vec<[Lanes; 2]>,
}

/// The cells that some rows need; the others are void.
#[derive(Default)]
struct Cells {
    low: IVec3,
    size: IVec3,
    /// x fastest.
    cells: Vec<BlockCell>,
    monomials: Vec<[f64; NODES]>,
    /// Per layer of constant z, where its monomials begin, and the end of all.
    layers: Vec<usize>,
    /// The monomials of one layer, cut at some z.
    surfaces: Vec<[f64; 12]>,
}

impl<'a> Plan<'a> {
    fn new(integrator: &'a Integrator, rule: &[Point], pixels: &'a Pixels) -> Plan<'a> {
        let grid = &integrator.field.grid;
        let axes = pixels.axes;
        let place = |axis: usize, at: f64| (at - grid.origin[axes[axis]]) / grid.cell_size[axes[axis]];
        let turned = rule.iter().map(|point| Point {
            position: DVec3::from(axes.map(|axis| point.position[axis])),
            weight: point.weight,
        });
        let mut plan = Plan {
            integrator,
            pixels,
            along: pixels.along.iter().map(|at| place(0, *at)).collect(),
            across: pixels.across.iter().map(|at| place(1, *at)).collect(),
            plane: place(2, pixels.plane),
            reach: integrator.radius / DVec3::from(axes.map(|axis| grid.cell_size[axis])),
            resolution: IVec3::from(axes.map(|axis| grid.resolution[axis] as i32)),
            order: order(axes),
            rule: LineRule::new(turned.collect()),
            profile_of: Vec::new(),
            profiles: Vec::new(),
            first: 0,
            count: 0,
            kernel: dispatch::pixel_rows_kernel(),
        };
        let cells = || plan.along.iter().flat_map(|at| plan.interval(0, *at));
        let (first, last) = (cells().min().unwrap_or(0), cells().max().unwrap_or(0));
        (plan.first, plan.count) = (first, (last - first) as usize + 1);
        plan.find_profiles();
        plan
    }

    /// The cell of a place on an axis. What lies beyond the grid is all alike: one cell stands for it.
    fn cell(&self, axis: usize, at: f64) -> i32 {
        (floor(at) as i32).clamp(-1, self.resolution[axis])
    }

    /// First and last cell on an axis that the ball around a place reaches.
    fn interval(&self, axis: usize, at: f64) -> [i32; 2] {
        let reach = self.reach[axis];
        [self.cell(axis, at - reach), self.cell(axis, at + reach)]
    }

    fn find_profiles(&mut self) {
        let mut known = HashMap::new();
        for line in &self.rule.lines {
            let x = &self.rule.x[line.first..line.end];
            let bits: Vec<u64> = x.iter().map(|x| x.to_bits()).collect();
            let number = *known.entry(bits).or_insert(self.profiles.len());
            if number == self.profiles.len() {
                let profile = self.profile(x);
                self.profiles.push(profile);
            }
            self.profile_of.push(number);
        }
    }

    fn profile(&self, x: &[f64]) -> Profile {
        let mut runs: Vec<(usize, Run)> = Vec::new();
        for (pixel, at) in self.along.iter().enumerate() {
            let pixel = pixel as u32;
            for (point, x) in x.iter().enumerate() {
                let column = (self.cell(0, at + self.reach.x * x) - self.first) as usize;
                let end = point as u32 + 1;
                match runs.last_mut() {
                    Some((own, run)) if (*own, run.pixel) == (column, pixel) => run.end = end,
                    _ => runs.push((column, Run { pixel, first: end - 1, end })),
                }
            }
        }
        runs.sort_by_key(|(column, _)| *column);
        let starts = (0..=self.count).map(|column| runs.partition_point(|(own, _)| *own < column));
        Profile {
            x: x.iter().map(|x| 2.0 * self.reach.x * x).collect(),
            starts: starts.collect(),
            runs: runs.into_iter().map(|(_, run)| run).collect(),
        }
    }

    /// Volumes of the rows from one on, as many as there is room for.
    fn rows(&self, first: usize, scratch: &mut Scratch, out: &mut [f64]) {
        let count = self.along.len();
        let wanted = &self.pixels.wanted[first * count..][..out.len()];
        scratch.wanted.clear();
        scratch
            .wanted
            .extend((0..count).map(|pixel| wanted.iter().skip(pixel).step_by(count).any(|own| *own)));
        if scratch.wanted.iter().all(|wanted| !wanted) {
            return;
        }
        // Lanes without a row of their own do what the last does.
        let rows = from_fn(|lane| self.across[first + lane.min(out.len() / count - 1)]);
        self.look_up(&rows, scratch);
        scratch.sums.clear();
        scratch.sums.resize(count, Default::default());
        self.sum(&rows, scratch);
        let cube = self.integrator.radius.powi(3);
        for (pixel, sums) in scratch.sums.iter().enumerate() {
            let Lanes(integrals) = from_powers(*sums);
            for (lane, integral) in integrals.into_iter().take(out.len() / count).enumerate() {
                let at = lane * count + pixel;
                out[at] = if wanted[at] { cube * integral } else { 0.0 };
            }
        }
    }

    /// Looks the cells up that the wanted pixels of the rows reach.
    fn look_up(&self, rows: &[f64; LANES], scratch: &mut Scratch) {
        let cells = &mut scratch.cells;
        let [bottom, top] = self.interval(2, self.plane);
        let lanes = rows.map(|at| self.interval(1, at));
        let (low, high) =
            (lanes.map(|own| own[0]).into_iter().min(), lanes.map(|own| own[1]).into_iter().max());
        cells.low = IVec3::new(self.first, low.unwrap_or(0), bottom);
        cells.size = IVec3::new(self.count as i32, high.unwrap_or(0) - cells.low.y + 1, top - bottom + 1);
        let mut columns = vec![false; self.count];
        for (at, _) in self.along.iter().zip(&scratch.wanted).filter(|(_, wanted)| **wanted) {
            let [from, to] = self.interval(0, *at).map(|cell| (cell - self.first) as usize);
            columns[from..=to].fill(true);
        }
        let void = BlockCell { content: Content::Zero, number: 0 };
        cells.cells.clear();
        cells.monomials.clear();
        cells.layers.clear();
        for z in bottom..=top {
            cells.layers.push(cells.monomials.len());
            for y in (0..cells.size.y).map(|y| cells.low.y + y) {
                let needed = lanes.iter().any(|[from, to]| (from..=to).contains(&&y));
                for (x, column) in (self.first..).zip(&columns) {
                    let own = match needed && *column {
                        true => self.look_up_cell(IVec3::new(x, y, z), &mut cells.monomials),
                        false => void,
                    };
                    cells.cells.push(own);
                }
            }
        }
        cells.layers.push(cells.monomials.len());
    }

    fn look_up_cell(&self, at: IVec3, monomials: &mut Vec<[f64; NODES]>) -> BlockCell {
        let mut cell = IVec3::ZERO;
        for (own, axis) in self.pixels.axes.into_iter().enumerate() {
            cell[axis] = at[own];
        }
        let before = monomials.len();
        let found = self.integrator.block_cell(cell, monomials);
        for own in &mut monomials[before..] {
            *own = self.order.map(|from| own[from]);
        }
        found
    }

    /// Adds the integrals over all lines of the rule.
    fn sum(&self, rows: &[f64; LANES], Scratch { wanted, cells, sums }: &mut Scratch) {
        let lines: Vec<_> = self.rule.lines.iter().zip(&self.profile_of).collect();
        for plane in lines.chunk_by(|(a, _), (b, _)| a.z == b.z) {
            let z = self.plane + self.reach.z * plane[0].0.z;
            let layer = (self.cell(2, z) - cells.low.z) as usize;
            cells.cut(layer, 2.0 * (z - floor(z)) - 1.0);
            for (line, profile) in plane {
                let y = rows.map(|at| at + self.reach.y * line.y);
                let row = |y: f64| cells.row(layer, (self.cell(1, y) - cells.low.y) as usize);
                let on_rows = LineOnRows {
                    rows: y.map(row),
                    y: y.map(|y| 2.0 * (y - floor(y)) - 1.0),
                    surfaces: &cells.surfaces,
                    first_surface: cells.layers[layer],
                    profile: &self.profiles[**profile],
                    weight: &self.rule.weight[line.first..line.end],
                    summed: &self.rule.summed[line.first..=line.end],
                    along: &self.along,
                    first: f64::from(self.first),
                    wanted,
                };
                (self.kernel)(&on_rows, sums);
            }
        }
    }
}

/// For the monomials of a cell with its axes exchanged, which of the cell's own they are.
fn order(axes: [usize; 3]) -> [usize; NODES] {
    from_fn(|at| {
        let turned = |own: &[u8; 3]| axes.map(|axis| own[axis]) == POWERS[at];
        POWERS.iter().position(turned).unwrap_or_else(|| unreachable!("the space is symmetric"))
    })
}

impl Cells {
    fn row(&self, layer: usize, row: usize) -> &[BlockCell] {
        let width = self.size.x as usize;
        &self.cells[(layer * self.size.y as usize + row) * width..][..width]
    }

    /// Cuts a layer at z, in [-1, 1].
    fn cut(&mut self, layer: usize, z: f64) {
        let own = &self.monomials[self.layers[layer]..self.layers[layer + 1]];
        self.surfaces.clear();
        self.surfaces.extend(own.iter().map(|monomials| surface_at(monomials, z)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sdf::band::find_band;
    use crate::sdf::field::DistanceField;
    use crate::volume_map::oracle;
    use crate::volume_map::quadrature::Rule;
    use glam::UVec3;
    use volmap_formats::asset::Exterior;
    use volmap_runtime::Grid;
    use volmap_runtime::layout::Nodes;

    /// Rows along each axis, cells of three lengths, balls smaller and larger than a cell, some of them cut by the
    /// domain; rules that aren't alike along the axes; both exteriors; pixels beyond the domain, and unwanted ones.
    #[test]
    fn volumes_are_those_of_the_oracle() {
        let grid = Grid {
            origin: DVec3::new(-1.3, -0.9, -1.0),
            cell_size: DVec3::new(0.2, 0.25, 0.3),
            resolution: UVec3::new(13, 6, 7),
        };
        let mut compared = 0;
        for (exterior, invert) in [(Exterior::Fluid, 1.0), (Exterior::Solid, -1.0)] {
            let phi = |p: DVec3| invert * ((p - DVec3::new(0.1, -0.05, 0.02)).length() - 0.8);
            let cells = find_band(&grid, 0.5, &phi, &Work::default()).unwrap();
            let nodes = Nodes::new(grid.resolution, &cells.band).unwrap();
            let field = DistanceField::sample(grid, &cells, &nodes, exterior, &phi);
            for (radius, rule) in
                [(0.03, Rule::Chord(6)), (0.25, Rule::GaussLegendre(10)), (0.7, Rule::Ball(4))]
            {
                for axes in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
                    compared += compare(&field, radius, rule, axes);
                }
            }
        }
        assert!(compared > 5000, "{compared}");
    }

    fn compare(field: &DistanceField, radius: f64, rule: Rule, axes: [usize; 3]) -> usize {
        let along: Vec<f64> = (0..23).map(|i| -1.5 + 0.131 * f64::from(i)).collect();
        // Not a multiple of the lanes.
        let across: Vec<f64> = (0..10).map(|j| -1.2 + 0.27 * f64::from(j)).collect();
        let wanted: Vec<bool> = (0..along.len() * across.len()).map(|at| at % 7 != 3).collect();
        let pixels = Pixels { axes, along, across, plane: 0.17, wanted };
        let integrator = Integrator::new(field, radius);
        let found = volumes(&integrator, &rule.points(), &pixels, &Work::default()).unwrap();
        for (at, volume) in found.iter().enumerate() {
            let mut x = DVec3::ZERO;
            x[axes[0]] = pixels.along[at % pixels.along.len()];
            x[axes[1]] = pixels.across[at / pixels.along.len()];
            x[axes[2]] = pixels.plane;
            let expected = match pixels.wanted[at] {
                true => oracle::volume(field, &rule.points(), radius, x),
                false => 0.0,
            };
            assert!((volume - expected).abs() < 1e-12, "{rule}, {axes:?} at {x}: {volume}, {expected}");
        }
        pixels.wanted.iter().filter(|wanted| **wanted).count()
    }
}
