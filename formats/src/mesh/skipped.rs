//! Elements of a mesh file that hold no surface.

use std::fmt;

/// Elements that hold no surface, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    /// Point elements; or faces with one corner.
    pub points: usize,
    /// Line elements; or faces with two corners.
    pub lines: usize,
    /// Curves, patches, incomplete primitives and the like.
    pub other: usize,
}

impl Skipped {
    /// All of them.
    pub fn total(&self) -> usize {
        self.points + self.lines + self.other
    }
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} points, {} lines, {} other elements", self.points, self.lines, self.other)
    }
}
