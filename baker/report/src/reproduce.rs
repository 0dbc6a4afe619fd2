//! The experiments of Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, on volume maps themselves:
//! what the paper measured, what we measure, and their ratio.
//!
//! Where the paper is silent something is assumed, and said in [`Outcome::assumed`].

pub mod dragon;
pub mod duck;
pub mod kinds;
pub mod plane;
pub mod table;

use crate::error::Error;
use serde::Serialize;
use std::str::FromStr;
use std::time::Instant;
use volmap_bake::bake::{Bake, BakeSettings, bake};
use volmap_bake::input::{Input, Source};
use volmap_bake::work::Work;
use volmap_formats::mesh::{CleanReport, Placement, TriangleMesh};

/// The paper's MB and KB.
const MIB: f64 = 1024.0 * 1024.0;
const KIB: f64 = 1024.0;

/// An experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Experiment {
    /// The error of the duck's volume map.
    Duck,
    /// The error against the exact volume beside a plane.
    Plane,
    /// The memory of the dragon's map.
    Dragon,
    /// A volume map beside a density map.
    Density,
}

impl Experiment {
    /// In the paper's order.
    pub const ALL: [Experiment; 4] =
        [Experiment::Duck, Experiment::Plane, Experiment::Dragon, Experiment::Density];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Experiment::Duck => "duck",
            Experiment::Plane => "plane",
            Experiment::Dragon => "dragon",
            Experiment::Density => "density",
        }
    }

    /// In words, with its place in the paper.
    pub fn describe(self) -> &'static str {
        match self {
            Experiment::Duck => {
                "error of a duck's volume map against an integral of order 100 (section 5, Fig. 6)"
            }
            Experiment::Plane => "error against the exact volume as a particle moves to a plane (section 5)",
            Experiment::Dragon => "memory of a dragon's map, dense and sparse (section 5)",
            Experiment::Density => "time and memory of a density map and a volume map (section 6, Fig. 10)",
        }
    }
}

impl FromStr for Experiment {
    type Err = String;

    fn from_str(text: &str) -> Result<Experiment, String> {
        let found = Experiment::ALL.into_iter().find(|experiment| experiment.name() == text);
        found.ok_or_else(|| format!("there are {}", Experiment::ALL.map(Experiment::name).join(", ")))
    }
}

/// What the experiments depend on.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Of the duck.
    pub duck: duck::Settings,
    /// Of the plane.
    pub plane: plane::Settings,
    /// Of the dragon.
    pub dragon: dragon::Settings,
    /// Of the comparison with density maps.
    pub density: kinds::Settings,
}

/// A step of an experiment, for progress.
#[derive(Clone, Debug)]
pub struct Step {
    /// What is done.
    pub name: &'static str,
    /// How far it is, if that is known.
    pub work: Option<Work>,
}

/// What an experiment gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Which.
    pub experiment: Experiment,
    /// In words.
    pub title: &'static str,
    /// What was measured.
    pub rows: Vec<Row>,
    /// What was assumed where the paper is silent, and what there is to know of the figures.
    pub assumed: Vec<String>,
    /// Wall time.
    pub seconds: f64,
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What it is.
    pub quantity: String,
    /// Its unit; none for ratios and counts.
    pub unit: &'static str,
    /// What the paper says, if it does.
    pub paper: Option<f64>,
    /// What we find; none if something is missing, of which `remark` tells.
    pub ours: Option<f64>,
    /// Ours over the paper's.
    pub ratio: Option<f64>,
    /// Why there is no figure.
    pub remark: Option<String>,
}

impl Row {
    fn new(quantity: impl Into<String>, unit: &'static str, paper: Option<f64>, ours: f64) -> Row {
        let ratio = paper.map(|paper| ours / paper);
        Row { quantity: quantity.into(), unit, paper, ours: Some(ours), ratio, remark: None }
    }

    fn missing(
        quantity: impl Into<String>,
        unit: &'static str,
        paper: Option<f64>,
        remark: impl Into<String>,
    ) -> Row {
        Row { quantity: quantity.into(), unit, paper, ours: None, ratio: None, remark: Some(remark.into()) }
    }
}

/// What an experiment found: its rows, and what was assumed.
pub type Found = (Vec<Row>, Vec<String>);

/// Runs an experiment.
///
/// # Errors
/// Settings or a mesh that can't be used.
pub fn reproduce(
    experiment: Experiment,
    settings: &Settings,
    enter: &mut dyn FnMut(Step),
) -> Result<Outcome, Error> {
    let start = Instant::now();
    let (rows, assumed) = match experiment {
        Experiment::Duck => duck::measure(&settings.duck, enter)?,
        Experiment::Plane => plane::measure(&settings.plane, enter)?,
        Experiment::Dragon => dragon::measure(&settings.dragon, enter)?,
        Experiment::Density => kinds::measure(&settings.density, enter)?,
    };
    let seconds = start.elapsed().as_secs_f64();
    Ok(Outcome { experiment, title: experiment.describe(), rows, assumed, seconds })
}

fn baked(input: Input, settings: volmap_bake::plan::Settings) -> Result<Bake, Error> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for experiment in Experiment::ALL {
            assert_eq!(experiment.name().parse(), Ok(experiment));
        }
        let error = "goose".parse::<Experiment>().unwrap_err();
        assert!(error.contains("duck, plane"), "{error}");
    }
}
