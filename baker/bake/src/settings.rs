//! What a map can be asked for.

pub mod density;

use crate::volume_map::quadrature::Rule;
pub use density::DensitySettings;
use volmap_formats::asset::Compression;

/// How the cells are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GridChoice {
    /// Cubes of half the support radius.
    #[default]
    FromRadius,
    /// This many cells along x, y, z; their edges follow from the domain.
    Resolution([u32; 3]),
    /// Cubes of this edge, metres; the domain grows to whole cells.
    CellSize(f64),
    /// Cells of several sizes, as large as these errors allow: `adaptive` finds them. With a density, which has no
    /// adaptive form, the largest cubes whose volume is this exact: `tolerance` finds those.
    /// A plan of its own takes them as [`GridChoice::FromRadius`].
    Tolerance(Tolerances),
    /// The same for the least errors that a file of this size can have: `sized` finds those.
    Bytes(FileSize),
}

/// How large an asset's file may be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FileSize {
    /// At most.
    pub bytes: u64,
    /// How it is compressed.
    pub compression: Compression,
}

/// Tolerances of the volume that can be asked for: parts of the full ball.
pub const TOLERANCES: [f64; 2] = [5e-4, 0.5];
/// Of the distance: parts of the support radius.
pub const DISTANCE_TOLERANCES: [f64; 2] = [1e-4, 10.0];

/// The largest errors that a map may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Of the volume, as a part of the full ball's.
    pub volume: f64,
    /// Of the distance, as a part of the support radius, within a support radius of the surface.
    pub distance: f64,
    /// Of the normal, radians, where the surface has one.
    pub normal: Option<f64>,
}

impl Tolerances {
    /// Distance errors as a part of the support radius that a tolerance of the volume allows by itself, for each part of
    /// the ball. Where walls meet, a map's distance is wrong by up to a sixth of a cell: closures that go by the volume
    /// don't see it.
    const DISTANCE_PER_VOLUME: f64 = 10.0;
    /// Of the volume, if only another error is given.
    const VOLUME: f64 = 0.01;

    /// For this error of the volume, as a part of the full ball's.
    pub fn of_volume(volume: f64) -> Tolerances {
        Tolerances { volume, distance: Tolerances::DISTANCE_PER_VOLUME * volume, normal: None }
    }
}

impl Default for Tolerances {
    fn default() -> Tolerances {
        Tolerances::of_volume(Tolerances::VOLUME)
    }
}

impl GridChoice {
    /// The tolerances, made the choice if it was another.
    pub fn tolerances_mut(&mut self) -> &mut Tolerances {
        if !matches!(self, GridChoice::Tolerance(_)) {
            *self = GridChoice::Tolerance(Tolerances::default());
        }
        match self {
            GridChoice::Tolerance(tolerances) => tolerances,
            _ => unreachable!("just made"),
        }
    }
}

/// Precision of the stored fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Precision {
    /// Single: 2^-24 relative, far below any other error of a map.
    #[default]
    F32,
    /// Double.
    F64,
    /// 16-bit multiples of a step. No node's value changes by more than this fraction of r (distance) and of the
    /// full ball (volume), and by more than this (density over rest density).
    Rounded(f64),
}

impl Precision {
    /// Parts of a tolerance of the volume that rounding to 16 bits may take.
    const PARTS: f64 = 40.0;
    /// The least rounding at which 16 bits hold the distances at the nodes of the largest adaptive cells.
    const LEAST: f64 = 1.5e-4;
    /// Where bytes count more than anything else.
    pub const SHORTEST: Precision = Precision::Rounded(Precision::LEAST);

    /// The shortest numbers that leave nearly all of a tolerance of the volume to other errors.
    pub fn of_tolerance(volume: f64) -> Precision {
        match volume / Precision::PARTS {
            part if part >= Precision::LEAST => Precision::Rounded(part),
            _ => Precision::F32,
        }
    }

    /// Bytes of a stored number.
    pub fn bytes(self) -> u64 {
        match self {
            Precision::F32 => 4,
            Precision::F64 => 8,
            Precision::Rounded(_) => 2,
        }
    }
}

/// What a map depends on beside the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct MapSettings {
    /// Support radius r, metres; by default a twentieth of the box's diagonal, rounded to 1, 2 or 5 times a power
    /// of ten.
    pub support_radius: Option<f64>,
    /// How the cells are chosen.
    pub grid: GridChoice,
    /// Lowest and highest corner of the domain, metres; by default all of |Phi| <= 2 r.
    pub domain: Option<[[f64; 3]; 2]>,
    /// Length added to the domain on every side, metres.
    pub padding: f64,
    /// Solid and fluid change places: for containers.
    pub invert: bool,
    /// Moves the zero surface outwards from the solid by this, metres.
    pub thickness: f64,
    /// How the volume is integrated.
    pub rule: Rule,
    /// Adaptive maps hold the volume as it is, not its difference from a flat wall's.
    pub plain_volume: bool,
    /// How the density is computed, if it is to be.
    pub density: Option<DensitySettings>,
    /// Precision of the stored fields.
    pub precision: Precision,
    /// Limit on the estimate of memory, bytes.
    pub max_memory: u64,
}

impl Default for MapSettings {
    fn default() -> Self {
        MapSettings {
            support_radius: None,
            grid: GridChoice::default(),
            domain: None,
            padding: 0.0,
            invert: false,
            thickness: 0.0,
            plain_volume: false,
            rule: Rule::default(),
            density: None,
            precision: Precision::default(),
            max_memory: 4 << 30,
        }
    }
}

impl MapSettings {
    /// How far out of the mesh the map's surface lies, metres; below 0 within it. Thickness goes out of the solid,
    /// which is outside of the mesh if it is inverted.
    pub fn surface_offset(&self) -> f64 {
        if self.invert { -self.thickness } else { self.thickness }
    }
}
