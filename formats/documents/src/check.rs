//! Checks of a document's values; a problem knows the way to its key.

/// One step from a table to a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathStep {
    /// Into a table.
    Key(&'static str),
    /// Into a list.
    Item(usize),
}

/// A value that can't be used.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// The way to it.
    pub path: Vec<PathStep>,
    /// What is wrong and the cure.
    pub reason: String,
}

/// What a check finds.
pub type Checked = Result<(), Problem>;

/// Lengths, speeds and times beyond this are mistakes, and their squares could overflow.
const MAX_MAGNITUDE: f64 = 1e9;

impl Problem {
    /// The key, as `bodies[1].material.friction`.
    pub fn key(&self) -> String {
        let mut out = String::new();
        for step in &self.path {
            match step {
                PathStep::Key(name) if out.is_empty() => out.push_str(name),
                PathStep::Key(name) => out = format!("{out}.{name}"),
                PathStep::Item(index) => out = format!("{out}[{index}]"),
            }
        }
        out
    }
}

/// Where a check is: a table of the document.
#[derive(Clone, Debug)]
pub struct At(Vec<PathStep>);

impl At {
    /// The document itself.
    pub fn top() -> At {
        At(Vec::new())
    }

    /// A table in this one.
    pub fn key(&self, name: &'static str) -> At {
        self.then(PathStep::Key(name))
    }

    /// An item of this list.
    pub fn item(&self, index: usize) -> At {
        self.then(PathStep::Item(index))
    }

    fn then(&self, step: PathStep) -> At {
        At(self.0.iter().copied().chain([step]).collect())
    }

    /// A problem with a key of this table.
    pub fn problem(&self, name: &'static str, reason: impl Into<String>) -> Problem {
        Problem { path: self.key(name).0, reason: reason.into() }
    }

    /// A problem with all of this table.
    pub fn problem_here(&self, reason: impl Into<String>) -> Problem {
        Problem { path: self.0.clone(), reason: reason.into() }
    }

    /// Whether a value is a number of a size that can be meant.
    ///
    /// # Errors
    /// If it isn't.
    pub fn finite(&self, name: &'static str, value: f64) -> Checked {
        self.require(name, value.abs() <= MAX_MAGNITUDE, || format!("{value} is not a usable number"))
    }

    /// Whether a value is finite and above 0.
    ///
    /// # Errors
    /// If it isn't.
    pub fn positive(&self, name: &'static str, value: f64) -> Checked {
        self.finite(name, value)?;
        self.require(name, value > 0.0, || format!("{value} is not positive"))
    }

    /// Whether a value is finite and not below 0.
    ///
    /// # Errors
    /// If it isn't.
    pub fn not_negative(&self, name: &'static str, value: f64) -> Checked {
        self.finite(name, value)?;
        self.require(name, value >= 0.0, || format!("{value} is negative"))
    }

    /// Whether a value is in a range, ends among it.
    ///
    /// # Errors
    /// If it isn't.
    pub fn within(&self, name: &'static str, value: f64, [low, high]: [f64; 2]) -> Checked {
        self.require(name, (low..=high).contains(&value), || format!("{value} is not within {low} to {high}"))
    }

    /// Whether three values are finite.
    ///
    /// # Errors
    /// If they aren't.
    pub fn vector(&self, name: &'static str, value: [f64; 3]) -> Checked {
        value.into_iter().try_for_each(|x| self.finite(name, x))
    }

    /// Whether three values are finite and not all 0.
    ///
    /// # Errors
    /// If they aren't.
    pub fn direction(&self, name: &'static str, value: [f64; 3]) -> Checked {
        self.vector(name, value)?;
        let squared: f64 = value.iter().map(|x| x * x).sum();
        self.require(name, squared > 1e-24, || "has no length; a direction needs one".into())
    }

    /// Whether something holds; else there is a problem with a key.
    ///
    /// # Errors
    /// If it doesn't.
    pub fn require(&self, name: &'static str, holds: bool, reason: impl FnOnce() -> String) -> Checked {
        if holds { Ok(()) } else { Err(self.problem(name, reason())) }
    }
}
