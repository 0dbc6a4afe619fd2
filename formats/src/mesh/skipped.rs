//! Elements of a mesh file that hold no surface.

use std::fmt;

use crate::text::thousands;

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

/// `2 points, 1 line`; `nothing`.
impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = [(self.points, "point"), (self.lines, "line"), (self.other, "other element")];
        let found = kinds.iter().filter(|(n, _)| *n > 0);
        let text = found
            .map(|&(n, name)| format!("{} {name}{}", thousands(n as u64), if n == 1 { "" } else { "s" }));
        let text = text.collect::<Vec<_>>().join(", ");
        f.write_str(if text.is_empty() { "nothing" } else { &text })
    }
}
