//! All closures: one row each. A new one is a file, a name in [`ClosureKind`], and a row.

use super::model::{Model, Setup};
use super::{calibrated, image, lattice, offset, paper, wedge};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// How a volume becomes a density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ClosureKind {
    /// All the volume at the closest point: Bender et al. 2020, Eq. 14.
    Paper,
    /// The volume at a point behind the surface, as SPlisHSPlasH has it.
    Offset,
    /// Exact at a flat wall and to first order in curvature.
    #[default]
    Calibrated,
    /// As `calibrated`, and close to exact at convex edges.
    Wedge,
    /// As `calibrated`, from a lattice of particles in the wall: for fluids whose particles lie in layers.
    Lattice,
    /// From the fluid's mirror image, by maps of a quarter of the kernel's support radius: particles rest at one
    /// particle radius from a wall, calmly.
    Mirror,
}

/// What is known of a kind.
struct Facts {
    kind: ClosureKind,
    name: &'static str,
    /// The kernel's support radius over the maps'.
    radii_per_map_radius: f64,
    /// Cells of its uniform maps in their support radius. Where two walls meet, the map's distance is too small by up to
    /// a quarter of a cell: closures that go by the distance need smaller cells than those that go by the volume.
    cells_per_map_radius: f64,
    /// Errors that its adaptive maps may have.
    errors: MapErrors,
    /// Whether its density has a mirrored pressure in it.
    has_image: bool,
    /// Whether there is one for kernels in two dimensions.
    is_in_plane: bool,
    /// Whether its particle radius follows the particles' volume, or their spacing alone.
    follows_volume: bool,
    new: fn(&Setup) -> Arc<dyn Model>,
}

/// How exact a closure needs its maps. Between its nodes a map's wall is rough, and a body that turns stirs the fluid by
/// that: with these errors by no more than equal cells of the closure's size do, for smooth walls are stored as their
/// difference from flat ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapErrors {
    /// Largest error of the volume, as a part of the full ball's.
    pub volume: f64,
    /// Largest error of the distance, as a part of the map's support radius, within that radius of the surface.
    pub distance: f64,
}

/// Of most kinds; `new` stands in.
const USUAL: Facts = Facts {
    kind: ClosureKind::Calibrated,
    name: "calibrated",
    radii_per_map_radius: 1.0,
    cells_per_map_radius: 4.0,
    errors: MapErrors { volume: 5e-3, distance: 0.04 },
    has_image: false,
    is_in_plane: false,
    follows_volume: true,
    new: calibrated::new,
};

/// In the order of [`ClosureKind`].
const TABLE: [Facts; 6] = [
    Facts { kind: ClosureKind::Paper, name: "paper", is_in_plane: true, new: paper::new, ..USUAL },
    Facts {
        kind: ClosureKind::Offset,
        name: "offset",
        is_in_plane: true,
        follows_volume: false,
        new: offset::new,
        ..USUAL
    },
    USUAL,
    Facts { kind: ClosureKind::Wedge, name: "wedge", new: wedge::new, ..USUAL },
    Facts { kind: ClosureKind::Lattice, name: "lattice", new: lattice::new, ..USUAL },
    Facts {
        kind: ClosureKind::Mirror,
        name: "mirror",
        radii_per_map_radius: image::MAPS_PER_RADIUS,
        cells_per_map_radius: 2.0,
        errors: MapErrors { volume: 1e-2, distance: 0.3 },
        has_image: true,
        is_in_plane: true,
        follows_volume: true,
        new: image::new,
    },
];

impl ClosureKind {
    /// All of them.
    pub const ALL: [ClosureKind; TABLE.len()] = {
        let mut all = [ClosureKind::Paper; TABLE.len()];
        let mut n = 0;
        while n < all.len() {
            all[n] = TABLE[n].kind;
            n += 1;
        }
        all
    };

    fn facts(self) -> &'static Facts {
        &TABLE[self as usize]
    }

    /// Its name, as files and messages have it.
    pub fn name(self) -> &'static str {
        self.facts().name
    }

    /// Whether there is one for kernels in two dimensions.
    pub fn is_in_plane(self) -> bool {
        self.facts().is_in_plane
    }

    /// Whether its density has the mirrored pressure of the fluid in it (Eq. 15 of Bender et al. 2020): half of its
    /// gradient is the image's.
    pub fn has_image(self) -> bool {
        self.facts().has_image
    }

    /// Whether its particle radius is half the edge of a cube of a particle's volume; else half of the particles'
    /// spacing, whatever their volume.
    pub fn follows_volume(self) -> bool {
        self.facts().follows_volume
    }

    /// The support radius (metres) of the maps that it takes, for a kernel of this one.
    pub fn map_radius(self, support_radius: f64) -> f64 {
        support_radius / self.facts().radii_per_map_radius
    }

    /// How exact its adaptive maps should be.
    pub fn map_errors(self) -> MapErrors {
        self.facts().errors
    }

    /// The edge (metres) that cells of its uniform maps should have, at most, for a kernel of this support radius.
    pub fn cell_size(self, support_radius: f64) -> f64 {
        self.map_radius(support_radius) / self.facts().cells_per_map_radius
    }

    pub(super) fn model(self, setup: &Setup) -> Arc<dyn Model> {
        (self.facts().new)(setup)
    }
}

/// Names of kinds, with commas between.
pub(super) fn names(is_meant: impl Fn(ClosureKind) -> bool) -> String {
    let names: Vec<&str> =
        ClosureKind::ALL.into_iter().filter(|&kind| is_meant(kind)).map(ClosureKind::name).collect();
    names.join(", ")
}

impl fmt::Display for ClosureKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ClosureKind {
    type Err = String;

    fn from_str(text: &str) -> Result<ClosureKind, String> {
        let known = ClosureKind::ALL.into_iter().find(|kind| kind.name() == text);
        known.ok_or_else(|| format!("`{text}` is no closure; take {}", names(|_| true)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_its_row() {
        for kind in ClosureKind::ALL {
            assert_eq!(kind.facts().kind, kind);
        }
    }

    #[test]
    fn names_are_read_back() {
        for kind in ClosureKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        assert!("magic".parse::<ClosureKind>().unwrap_err().contains("calibrated"));
    }
}
