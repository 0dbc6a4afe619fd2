//! What parameters may be, alone and together.

use super::row::{Group, Parameter};
use super::{Parameters, TABLE};

/// A parameter that can't be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Its key.
    pub key: &'static str,
    /// What is wrong with it and the cure.
    pub reason: String,
}

impl Parameters {
    /// Whether what is given here goes together, and each for itself can be used with some mesh.
    ///
    /// # Errors
    /// The first mistake.
    pub fn check(&self) -> Result<(), Mistake> {
        for (at, row) in self.given().enumerate() {
            let key = row.name;
            if let Some(other) = self.given().take(at).find(|other| row.is_excluded_by(other)) {
                let reason = format!("can't be used with `{}`; give one of them", other.name);
                return Err(Mistake { key, reason });
            }
            if let Some(flag) = row.needs.filter(|flag| self.denies(flag)) {
                let reason = format!("has no effect with {flag} = false; leave one of them out");
                return Err(Mistake { key, reason });
            }
            row.range.check(&(row.numbers)(self)).map_err(|reason| Mistake { key, reason })?;
        }
        let density = self.recipe().bake.map.density.map_or(Ok(()), |density| density.check());
        density.map_err(|reason| Mistake { key: "density_quadrature", reason })
    }

    /// The rows of what is given.
    pub fn given(&self) -> impl Iterator<Item = &'static Parameter> {
        TABLE.iter().filter(|row| (row.is_given)(self))
    }

    /// Whether one of the group is given.
    pub fn gives(&self, group: Group) -> bool {
        self.given().any(|row| row.group == Some(group))
    }

    /// Whether a flag is given as false.
    fn denies(&self, flag: &str) -> bool {
        TABLE.iter().any(|row| row.name == flag && (row.flag)(self) == Some(false))
    }
}
