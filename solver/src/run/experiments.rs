//! `volmap-sim validate` and `volmap-sim reproduce`.

use super::{set_threads, tell};
use crate::args::ExperimentArguments;
use crate::signals;
use anyhow::{Context, Error, Result, bail};
use serde_json::Value as Json;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use volmap_experiments::validation::{Experiment, Run};
use volmap_formats::text::duration;
use volmap_report::experiments::{Finished, choose, list, merged, table, to_json};

/// The experiments of a command.
pub struct ExperimentSet {
    /// All of them, in the order in which they run.
    pub experiments: &'static [Experiment],
    /// File name of their results.
    pub results: &'static str,
    /// Whether a target that isn't met is a failure, without `--strict` too.
    pub is_strict: bool,
}

/// Runs experiments, prints their results beside the targets, and writes charts and results.
pub fn run_experiments(set: &ExperimentSet, arguments: &ExperimentArguments) -> Result<()> {
    if arguments.list {
        return Ok(write!(io::stdout().lock(), "{}", list(set.experiments))?);
    }
    let chosen = choose(set.experiments, &arguments.names).map_err(Error::msg)?;
    set_threads(arguments.threads)?;
    if let Some(folder) = &arguments.output {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let earlier = match &arguments.output {
        Some(folder) => read_results(&folder.join(set.results))?,
        None => None,
    };
    let progress = |text: &str| {
        if !arguments.quiet {
            tell(format_args!("{text}"));
        }
    };
    let watch = signals::watch()?;
    let run = Run { short: arguments.short, watch: &watch, progress: &progress };
    let mut finished: Vec<Finished> = Vec::new();
    for experiment in chosen {
        progress(&format!("{}: {}", experiment.name, experiment.title));
        let one = experiment.finish(|simulate| simulate(&run))?;
        let mut out = io::stdout().lock();
        writeln!(out, "{}  {}\n", table::to_text(one.name, &one.outcome), duration(one.seconds))?;
        out.flush()?;
        finished.push(one);
        if let Some(folder) = &arguments.output {
            // After each one: all of them take long.
            write_results(&folder.join(set.results), earlier.as_ref(), &finished, arguments.short)?;
        }
    }
    judge(&finished, set.is_strict || arguments.strict)
}

/// Targets that aren't met are an error, if that is asked for.
fn judge(finished: &[Finished], is_strict: bool) -> Result<()> {
    let unmet: usize = finished.iter().map(|one| one.outcome.unmet().count()).sum();
    if is_strict && unmet > 0 {
        bail!("{unmet} target{} not met", if unmet == 1 { " is" } else { "s are" });
    }
    Ok(())
}

/// The results of earlier runs; none if there are none yet.
///
/// # Errors
/// A file that holds something else, which would be lost.
fn read_results(path: &Path) -> Result<Option<Json>> {
    let name = || path.display().to_string();
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_context(name),
    };
    let found = serde_json::from_str(&text).ok().filter(|old| merged(old, to_json("", true, &[])).is_some());
    match found {
        Some(old) => Ok(Some(old)),
        None => bail!("{}: holds no results of experiments; remove it, or name another folder", name()),
    }
}

/// Writes charts, and the results together with those of earlier runs.
fn write_results(path: &Path, earlier: Option<&Json>, finished: &[Finished], short: bool) -> Result<()> {
    for chart in finished.iter().flat_map(|one| &one.outcome.charts) {
        let path = path.with_file_name(&chart.file);
        fs::write(&path, chart.chart.to_png()).with_context(|| path.display().to_string())?;
    }
    let new = to_json(env!("CARGO_PKG_VERSION"), short, finished);
    let all = earlier.and_then(|earlier| merged(earlier, new.clone())).unwrap_or(new);
    let text = format!("{all:#}\n");
    fs::write(path, text).with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_experiments::validation::{Outcome, Row};

    fn finished(name: &'static str, measured: f64) -> Finished {
        let rows = vec![Row::new("", "speed", "m/s", measured).at_most(1.0)];
        Finished { name, title: "", seconds: 0.0, outcome: Outcome { rows, ..Outcome::default() } }
    }

    #[test]
    fn missed_targets_are_an_error() {
        assert!(judge(&[finished("a", 0.5)], true).is_ok());
        assert!(judge(&[finished("a", 0.5), finished("b", 2.0)], false).is_ok());
        let error = judge(&[finished("a", 0.5), finished("b", 2.0)], true).unwrap_err();
        assert_eq!(error.to_string(), "1 target is not met");
    }

    #[test]
    fn results_grow_and_nothing_else_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("validation.json");
        assert!(read_results(&path).unwrap().is_none());
        write_results(&path, None, &[finished("a", 0.5)], true).unwrap();
        let earlier = read_results(&path).unwrap();
        write_results(&path, earlier.as_ref(), &[finished("b", 0.5)], true).unwrap();
        let all = read_results(&path).unwrap().unwrap();
        assert_eq!(
            (&all["experiments"][0]["name"], &all["experiments"][1]["name"]),
            (&"a".into(), &"b".into())
        );
        fs::write(&path, "{}").unwrap();
        let error = read_results(&path).unwrap_err().to_string();
        assert!(error.contains("holds no results of experiments"), "{error}");
    }
}
