//! The inner loop of [`super::pixel_rows`]: a line of the rule on the pixels of [`LANES`] rows.

use super::cell_cut::{BlockCell, cubic_on_line};
use super::kernel::{Content, LANES, Lanes, Line};

/// The points of lines that have them at the same places.
pub(super) struct Profile {
    /// Places, in half cells from the pixel.
    pub(super) x: Vec<f64>,
    /// Cell by cell, the points that fall into it.
    pub(super) runs: Vec<Run>,
    /// Per cell of a row, where its runs begin, and the end of all.
    pub(super) starts: Vec<usize>,
}

/// Points of a line that fall into one cell.
#[derive(Clone, Copy)]
pub(super) struct Run {
    pub(super) pixel: u32,
    pub(super) first: u32,
    pub(super) end: u32,
}

/// A line of the rule, put on the pixels of [`LANES`] rows.
pub struct LineOnRows<'a> {
    /// The cells that it runs through.
    pub(super) rows: [&'a [BlockCell]; LANES],
    /// Where in them, in [-1, 1].
    pub(super) y: [f64; LANES],
    /// Their polynomials at this z, and the number of the first.
    pub(super) surfaces: &'a [[f64; 12]],
    pub(super) first_surface: usize,
    pub(super) profile: &'a Profile,
    /// Of its points, and the sums of those before each.
    pub(super) weight: &'a [f64],
    pub(super) summed: &'a [f64],
    /// Of all rows: where the pixels are, and the first cell.
    pub(super) along: &'a [f64],
    pub(super) first: f64,
    pub(super) wanted: &'a [bool],
}

/// Adds a line's weighted a^3 and (a - 1/2)_+^3 (see `kernel`) to the sums of the pixels.
#[inline(always)]
pub fn accumulate(line: &LineOnRows, sums: &mut [[Lanes; 2]]) {
    let profile = line.profile;
    for column in 0..profile.starts.len() - 1 {
        let runs = &profile.runs[profile.starts[column]..profile.starts[column + 1]];
        let (mut zeros, mut ones) = (0, 0);
        for row in line.rows {
            zeros += (row[column].content == Content::Zero) as usize;
            ones += (row[column].content == Content::One) as usize;
        }
        if zeros == LANES || runs.is_empty() {
            continue;
        }
        if ones == LANES {
            add_full(line, runs, sums);
        } else {
            add_mixed(line, column, runs, sums);
        }
    }
}

/// gamma* = 1 = 2 a^3 - 8 (a - 1/2)^3, which 1/2 and 0 give as well.
#[inline(always)]
fn add_full(line: &LineOnRows, runs: &[Run], sums: &mut [[Lanes; 2]]) {
    for run in runs {
        let half = 0.5 * (line.summed[run.end as usize] - line.summed[run.first as usize]);
        let [outer, _] = &mut sums[run.pixel as usize];
        for lane in 0..LANES {
            outer.0[lane] += half;
        }
    }
}

#[inline(always)]
fn add_mixed(line: &LineOnRows, column: usize, runs: &[Run], sums: &mut [[Lanes; 2]]) {
    let cubic = cubic(line, column);
    let cell = line.first + column as f64;
    for run in runs {
        let pixel = run.pixel as usize;
        if !line.wanted[pixel] {
            continue;
        }
        let offset = 2.0 * (line.along[pixel] - cell) - 1.0;
        let (first, end) = (run.first as usize, run.end as usize);
        let mut own = sums[pixel];
        for (x, weight) in line.profile.x[first..end].iter().zip(&line.weight[first..end]) {
            cubic.add(offset + x, *weight, &mut own);
        }
        sums[pixel] = own;
    }
}

/// s on the line in a cell of each row.
#[inline(always)]
fn cubic(line: &LineOnRows, column: usize) -> Line {
    let mut out = Line::default();
    for lane in 0..LANES {
        let cell = line.rows[lane][column];
        let cubic = match cell.content {
            Content::Zero => [0.0; 4],
            Content::One => [1.0, 0.0, 0.0, 0.0],
            Content::Mixed => {
                cubic_on_line(&line.surfaces[cell.number as usize - line.first_surface], line.y[lane])
            }
        };
        for (power, coefficient) in out.0.iter_mut().zip(cubic) {
            power.0[lane] = coefficient;
        }
    }
    out
}
