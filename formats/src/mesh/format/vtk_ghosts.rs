//! Cells that VTK doesn't show: the arrays `vtkGhostType` of cells and points ("vtkDataSetAttributes.h", CellGhostTypes
//! and PointGhostTypes), and `vtkGhostLevels` of versions before 6.3.

use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::text::thousands;

const DUPLICATE_CELL: u8 = 1;
const REFINED_CELL: u8 = 8;
const HIDDEN_CELL: u8 = 32;
const HIDDEN_POINT: u8 = 2;

/// The arrays of one grid or piece; empty: there is none.
#[derive(Default)]
pub struct Ghosts {
    cells: Vec<u8>,
    points: Vec<u8>,
}

/// How many cells were left out.
#[derive(Default)]
pub struct LeftOut {
    duplicate: usize,
    hidden: usize,
}

/// Whether an array tells ghosts.
pub fn is_ghost(name: &str) -> bool {
    matches!(name, "vtkGhostType" | "vtkGhostLevels")
}

impl Ghosts {
    /// Takes an array of the cells or the points.
    pub fn add(&mut self, of_cells: bool, name: &str, values: &[f64]) {
        // A level above 0 belongs to another piece.
        let kind = |&value: &f64| match name {
            "vtkGhostLevels" => u8::from(value > 0.0),
            _ => value as u8,
        };
        let types = values.iter().map(kind).collect();
        match of_cells {
            true => self.cells = types,
            // Points of other pieces are drawn.
            false if name == "vtkGhostLevels" => {}
            false => self.points = types,
        }
    }

    /// An error, if the arrays aren't as long as they should be.
    pub fn check(
        &self,
        raw: &RawMesh,
        cells: usize,
        points: usize,
        at: &dyn Fn() -> String,
    ) -> Result<(), MeshError> {
        for (values, count, what) in [(&self.cells, cells, "cells"), (&self.points, points, "points")] {
            if !values.is_empty() && values.len() != count {
                return Err(raw.bad(
                    at(),
                    format!(
                        "`vtkGhostType` has {} values for {count} {what}; the file is damaged: export it again",
                        values.len()
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Whether a cell is left out. Its corners are numbers of this piece's points; others are left to later checks.
    pub fn leave_out(&self, cell: usize, corners: impl Iterator<Item = usize>, out: &mut LeftOut) -> bool {
        let kind = self.cells.get(cell).copied().unwrap_or(0);
        let is_hidden = |k: usize| self.points.get(k).is_some_and(|point| point & HIDDEN_POINT != 0);
        if kind & DUPLICATE_CELL != 0 {
            out.duplicate += 1;
            return true;
        }
        let hidden = kind & (HIDDEN_CELL | REFINED_CELL) != 0
            || (!self.points.is_empty() && corners.into_iter().any(is_hidden));
        out.hidden += usize::from(hidden);
        hidden
    }
}

impl LeftOut {
    /// What to say of them.
    pub fn note(&self) -> Option<String> {
        let cells = |n: usize, what: &str| {
            let plural = if n == 1 { "" } else { "s" };
            (n > 0).then(|| format!("{} {what} cell{plural}", thousands(n as u64)))
        };
        let parts = [cells(self.hidden, "hidden"), cells(self.duplicate, "duplicate")];
        let parts = parts.into_iter().flatten().collect::<Vec<_>>().join(" and ");
        (!parts.is_empty()).then(|| format!("left out by `vtkGhostType`: {parts}"))
    }
}
