//! Experiments whose answer is known: what a fluid must do, and what ours does.
//!
//! ```text
//! Experiment -> run: scenes made here, simulated, measured -> Outcome: rows with targets, charts -> table, JSON, PNG
//! ```
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, section 5, has some of them; VALIDATION.md of
//! this crate tells all of them with their figures.

pub mod dam_break;
pub mod floats;
pub mod flow;
pub mod grid;
pub mod hydrostatic;
pub mod incline;
pub mod momentum;
pub mod sphere;
pub mod table;

use serde::Serialize;
use std::path::PathBuf;
use volmap_figures::picture::{Chart, ChartAxis, Data, Limits, Quantity, Rgb, Series};
use volmap_fluid::Error;

/// Something that is simulated and measured.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// On the command line, and the beginning of its charts' file names.
    pub name: &'static str,
    /// In a line.
    pub title: &'static str,
    /// What is simulated, and what must come of it.
    pub about: &'static str,
    /// Does it.
    pub run: fn(&Run) -> Result<Outcome, Error>,
}

/// All of them.
pub const EXPERIMENTS: &[Experiment] = &[
    hydrostatic::EXPERIMENT,
    momentum::EXPERIMENT,
    dam_break::EXPERIMENT,
    floats::EXPERIMENT,
    sphere::EXPERIMENT,
    incline::EXPERIMENT,
    grid::EXPERIMENT,
];

/// How an experiment is done.
pub struct Run<'a> {
    /// In some ten seconds: fewer cases, coarser, shorter.
    pub short: bool,
    /// Where files may be left that are no charts; charts are in the outcome.
    pub folder: Option<PathBuf>,
    /// Hears what is being done, in a line, often.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

/// What came of an experiment.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Outcome {
    /// What was measured.
    pub rows: Vec<Row>,
    /// Its charts.
    pub charts: Vec<ChartFile>,
    /// What a careful reader should know of the figures.
    pub notes: Vec<String>,
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// In which case of the experiment.
    pub case: String,
    /// What it is.
    pub quantity: String,
    /// Its unit; empty for ratios and counts.
    pub unit: &'static str,
    /// What it should be, in words; empty if it is only told.
    pub target: String,
    /// What it is.
    pub measured: f64,
    /// Whether it is what it should be; none if it is only told.
    pub met: Option<bool>,
    /// What a paper has for it.
    pub paper: Option<f64>,
}

/// A chart and the name of its file.
#[derive(Clone, Debug, Serialize)]
pub struct ChartFile {
    /// With `.png`.
    pub file: String,
    /// The chart.
    #[serde(skip)]
    pub chart: Chart,
}

impl Run<'_> {
    /// The short or the long one of two.
    pub fn pick<T>(&self, short: T, long: T) -> T {
        if self.short { short } else { long }
    }
}

impl Outcome {
    /// The figure of a case.
    pub fn measured(&self, case: &str, quantity: &str) -> Option<f64> {
        let row = self.rows.iter().find(|row| row.case == case && row.quantity == quantity);
        row.map(|row| row.measured)
    }

    /// The rows that aren't what they should be.
    pub fn unmet(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.met == Some(false))
    }

    /// Adds a chart, to be kept as `file`.
    pub fn chart(&mut self, file: impl Into<String>, chart: Chart) {
        self.charts.push(ChartFile { file: file.into(), chart });
    }
}

impl Row {
    /// A figure that is only told.
    pub fn new(
        case: impl Into<String>,
        quantity: impl Into<String>,
        unit: &'static str,
        measured: f64,
    ) -> Row {
        let (case, quantity) = (case.into(), quantity.into());
        Row { case, quantity, unit, target: String::new(), measured, met: None, paper: None }
    }

    /// With a target in words, and whether it is met.
    #[must_use]
    pub fn target(self, target: impl Into<String>, met: bool) -> Row {
        Row { target: target.into(), met: Some(met), ..self }
    }

    /// The paper's figure for it.
    #[must_use]
    pub fn paper(self, paper: f64) -> Row {
        Row { paper: Some(paper), ..self }
    }

    /// It should be no more than this. What is no number never is.
    #[must_use]
    pub fn at_most(self, most: f64) -> Row {
        let met = self.measured <= most;
        self.target(format!("<= {}", table::digits(most)), met)
    }

    /// It should be no less than this.
    #[must_use]
    pub fn at_least(self, least: f64) -> Row {
        let met = self.measured >= least;
        self.target(format!(">= {}", table::digits(least)), met)
    }

    /// It should be in between.
    #[must_use]
    pub fn between(self, least: f64, most: f64) -> Row {
        let met = self.measured >= least && self.measured <= most;
        self.target(format!("{} to {}", table::digits(least), table::digits(most)), met)
    }
}

/// A chart with linear axes; `x` and `y` are names and units.
pub fn chart(title: impl Into<String>, x: [&str; 2], y: [&str; 2], series: Vec<Series>) -> Chart {
    let axis = |[name, unit]: [&str; 2]| ChartAxis {
        quantity: Quantity::new(name, unit),
        log: false,
        limits: Limits::Auto,
    };
    Chart { title: title.into(), x: axis(x), y: axis(y), series, marks: Vec::new() }
}

/// A curve of a chart.
pub fn curve(name: impl Into<String>, colour: Rgb, points: Vec<[f64; 2]>) -> Series {
    Series { name: name.into(), colour, data: Data::Curve(points) }
}
