//! How the volume is stored: as it is, or as its difference from a flat wall's.

use volmap_runtime::layout::FlatWall;

/// How the volume is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// As it is.
    Plain,
    /// As its difference from a flat wall's.
    Difference,
}

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
