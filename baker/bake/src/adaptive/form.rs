//! How the volume is stored: as it is, or as its difference from a flat wall's. Which is better is measured: where walls
//! are flat or smooth, cells can be larger by difference; on grids, rocks and edges they can't.

use super::cells::{CellTree, Judge};
use super::known::Known;
use crate::error::Error;
use crate::plan::Plan;
use crate::sdf::SignedDistance;
use volmap_runtime::layout::FlatWall;

/// How the volume is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// As it is.
    Plain,
    /// As its difference from a flat wall's.
    Difference,
}

/// How many times more cells must miss plainly before the difference is stored, for which queries do more.
const CLEARLY: f64 = 1.4;

impl Form {
    /// The part of a flat wall's volume that isn't stored: w.
    pub fn weight(self) -> u32 {
        u32::from(self == Form::Difference)
    }

    /// What isn't stored of the volume where Phi is this: w V_plane(Phi), m^3.
    pub fn of_wall(self, wall: &FlatWall, phi: f64) -> f64 {
        match self {
            Form::Plain => 0.0,
            Form::Difference => wall.volume(phi),
        }
    }
}

impl<D: SignedDistance> Judge<'_, D> {
    /// Chooses the form in which fewer cells miss.
    ///
    /// # Errors
    /// As [`Judge::settle`].
    pub fn choose(&mut self, tree: &mut CellTree, known: &mut Known, plan: &Plan) -> Result<(), Error> {
        self.balance(tree, known)?;
        let mut missed = |form: &'static [Form]| {
            self.forms = form;
            self.missed(tree, known, plan)
        };
        let (plain, difference) = (missed(&[Form::Plain])?, missed(&[Form::Difference])?);
        if plain as f64 <= CLEARLY * difference as f64 {
            self.forms = &[Form::Plain];
        }
        Ok(())
    }

    /// How many cells miss in place, of the map or of a sample of it.
    fn missed(&self, tree: &CellTree, known: &mut Known, plan: &Plan) -> Result<usize, Error> {
        let samples = tree.samples(self.lattice.grid().resolution);
        let numbered = self.numbered(tree, samples.as_ref(), known, plan)?;
        let volume = self.fitted(&numbered, known);
        known.fitted.clear();
        Ok(self.failing(&numbered, &volume, known).len())
    }
}
