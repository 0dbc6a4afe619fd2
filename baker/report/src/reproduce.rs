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
use volmap_bake::input::{Input, Source};
use volmap_bake::plan::Settings as MapSettings;
use volmap_bake::work::Work;
use volmap_formats::mesh::{CleanReport, Placement, TriangleMesh};

/// The paper's MB and KB.
const MIB: f64 = 1024.0 * 1024.0;
const KIB: f64 = 1024.0;

/// An experiment with maps. It is told of its steps.
pub type Experiment =
    experiments::Experiment<fn(&ReproduceSettings, &mut dyn FnMut(ExperimentStep)) -> Result<Outcome, Error>>;

/// All of them, in the paper's order.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "duck",
        title: "Error of a duck's volume map",
        about: "against an integral of order 100 (section 5, Fig. 6)",
        run: |settings, enter| duck::measure(&settings.duck, enter),
    },
    Experiment {
        name: "plane",
        title: "Error beside a plane",
        about: "against the exact volume as a particle moves to a plane (section 5)",
        run: |settings, enter| plane::measure(&settings.plane, enter),
    },
    Experiment {
        name: "dragon",
        title: "Memory of a dragon's map",
        about: "dense and sparse (section 5)",
        run: |settings, enter| dragon::measure(&settings.dragon, enter),
    },
    Experiment {
        name: "density",
        title: "Time and memory of a density map and a volume map",
        about: "of a cube (section 6, Fig. 10)",
        run: |settings, enter| kinds::measure(&settings.density, enter),
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

/// A step of an experiment, for progress.
#[derive(Clone, Debug)]
pub struct ExperimentStep {
    /// What is done.
    pub name: &'static str,
    /// How far it is, if that is known.
    pub work: Option<Work>,
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

fn baked(input: Input, settings: MapSettings) -> Result<Bake, Error> {
    let settings = BakeSettings { map: settings, ..BakeSettings::default() };
    Ok(bake(input, &settings, &mut |_| (), &mut |_| ())?)
}

/// A mesh that comes from no file.
fn made(mesh: TriangleMesh, name: &str) -> Input {
    Input {
        mesh,
        source: Source { file: name.into(), format: "none".into(), blake3: String::new() },
        cleaning: CleanReport::default(),
        placement: Placement::default(),
        weld_tolerance: 0.0,
    }
}
