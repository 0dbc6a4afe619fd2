//! The frame of experiments: what is run, the rows of figures beside targets and a paper's figures, charts, and all of
//! it as a table and as JSON. It knows neither maps nor fluids.
//!
//! ```
//! use volmap_report::experiments::{Experiment, Outcome, Row, choose, table};
//!
//! let circle = Experiment {
//!     name: "circle",
//!     title: "Area of a polygon",
//!     about: "a polygon of many corners must have the area of its circle",
//!     run: |corners: u32| {
//!         let angle = std::f64::consts::TAU / f64::from(corners);
//!         let area = 0.5 * f64::from(corners) * angle.sin();
//!         let area = Row::new("unit circle", "area", "m^2", area);
//!         Outcome { rows: vec![area.between(3.14, 3.15)], ..Outcome::default() }
//!     },
//! };
//! let all = [circle];
//! let chosen = choose(&all, &["circle".to_owned()]).unwrap();
//! let outcome = (chosen[0].run)(1000);
//! assert_eq!(outcome.unmet().count(), 0);
//! assert!(table::to_text("circle", &outcome).contains("met"));
//! ```

pub mod table;

use serde::Serialize;
use serde_json::{Value as Json, json};
use std::time::Instant;
use volmap_figures::picture::{Chart, ChartAxis, Data, Limits, Quantity, Rgb, Series};
use volmap_formats::text::significant;

/// Something that is run and measured; `F` is the function that does it.
#[derive(Clone, Copy, Debug)]
pub struct Experiment<F> {
    /// Its name: an argument of the command line, and the beginning of its charts' file names.
    pub name: &'static str,
    /// In a line.
    pub title: &'static str,
    /// What is done, and what must come of it.
    pub about: &'static str,
    /// Runs it.
    pub run: F,
}

/// The name that stands for all experiments.
pub const ALL: &str = "all";

/// The experiments of these names, each once and in the order of the list; without names, and for [`ALL`], all of them.
///
/// # Errors
/// A message with the name that is unknown, and those that are known.
pub fn choose<'a, F>(
    experiments: &'a [Experiment<F>],
    names: &[String],
) -> Result<Vec<&'a Experiment<F>>, String> {
    let known = |name: &str| name == ALL || experiments.iter().any(|one| one.name == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        let all: Vec<&str> = experiments.iter().map(|one| one.name).collect();
        return Err(format!("unknown experiment `{unknown}`; available: {}", all.join(", ")));
    }
    let wanted =
        |one: &&Experiment<F>| names.is_empty() || names.iter().any(|name| name == one.name || name == ALL);
    Ok(experiments.iter().filter(wanted).collect())
}

/// A line for each experiment: name, title, what it is about.
pub fn list<F>(experiments: &[Experiment<F>]) -> String {
    let line = |one: &Experiment<F>| format!("{:12} {}: {}\n", one.name, one.title, one.about);
    experiments.iter().map(line).collect()
}

/// The results of an experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Outcome {
    /// What was measured.
    pub rows: Vec<Row>,
    /// Its charts.
    pub charts: Vec<ChartFile>,
    /// What a careful reader should know of the figures: what was assumed, what is scaled.
    pub notes: Vec<String>,
}

/// A measured figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// In which case of the experiment; empty if there is one only.
    pub case: String,
    /// What it is.
    pub quantity: String,
    /// Its unit; empty for ratios and counts.
    pub unit: &'static str,
    /// What it should be, in words; empty if there is no target.
    pub target: String,
    /// What was measured; NaN (null in JSON) if something is missing, which `remark` names.
    pub measured: f64,
    /// Whether the target is met; none if there is no target.
    pub met: Option<bool>,
    /// What a paper gives for it.
    pub paper: Option<f64>,
    /// Why there is no figure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

/// A chart and the name of its file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartFile {
    /// With `.png`.
    pub file: String,
    /// The chart.
    #[serde(skip)]
    pub chart: Chart,
}

/// An experiment that was run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finished {
    /// Its name.
    pub name: &'static str,
    /// In a line.
    pub title: &'static str,
    /// Wall time.
    pub seconds: f64,
    /// What came of it.
    pub outcome: Outcome,
}

impl<F> Experiment<F> {
    /// Runs it by `run`, which passes its function what that needs, and takes the time.
    ///
    /// # Errors
    /// Those of the experiment.
    pub fn finish<E>(&self, run: impl FnOnce(&F) -> Result<Outcome, E>) -> Result<Finished, E> {
        let start = Instant::now();
        let outcome = run(&self.run)?;
        Ok(Finished { name: self.name, title: self.title, seconds: start.elapsed().as_secs_f64(), outcome })
    }
}

/// Experiments as a JSON document: the program's version and whether they were shortened, of the last run and of each
/// experiment, and each with its rows.
pub fn to_json(version: &str, short: bool, finished: &[Finished]) -> Json {
    let one = |one: &Finished| {
        let mut one = json!(one);
        one["version"] = version.into();
        one["short"] = short.into();
        one
    };
    let experiments: Vec<Json> = finished.iter().map(one).collect();
    json!({ "version": version, "short": short, "experiments": experiments })
}

/// The document `new`, and of `old`, one of earlier runs, the experiments that `new` hasn't in the same form (short or
/// not). None if `old` is no such document.
pub fn merged(old: &Json, new: Json) -> Option<Json> {
    let mut all = old["experiments"].as_array()?.clone();
    let of = |one: &Json| Some((one["name"].as_str()?.to_owned(), one["short"].as_bool()));
    for one in &mut all {
        // Once the whole document told the form.
        if one["short"].is_null() {
            one["short"] = old["short"].clone();
        }
        of(one)?;
    }
    for one in new["experiments"].as_array()? {
        match all.iter_mut().find(|other| of(other) == of(one)) {
            Some(other) => *other = one.clone(),
            None => all.push(one.clone()),
        }
    }
    Some(json!({ "version": new["version"], "short": new["short"], "experiments": all }))
}

impl Outcome {
    /// The figure of a case.
    pub fn measured(&self, case: &str, quantity: &str) -> Option<f64> {
        let row = self.rows.iter().find(|row| row.case == case && row.quantity == quantity);
        row.map(|row| row.measured)
    }

    /// The rows whose targets aren't met.
    pub fn unmet(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.met == Some(false))
    }

    /// Adds a chart, to be kept as `file`; none if nothing is in it.
    pub fn chart(&mut self, file: impl Into<String>, chart: Chart) {
        if chart.series.is_empty() {
            return;
        }
        self.charts.push(ChartFile { file: file.into(), chart });
    }
}

impl Row {
    /// A figure without a target.
    pub fn new(
        case: impl Into<String>,
        quantity: impl Into<String>,
        unit: &'static str,
        measured: f64,
    ) -> Row {
        let (case, quantity) = (case.into(), quantity.into());
        Row { case, quantity, unit, target: String::new(), measured, met: None, paper: None, remark: None }
    }

    /// A figure that can't be measured, and why.
    pub fn missing(
        case: impl Into<String>,
        quantity: impl Into<String>,
        unit: &'static str,
        remark: impl Into<String>,
    ) -> Row {
        Row { remark: Some(remark.into()), ..Row::new(case, quantity, unit, f64::NAN) }
    }

    /// The measured figure over the paper's, if there are both.
    pub fn ratio(&self) -> Option<f64> {
        self.paper.map(|paper| self.measured / paper).filter(|ratio| !ratio.is_nan())
    }

    /// With a target in words, and whether it is met.
    #[must_use]
    pub fn target(self, target: impl Into<String>, met: bool) -> Row {
        Row { target: target.into(), met: Some(met), ..self }
    }

    /// With the paper's figure.
    #[must_use]
    pub fn paper(self, paper: f64) -> Row {
        Row { paper: Some(paper), ..self }
    }

    /// It should be no more than this. NaN never is.
    #[must_use]
    pub fn at_most(self, most: f64) -> Row {
        let met = self.measured <= most;
        self.target(format!("<= {}", digits(most)), met)
    }

    /// It should be no less than this.
    #[must_use]
    pub fn at_least(self, least: f64) -> Row {
        let met = self.measured >= least;
        self.target(format!(">= {}", digits(least)), met)
    }

    /// It should be in between.
    #[must_use]
    pub fn between(self, least: f64, most: f64) -> Row {
        let met = self.measured >= least && self.measured <= most;
        self.target(format!("{} to {}", digits(least), digits(most)), met)
    }
}

/// Figures have four digits.
pub fn digits(value: f64) -> String {
    significant(value, 4)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn experiments_are_chosen_by_their_names() {
        let experiment = |name| Experiment { name, title: "", about: "", run: || () };
        let all = [experiment("duck"), experiment("plane")];
        let chosen = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            choose(&all, &names).map(|found| found.iter().map(|one| one.name).collect::<Vec<_>>())
        };
        assert_eq!(chosen(&["plane", "duck", "plane"]), Ok(vec!["duck", "plane"]));
        assert_eq!(chosen(&[]), chosen(&["all"]));
        assert_eq!(chosen(&["goose"]), Err("unknown experiment `goose`; available: duck, plane".into()));
    }

    #[test]
    fn results_of_several_runs_are_kept_together() {
        let finished = |name, seconds| Finished { name, title: "", seconds, outcome: Outcome::default() };
        let first = to_json("1", true, &[finished("a", 1.0), finished("b", 2.0)]);
        let second = merged(&first, to_json("2", true, &[finished("b", 3.0)])).unwrap();
        let third = merged(&second, to_json("2", false, &[finished("b", 4.0)])).unwrap();
        let told = |one: &Json| {
            (one["name"].as_str().unwrap().to_owned(), one["seconds"].as_f64(), one["short"].as_bool())
        };
        let all: Vec<_> = third["experiments"].as_array().unwrap().iter().map(told).collect();
        let [a, b] = ["a", "b"].map(str::to_owned);
        let wanted =
            [(a, Some(1.0), Some(true)), (b.clone(), Some(3.0), Some(true)), (b, Some(4.0), Some(false))];
        assert_eq!(all, wanted);
        assert_eq!(
            (&third["experiments"][0]["version"], &third["experiments"][1]["version"]),
            (&json!("1"), &json!("2"))
        );
        // As it was written before.
        let old = json!({ "version": "0", "short": true, "experiments": [{ "name": "a", "seconds": 9.0 }] });
        assert_eq!(merged(&old, first.clone()).unwrap()["experiments"].as_array().unwrap().len(), 2);
        assert_eq!(merged(&json!([1]), first), None);
    }

    #[test]
    fn charts_of_nothing_are_left_out() {
        let mut outcome = Outcome::default();
        outcome.chart("empty.png", chart("", ["x", ""], ["y", ""], Vec::new()));
        assert!(outcome.charts.is_empty());
    }

    #[test]
    fn json_has_the_rows() {
        let rows =
            vec![Row::new("a", "speed", "m/s", 1.0).paper(4.0), Row::missing("a", "mass", "kg", "no scales")];
        let outcome = Outcome { rows, ..Outcome::default() };
        assert_eq!([outcome.rows[0].ratio(), outcome.rows[1].ratio()], [Some(0.25), None]);
        let json = to_json("1", true, &[Finished { name: "x", title: "X", seconds: 0.5, outcome }]);
        let rows = &json["experiments"][0]["outcome"]["rows"];
        assert_eq!((rows[0]["measured"].as_f64(), rows[0]["paper"].as_f64()), (Some(1.0), Some(4.0)));
        assert!(rows[1]["measured"].is_null() && rows[1]["remark"] == "no scales");
    }
}
