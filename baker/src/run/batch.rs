//! `volmap batch`, `volmap verify` and the workers of batches.

use crate::args::batch::{BatchArguments, Log, VerifyArguments};
use crate::batch_progress::BatchProgress;
use anyhow::{Context, Result, bail};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use volmap_baker::batch::assets::{Expanded, expand};
use volmap_baker::batch::check::{Check, check};
use volmap_baker::batch::engine::{self, Event, Settings};
use volmap_baker::batch::manifest::{self, Manifest};
use volmap_baker::batch::merge::merge;
use volmap_baker::batch::places::Places;
use volmap_baker::batch::prune::Leftovers;
use volmap_baker::batch::read::{find_parts, read as read_summary};
use volmap_baker::batch::summary::{Outcome, Summary};
use volmap_baker::batch::{log, verify, worker};
use volmap_baker::parameters::Parameters;
use volmap_baker::summary::bytes;

/// Some assets aren't there, or aren't good.
const SOME_FAILED: u8 = 1;
/// The batch couldn't start.
const NOT_STARTED: u8 = 2;
/// As shells have it after Ctrl-C.
const STOPPED: u8 = 130;

/// Memory if the system doesn't tell what is free, bytes.
const DEFAULT_MEMORY: u64 = 4 << 30;

/// Runs a batch; the exit code says what came of it.
pub fn run_batch(arguments: &BatchArguments) -> ExitCode {
    start(arguments).unwrap_or_else(|error| {
        eprintln!("error: {}", crate::message(&error));
        ExitCode::from(NOT_STARTED)
    })
}

fn start(arguments: &BatchArguments) -> Result<ExitCode> {
    if arguments.schema {
        writeln!(io::stdout().lock(), "{:#}", Manifest::schema())?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(folder) = &arguments.merge {
        return run_merge(folder, arguments);
    }
    let (manifest_path, manifest, folder) = read(arguments)?;
    let mut expanded = expand(&manifest, &folder)?;
    select(&mut expanded, &arguments.tag)?;
    if arguments.list {
        return list(&expanded);
    }
    let settings = settings(arguments)?;
    let stop = stop_on_signals()?;
    if arguments.check {
        return show_check(&check(&expanded, &settings, &stop)?, arguments);
    }
    let mut progress = BatchProgress::new(arguments.quiet);
    let mut on_event = |event: Event| {
        if let Event::Finished { report, .. } = &event {
            let is_news = arguments.explain || report.outcome != Outcome::Unchanged;
            let is_bad = matches!(report.outcome, Outcome::Failed | Outcome::Rejected);
            match arguments.log {
                _ if arguments.quiet && !is_bad => {}
                Log::Json => progress.print(&log::json_line(report)),
                Log::Text if is_news => progress.print(&log::line(report)),
                Log::Text => {}
            }
        }
        progress.event(&event);
    };
    let summary = engine::run((&expanded, manifest_path.as_deref()), &settings, &mut on_event, &stop)?;
    progress.finish();
    close(&summary, &settings.places.out, arguments)
}

/// The manifest, its own path if it has one, and the folder that its paths are relative to.
fn read(arguments: &BatchArguments) -> Result<(Option<PathBuf>, Manifest, PathBuf)> {
    let is_manifest = |input: &str| {
        let ending = Path::new(input).extension().unwrap_or_default().to_ascii_lowercase();
        ending == "toml" || ending == "json"
    };
    match arguments.inputs.as_slice() {
        [input] if is_manifest(input) => {
            if arguments.parameters != Parameters::default() {
                bail!(
                    "{input}: parameters of the map, mesh and file stand in the manifest, under [defaults] bake"
                );
            }
            let path = PathBuf::from(input);
            let folder = path.parent().unwrap_or(Path::new("")).to_owned();
            Ok((Some(path.clone()), manifest::load(&path)?, folder))
        }
        inputs => {
            if let Some(input) = inputs.iter().find(|input| is_manifest(input)) {
                bail!("{input}: a manifest stands alone; give meshes and patterns, or one manifest");
            }
            Ok((None, manifest::from_patterns(inputs, &arguments.parameters), PathBuf::new()))
        }
    }
}

fn select(expanded: &mut Expanded, tags: &[String]) -> Result<()> {
    if let Some(tag) = tags.iter().find(|tag| !expanded.assets.iter().any(|asset| asset.tags.contains(tag))) {
        bail!("--tag {tag}: no asset has this tag");
    }
    expanded.assets.retain(|asset| tags.is_empty() || tags.iter().any(|tag| asset.tags.contains(tag)));
    if !tags.is_empty() {
        expanded.notes.push(format!("only assets with a tag of: {}", tags.join(", ")));
    }
    if expanded.assets.is_empty() {
        let notes = expanded.notes.join("; ");
        bail!("there is nothing to bake{}{notes}", if notes.is_empty() { "" } else { ": " });
    }
    Ok(())
}

fn list(expanded: &Expanded) -> Result<ExitCode> {
    let mut out = io::stdout().lock();
    for asset in &expanded.assets {
        writeln!(out, "{}\t{}\t{}", asset.name, asset.mesh.display(), asset.tags.join(","))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn settings(arguments: &BatchArguments) -> Result<Settings> {
    let processors = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = arguments.threads.unwrap_or_else(processors);
    let out = arguments.out.clone().context("--out: name the folder of the assets")?;
    Ok(Settings {
        places: Places { out, cache: arguments.cache.clone() },
        worker: std::env::current_exe().context("the program's own file")?,
        jobs: arguments.jobs.unwrap_or(threads),
        threads,
        max_memory: arguments.max_memory.map(|size| size.0).or_else(free_memory).unwrap_or(DEFAULT_MEMORY),
        timeout: arguments.timeout,
        rebuild: arguments.rebuild,
        shard: arguments.shard,
        leftovers: match arguments.prune {
            true => Leftovers::Remove,
            false if arguments.shard.is_some() || !arguments.tag.is_empty() => Leftovers::Ignore,
            false => Leftovers::Tell,
        },
    })
}

/// Three quarters of the memory that is free, where the system tells.
fn free_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kib * 1024 / 4 * 3)
}

/// Ctrl-C and the signals that end programs stop the batch; what is done stays.
fn stop_on_signals() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let handler = stop.clone();
    ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed))?;
    Ok(stop)
}

fn close(summary: &Summary, out: &Path, arguments: &BatchArguments) -> Result<ExitCode> {
    let mut output = io::stdout().lock();
    match arguments.log {
        _ if arguments.quiet => {}
        Log::Text => writeln!(output, "{}", log::closing(summary, out))?,
        Log::Json => writeln!(output, "{}", log::json_closing(summary))?,
    }
    Ok(match summary.counts.all_good() {
        _ if summary.interrupted => ExitCode::from(STOPPED),
        true => ExitCode::SUCCESS,
        false => ExitCode::from(SOME_FAILED),
    })
}

fn run_merge(folder: &Path, arguments: &BatchArguments) -> Result<ExitCode> {
    let parts = find_parts(folder)?.iter().map(|part| read_summary(part)).collect::<Result<Vec<_>, _>>()?;
    let merged = merge(parts)?;
    engine::publish(&merged, folder)?;
    close(&merged, folder, arguments)
}

fn show_check(found: &Check, arguments: &BatchArguments) -> Result<ExitCode> {
    let mut out = io::stdout().lock();
    let mut is_good = true;
    for asset in &found.assets {
        match (&asset.cost, &asset.reason) {
            (Err(error), _) => {
                is_good = false;
                writeln!(out, "can't be made  {}: {error}", asset.name)?;
            }
            (Ok(_), None) if !arguments.explain => {}
            (Ok(_), None) => writeln!(out, "stays          {}", asset.name)?,
            (Ok(cost), Some(reason)) => writeln!(
                out,
                "is made        {}: {reason}; {:.1} s, {} of memory, a file of {}",
                asset.name,
                cost.seconds,
                bytes(cost.memory),
                bytes(cost.file)
            )?,
        }
    }
    let count = |reason: bool| {
        found.assets.iter().filter(|asset| asset.cost.is_ok() && asset.reason.is_some() == reason).count()
    };
    writeln!(
        out,
        "{} to make, {} stay, {} can't be made; about {:.0} s, {} of memory, {} on disk (right to a factor of 2 or so)",
        count(true),
        count(false),
        found.assets.iter().filter(|asset| asset.cost.is_err()).count(),
        found.seconds,
        bytes(found.memory),
        bytes(found.files)
    )?;
    Ok(ExitCode::from(if is_good { 0 } else { SOME_FAILED }))
}

/// A worker of a batch.
pub fn run_worker() -> Result<()> {
    Ok(worker::work(io::stdout())?)
}

/// Checks a folder of assets against its manifest.
pub fn run_verify(arguments: &VerifyArguments) -> ExitCode {
    verify_folder(arguments).unwrap_or_else(|error| {
        eprintln!("error: {}", crate::message(&error));
        ExitCode::from(NOT_STARTED)
    })
}

fn verify_folder(arguments: &VerifyArguments) -> Result<ExitCode> {
    let path = match &arguments.manifest {
        Some(path) => path.clone(),
        None => verify::manifest_of(&arguments.folder)?,
    };
    let expanded = expand(&manifest::load(&path)?, path.parent().unwrap_or(Path::new("")))?;
    let processors = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = arguments.threads.unwrap_or_else(processors);
    let findings = verify::verify(&expanded, &arguments.folder, threads);
    let bad = findings.iter().filter(|finding| !finding.problems.is_empty()).count();
    let mut out = io::stdout().lock();
    if arguments.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&findings)?)?;
    } else {
        for finding in &findings {
            finding.problems.iter().try_for_each(|problem| writeln!(out, "{}: {problem}", finding.name))?;
        }
        if !arguments.quiet {
            writeln!(out, "{} of {} assets are good", findings.len() - bad, findings.len())?;
        }
    }
    Ok(if bad == 0 { ExitCode::SUCCESS } else { ExitCode::from(SOME_FAILED) })
}
