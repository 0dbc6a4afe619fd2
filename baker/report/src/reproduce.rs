//! The experiments of Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, on volume maps themselves:
//! what the paper measured, what we measure, and their ratio.
//!
//! Where the paper is silent something is assumed, and said in the outcome's notes.

pub mod dragon;
pub mod duck;
pub mod kinds;
pub mod plane;

use crate::error::Error;
use crate::experiments::{self, Outcome, Row};
use dragon::DragonSettings;
use duck::DuckSettings;
use kinds::KindsSettings;
use plane::PlaneSettings;
use volmap_bake::bake::{Bake, BakeSettings, bake};
use volmap_bake::density_map::cost::unit_cube;
use volmap_bake::input::{Input, InputSettings, from_arrays};
use volmap_bake::settings::MapSettings;
use volmap_bake::watch::Watch;
use volmap_formats::mesh::TriangleMesh;

/// The paper's MB and KB.
const MIB: f64 = 1024.0 * 1024.0;
const KIB: f64 = 1024.0;

/// An experiment with maps. It can be watched and stopped.
pub type Experiment = experiments::Experiment<fn(&ReproduceSettings, &Watch) -> Result<Outcome, Error>>;

/// All of them, in the paper's order.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "duck",
        title: "Error of a duck's volume map",
        about: "against an integral of order 100 (section 5, Fig. 6)",
        run: |settings, watch| duck::measure(&settings.duck, watch),
    },
    Experiment {
        name: "plane",
        title: "Error beside a plane",
        about: "against the exact volume as a particle moves to a plane (section 5)",
        run: |settings, watch| plane::measure(&settings.plane, watch),
    },
    Experiment {
        name: "dragon",
        title: "Memory of a dragon's map",
        about: "dense and sparse (section 5)",
        run: |settings, watch| dragon::measure(&settings.dragon, watch),
    },
    Experiment {
        name: "density",
        title: "Time and memory of a density map and a volume map",
        about: "of a cube (section 6, Fig. 10)",
        run: |settings, watch| kinds::measure(&settings.density, watch),
    },
];

/// What the experiments depend on.
#[derive(Clone, Debug, Default)]
pub struct ReproduceSettings {
    /// Of the duck.
    pub duck: DuckSettings,
    /// Of the plane.
    pub plane: PlaneSettings,
    /// Of the dragon.
    pub dragon: DragonSettings,
    /// Of the comparison with density maps.
    pub density: KindsSettings,
}

/// A figure of which the paper may have its own.
fn row(quantity: impl Into<String>, unit: &'static str, paper: Option<f64>, ours: f64) -> Row {
    Row { paper, ..Row::new("", quantity, unit, ours) }
}

/// A figure that we don't have, and why.
fn missing(
    quantity: impl Into<String>,
    unit: &'static str,
    paper: Option<f64>,
    remark: impl Into<String>,
) -> Row {
    Row { paper, ..Row::missing("", quantity, unit, remark) }
}

/// Rows and what was assumed, without charts.
fn outcome(rows: Vec<Row>, notes: Vec<String>) -> Outcome {
    Outcome { rows, notes, ..Outcome::default() }
}

fn baked(input: Input, settings: MapSettings, watch: &Watch) -> Result<Bake, Error> {
    let settings = BakeSettings { map: settings, ..BakeSettings::default() };
    Ok(bake(input, &settings, watch)?)
}

/// The cube [-1/2, 1/2]^3, metres.
fn unit_cube_input() -> Result<Input, Error> {
    let TriangleMesh { vertices, triangles } = unit_cube();
    Ok(from_arrays("unit cube", &vertices, &triangles, &InputSettings::default())?)
}
