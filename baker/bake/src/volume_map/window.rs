//! Rows of cells laid side by side: what gamma* is in each, and the polynomials of s = 1 - Phi / r.

use super::dispatch::{self, Kernel};
use super::kernel::{self, Content, LANES, Window};
use crate::sdf::field::DistanceField;
use glam::UVec3;
use rayon::prelude::*;
use std::ops::Range;
use volmap_formats::asset::Exterior;
use volmap_runtime::layout::serendipity::NODES;
use volmap_runtime::layout::{Cell, NodeNumbers};

/// Rows of cells of a field.
pub struct FieldWindows<'a> {
    /// Phi.
    pub field: &'a DistanceField,
    /// By number of the stored cells.
    pub contents: &'a [u8],
    /// 1 / r, in 1/m.
    pub inverse_radius: f64,
    /// Cells of the field's grid before that of the nodes.
    pub shift: UVec3,
}

/// Cells that are classified together.
const CHUNK: usize = 64;

/// What gamma* is in every stored cell of the field, by the cell's number.
pub fn contents(field: &DistanceField, radius: f64) -> Vec<u8> {
    let cells: Vec<NodeNumbers> = field.cells.stored().collect();
    let mut out = vec![Content::Mixed as u8; cells.len()];
    let chunks = out.par_chunks_mut(CHUNK).zip(cells.par_chunks(CHUNK));
    let kernel = dispatch::kernel();
    chunks.for_each_init(Window::<CHUNK>::default, |window, (out, cells)| {
        window.width = cells.len();
        for (column, numbers) in cells.iter().enumerate() {
            window.set_cells(column..column + 1, numbers, &field.values, 1.0 / radius);
        }
        (kernel.to_monomials)(window);
        (kernel.classify)(window);
        out.copy_from_slice(&window.contents[..cells.len()]);
    });
    out
}

/// The polynomial of s in one cell.
pub fn monomials_of(numbers: &NodeNumbers, phi: &[f64], inverse_radius: f64) -> [f64; NODES] {
    let mut window = Window::<LANES> { width: 1, ..Window::default() };
    window.set_cells(0..1, numbers, phi, inverse_radius);
    kernel::to_monomials(&mut window);
    window.values.each_ref().map(|cells| cells[0])
}

/// The same from the values of Phi at a cell's nodes.
pub fn monomials_of_nodes(phi: &[f64; NODES], inverse_radius: f64) -> [f64; NODES] {
    let mut window = Window::<LANES> { width: 1, ..Window::default() };
    for (own, phi) in window.values.iter_mut().zip(phi) {
        own[0] = 1.0 - phi * inverse_radius;
    }
    kernel::to_monomials(&mut window);
    window.values.each_ref().map(|cells| cells[0])
}

impl FieldWindows<'_> {
    /// Sets the contents of `width` cells from `first` along x, in row (y, z); cells of the nodes' lattice. Returns
    /// what all of them hold, if that is one thing.
    pub fn contents<const S: usize>(
        &self,
        first: i64,
        row: [i64; 2],
        width: usize,
        window: &mut Window<S>,
    ) -> Option<Content> {
        window.width = width;
        let own = &mut window.contents[..width];
        own.fill(self.elsewhere(row));
        self.runs(first, row, width, |columns, cell| {
            let own = &mut own[columns];
            match cell {
                Cell::Band(numbers) => own.copy_from_slice(&self.contents[numbers.cell()..][..own.len()]),
                Cell::Solid => own.fill(Content::One as u8),
                Cell::Fluid => own.fill(Content::Zero as u8),
            }
        });
        self.fill_outside(first, row, own);
        let kind = own[0];
        match own.iter().all(|content| *content == kind) {
            true if kind == Content::Zero as u8 => Some(Content::Zero),
            true if kind == Content::One as u8 => Some(Content::One),
            _ => None,
        }
    }

    /// Sets the polynomials of a window whose contents are set.
    pub fn polynomials<const S: usize>(
        &self,
        first: i64,
        row: [i64; 2],
        window: &mut Window<S>,
        kernel: &Kernel<S>,
    ) {
        let mut free = 0;
        let width = window.width;
        self.runs(first, row, width, |columns, cell| {
            if let Cell::Band(numbers) = cell {
                window.set_uniform(free..columns.start);
                free = columns.end;
                window.set_cells(columns, &numbers, &self.field.values, self.inverse_radius);
            }
        });
        window.set_uniform(free..width);
        (kernel.to_monomials)(window);
    }

    /// What cells hold that no run mentions: fluid in the grid, and beyond it what the exterior is.
    fn elsewhere(&self, row: [i64; 2]) -> u8 {
        let inside = self.row_in_grid(row).is_some();
        match self.field.exterior {
            Exterior::Solid if !inside => Content::One as u8,
            _ => Content::Zero as u8,
        }
    }

    /// Columns before and behind the grid.
    fn fill_outside(&self, first: i64, row: [i64; 2], contents: &mut [u8]) {
        if self.field.exterior == Exterior::Fluid || self.row_in_grid(row).is_none() {
            return;
        }
        let (begin, end) = (-self.from(first), i64::from(self.field.grid.resolution.x) - self.from(first));
        let columns = contents.len() as i64;
        let solid = Content::One as u8;
        contents[..begin.clamp(0, columns) as usize].fill(solid);
        contents[end.clamp(0, columns) as usize..].fill(solid);
    }

    fn from(&self, first: i64) -> i64 {
        first + i64::from(self.shift.x)
    }

    fn row_in_grid(&self, [y, z]: [i64; 2]) -> Option<[u32; 2]> {
        let (y, z) = (y + i64::from(self.shift.y), z + i64::from(self.shift.z));
        let n = self.field.grid.resolution;
        let inside = (0..i64::from(n.y)).contains(&y) && (0..i64::from(n.z)).contains(&z);
        inside.then_some([y as u32, z as u32])
    }

    /// Calls `visit` for the runs of a row that lie in the window, with their columns and the first cell's content.
    fn runs(&self, first: i64, row: [i64; 2], width: usize, mut visit: impl FnMut(Range<usize>, Cell)) {
        let Some([y, z]) = self.row_in_grid(row) else { return };
        let from = self.from(first);
        let end = from + width as i64;
        for (cells, cell) in self.field.cells.runs_from(from.max(0) as u32, y, z) {
            if i64::from(cells.start) >= end {
                break;
            }
            let begin = i64::from(cells.start).max(from);
            let stop = i64::from(cells.end).min(end);
            let cell = match cell {
                Cell::Band(numbers) => Cell::Band(numbers.along((begin - i64::from(cells.start)) as u32)),
                other => other,
            };
            visit((begin - from) as usize..(stop - from) as usize, cell);
        }
    }
}

impl<const S: usize> Window<S> {
    /// Sets s at the nodes of consecutive cells of a run, of which `numbers` is the first.
    fn set_cells(&mut self, columns: Range<usize>, numbers: &NodeNumbers, phi: &[f64], inverse_radius: f64) {
        for (own, (number, step)) in self.values.iter_mut().zip(numbers.places()) {
            let own = &mut own[columns.clone()];
            let phi = &phi[number as usize..];
            // Steps that the compiler knows.
            match step {
                1 => own.iter_mut().zip(phi).for_each(|(s, phi)| *s = 1.0 - phi * inverse_radius),
                _ => own
                    .iter_mut()
                    .zip(phi.iter().step_by(2))
                    .for_each(|(s, phi)| *s = 1.0 - phi * inverse_radius),
            }
        }
    }

    /// Sets s at the nodes of cells that are not stored: 0 in the fluid, 1 in the solid.
    fn set_uniform(&mut self, columns: Range<usize>) {
        if columns.is_empty() {
            return;
        }
        for own in self.values.iter_mut() {
            for column in columns.clone() {
                own[column] = if self.contents[column] == Content::One as u8 { 1.0 } else { 0.0 };
            }
        }
    }
}
