//! Which form of the volume is better is measured: where walls are flat or smooth, cells can be larger by difference; on
//! grids, rocks and edges they can't.

use super::cells::{CellTree, Judge};
use super::form::Form;
use super::known::Known;
use super::region::Region;
use crate::error::Error;
use crate::plan::Plan;
use crate::sdf::SignedDistance;

/// How many times more cells must miss plainly before the difference is stored, for which queries do more.
const CLEARLY: f64 = 1.4;

impl<D: SignedDistance> Judge<'_, D> {
    /// Chooses the form in which fewer cells miss.
    ///
    /// # Errors
    /// As [`Judge::settle`].
    pub fn choose(&mut self, tree: &mut CellTree, known: &mut Known, plan: &Plan) -> Result<(), Error> {
        self.balance(tree, known)?;
        let samples = tree.samples(self.lattice.grid().resolution);
        let mut missed = |form: &'static [Form]| {
            self.forms = form;
            self.missed(tree, samples.as_ref(), known, plan)
        };
        let (plain, difference) = (missed(&[Form::Plain])?, missed(&[Form::Difference])?);
        if plain as f64 <= CLEARLY * difference as f64 {
            self.forms = &[Form::Plain];
        }
        Ok(())
    }

    /// How many cells miss in place, of the map or of samples of it.
    fn missed(
        &self,
        tree: &CellTree,
        samples: Option<&Region>,
        known: &mut Known,
        plan: &Plan,
    ) -> Result<usize, Error> {
        let numbered = self.numbered(tree, samples, known, plan)?;
        let volume = self.fitted(&numbered, known);
        known.fitted.clear();
        Ok(self.failing(&numbered, &volume, known).len())
    }
}
