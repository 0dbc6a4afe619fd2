//! `volmap batch`, `volmap verify` and the workers of batches.

use crate::args::batch::{BatchArguments, Log, VerifyArguments};
use crate::progress::BatchProgress;
use crate::signals::{STOPPED, cancel_on_signals};
use anyhow::{Context, Result, bail};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use volmap_bake::content_key;
use volmap_bake::parameters::Parameters;
use volmap_batch::assets::{Expanded, expand};
use volmap_batch::check::{Check, Checked, check};
use volmap_batch::engine::{self, Event};
use volmap_batch::left_out::LeftOut;
use volmap_batch::manifest::{self, Manifest};
use volmap_batch::memory::free_memory;
use volmap_batch::merge::merge;
use volmap_batch::places::Places;
use volmap_batch::prune::Leftovers;
use volmap_batch::publish::publish;
use volmap_batch::read::{find_parts, read as read_summary};
use volmap_batch::settings::BatchSettings;
use volmap_batch::summary::{Outcome, Summary};
use volmap_batch::verify::Standing;
use volmap_batch::{log, verify, worker};
use volmap_formats::text::{bytes, duration, printable_line};

/// Some assets aren't there, or aren't good.
const SOME_FAILED: u8 = 1;
/// The batch couldn't start.
const NOT_STARTED: u8 = 2;

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
        say(&format!("{:#}", Manifest::schema()));
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(folder) = &arguments.merge {
        return run_merge(folder, arguments);
    }
    let (manifest_path, manifest, folder) = read(arguments)?;
    let mut expanded = expand(&manifest, &folder)?;
    select(&mut expanded, &arguments.tag)?;
    if arguments.list {
        return Ok(list(&expanded));
    }
    let settings = settings(arguments)?;
    // What is done stays.
    let cancel = cancel_on_signals()?;
    if arguments.check {
        let found = check(&expanded, &settings, &cancel)?;
        if cancel.is_cancelled() {
            return Ok(ExitCode::from(STOPPED));
        }
        match arguments.log {
            Log::Json => say(&format!("{:#}", found.to_json())),
            Log::Text => {
                expanded.left_out.iter().for_each(|files| say(&format!("left out       {}", files.told())));
                show_check(&found, arguments.explain);
            }
        }
        return Ok(success(found.assets.iter().all(|asset| asset.cost.is_ok())));
    }
    let mut progress = BatchProgress::new(arguments.quiet);
    let mut on_event = |event: Event| {
        if let Event::Finished { report, .. } = &event {
            let is_news = arguments.explain || report.outcome != Outcome::Unchanged;
            let is_bad = report.outcome.is_bad();
            match arguments.log {
                _ if arguments.quiet && !is_bad => {}
                Log::Json => progress.print(&log::json_line(report)),
                Log::Text if is_news => progress.print(&log::lines(report)),
                Log::Text => {}
            }
        }
        progress.event(&event);
    };
    let ran = engine::run(&expanded, manifest_path.as_deref(), &settings, &mut on_event, &cancel)?;
    progress.finish();
    let code = close(&ran.summary, &settings.places.out, arguments);
    if let Some(error) = ran.unwritten {
        eprintln!("error: the summary isn't written: {error}");
        return Ok(ExitCode::from(SOME_FAILED));
    }
    Ok(code)
}

/// The manifest, its own path if it has one, and the folder that its paths are relative to.
fn read(arguments: &BatchArguments) -> Result<(Option<PathBuf>, Manifest, PathBuf)> {
    let is_manifest = |input: &str| {
        let ending = Path::new(input).extension().unwrap_or_default().to_ascii_lowercase();
        ending == "toml" || ending == "json"
    };
    match arguments.inputs.as_slice() {
        [input] if is_manifest(input) => {
            if arguments.parameters.given != Parameters::default() {
                bail!(
                    "{input}: parameters of the map, mesh and file stand in the manifest, under [defaults] bake"
                );
            }
            if arguments.name.is_some() {
                bail!("{input}: names stand in the manifest, as `name` of its assets");
            }
            let path = PathBuf::from(input);
            let folder = path.parent().unwrap_or(Path::new("")).to_owned();
            Ok((Some(path.clone()), manifest::load(&path)?, folder))
        }
        inputs => {
            if let Some(input) = inputs.iter().find(|input| is_manifest(input)) {
                bail!("{input}: a manifest stands alone; give meshes and patterns, or one manifest");
            }
            Ok((
                None,
                manifest::from_patterns(inputs, arguments.name.as_deref(), &arguments.parameters.given),
                PathBuf::new(),
            ))
        }
    }
}

fn select(expanded: &mut Expanded, tags: &[String]) -> Result<()> {
    if let Some(tag) = tags.iter().find(|tag| !expanded.assets.iter().any(|asset| asset.tags.contains(tag))) {
        bail!("--tag {tag}: no asset has this tag");
    }
    expanded.assets.retain(|asset| tags.is_empty() || tags.iter().any(|tag| asset.tags.contains(tag)));
    if expanded.assets.is_empty() {
        let left_out = expanded.left_out.iter().map(LeftOut::told);
        let notes = expanded.notes.iter().cloned().chain(left_out).collect::<Vec<_>>().join("; ");
        bail!("there is nothing to bake{}{notes}", if notes.is_empty() { "" } else { ": " });
    }
    Ok(())
}

fn list(expanded: &Expanded) -> ExitCode {
    for asset in &expanded.assets {
        let references = content_key::references(&asset.mesh);
        let references: String = references.iter().map(|path| format!("\t{}", path.display())).collect();
        say(&format!("{}\t{}\t{}{references}", asset.name, asset.mesh.display(), asset.tags.join(",")));
    }
    ExitCode::SUCCESS
}

fn settings(arguments: &BatchArguments) -> Result<BatchSettings> {
    let threads = arguments.threads.unwrap_or_else(processors);
    let out = arguments.out.clone().context("--out: name the folder of the assets")?;
    // Workers are told in JSON.
    for folder in [Some(&out), arguments.cache.as_ref()].into_iter().flatten() {
        if folder.exists() && !folder.is_dir() {
            bail!("{}: isn't a folder", folder.display());
        }
        folder
            .to_str()
            .with_context(|| format!("{}: the name isn't Unicode; take another folder", folder.display()))?;
    }
    Ok(BatchSettings {
        places: Places { out, cache: arguments.cache.clone() },
        worker: std::env::current_exe().context("the program's own file")?,
        jobs: arguments.jobs.unwrap_or(threads),
        threads,
        max_memory: arguments.max_memory.map(|size| size.0).or_else(free_memory).unwrap_or(DEFAULT_MEMORY),
        timeout: arguments.timeout,
        report_timeout: arguments.report_timeout,
        rebuild: arguments.rebuild,
        shard: arguments.shard,
        tags: arguments.tag.clone(),
        leftovers: match arguments.prune {
            true => Leftovers::Remove,
            false if arguments.shard.is_some() || !arguments.tag.is_empty() => Leftovers::Ignore,
            false => Leftovers::Tell,
        },
    })
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Prints, to whoever still reads: a batch isn't bad because nobody listens.
fn say(text: &str) {
    let _ = writeln!(io::stdout().lock(), "{text}");
}

fn close(summary: &Summary, out: &Path, arguments: &BatchArguments) -> ExitCode {
    match arguments.log {
        _ if arguments.quiet => {}
        Log::Text => say(&log::closing(summary, out)),
        Log::Json => say(&log::json_closing(summary)),
    }
    if summary.interrupted { ExitCode::from(STOPPED) } else { success(summary.is_good()) }
}

fn success(is_good: bool) -> ExitCode {
    if is_good { ExitCode::SUCCESS } else { ExitCode::from(SOME_FAILED) }
}

fn run_merge(folder: &Path, arguments: &BatchArguments) -> Result<ExitCode> {
    let parts = find_parts(folder)?.iter().map(|part| read_summary(part)).collect::<Result<Vec<_>, _>>()?;
    let merged = merge(parts)?;
    publish(&merged, folder)?;
    Ok(close(&merged, folder, arguments))
}

fn show_check(found: &Check, explain: bool) {
    for asset in &found.assets {
        match (&asset.cost, &asset.reason) {
            (Err(error), _) => say(&format!("cannot bake    {}: {error}", asset.name)),
            (Ok(_), None) if !explain => {}
            (Ok(_), None) => say(&format!("up to date     {}", asset.name)),
            (Ok(cost), Some(reason)) => say(&format!(
                "would bake     {} ({reason}): {}, {} of memory, a file of {}",
                asset.name,
                duration(cost.seconds),
                bytes(cost.memory),
                bytes(cost.file)
            )),
        }
        asset.warnings.iter().for_each(|text| say(&format!("{:14} warning: {text}", "")));
    }
    let can = |asset: &&Checked| asset.cost.is_ok();
    let is_made = |asset: &&Checked| asset.reason.is_some();
    let made = found.assets.iter().filter(can).filter(is_made).count();
    let good = found.assets.iter().filter(can).count();
    say(&format!(
        "{made} to bake, {} up to date, {} that cannot be baked; about {}, {} of memory, {} on disk (right to a factor \
         of 2 or so)",
        good - made,
        found.assets.len() - good,
        duration(found.seconds),
        bytes(found.memory),
        bytes(found.files)
    ));
}

/// A worker of a batch.
pub fn run_worker() -> Result<()> {
    Ok(worker::run(io::stdout())?)
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
    if expanded.assets.is_empty() {
        bail!(
            "{}: no mesh is found, so there is nothing to verify: {}",
            path.display(),
            expanded.notes.join("; ")
        );
    }
    expanded.unreadable.iter().for_each(|note| eprintln!("error: {note}"));
    let threads = arguments.threads.unwrap_or_else(processors);
    let findings = verify::verify(&expanded, &arguments.folder, threads);
    let bad = findings.iter().filter(|finding| !finding.problems.is_empty()).count();
    if arguments.json {
        say(&serde_json::to_string_pretty(&findings)?);
    } else {
        for finding in &findings {
            let doubtful = if finding.standing == Standing::Doubtful { "doubtful: " } else { "" };
            let line =
                |problem: &String| say(&printable_line(&format!("{}: {doubtful}{problem}", finding.name)));
            finding.problems.iter().for_each(line);
        }
        if !arguments.quiet {
            say(&format!("{} of {} assets are good", findings.len() - bad, findings.len()));
        }
    }
    Ok(success(bad == 0 && expanded.unreadable.is_empty()))
}
