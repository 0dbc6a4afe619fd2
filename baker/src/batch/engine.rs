//! The batch: what is to be done, in which order, and what came of it.

use super::assets::{Expanded, PlannedAsset};
use super::crew::{Crew, Foreman};
use super::job::{Cost, Job, Made, Order, Reply, Subject, Task};
use super::journal::{Journal, Records};
use super::junit::junit;
use super::page::page;
use super::places::{self, Places};
use super::prune::{Leftovers, tidy};
use super::schedule::{Schedule, Turn};
use super::shard;
use super::state::{Action, Decision, Kept, Known, decide};
use super::summary::{AssetReport, Counts, Outcome, SUMMARY_VERSION, Shard, Summary};
use crate::error::Error;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use volmap_formats::asset::{self, clear_leftovers};

/// How a batch is run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The output folder and the cache.
    pub places: Places,
    /// The program whose `batch-worker` makes assets: `volmap`.
    pub worker: PathBuf,
    /// Assets in work at once.
    pub jobs: usize,
    /// Threads of all together.
    pub threads: usize,
    /// Memory of all together, bytes.
    pub max_memory: u64,
    /// Seconds for an asset whose manifest says nothing.
    pub timeout: Option<f64>,
    /// Make everything anew.
    pub rebuild: bool,
    /// Which part to do.
    pub shard: Option<Shard>,
    /// What is done with assets that the manifest has no more.
    pub leftovers: Leftovers,
}

/// What happens.
pub enum Event<'a> {
    /// Files are compared; so many assets are to be made.
    Checked {
        /// All of them.
        assets: usize,
        /// Those to be made.
        to_make: usize,
    },
    /// Estimated seconds of all, on one thread.
    Estimated(f64),
    /// An asset is begun.
    Begun {
        /// By which worker, from 0.
        seat: usize,
        /// Its name.
        name: &'a str,
    },
    /// A step of it begins.
    Step {
        /// By which worker.
        seat: usize,
        /// Its name.
        name: &'a str,
        /// What is done.
        step: &'a str,
    },
    /// An asset is done.
    Finished {
        /// By which worker, if one was needed.
        seat: Option<usize>,
        /// What came of it.
        report: &'a AssetReport,
    },
}

/// Runs a batch of the assets of a manifest and writes its summary. `stop` ends it soon: workers are ended, what is done
/// stays.
///
/// # Errors
/// A folder that can't be used; a worker that can't be started. That an asset fails is no error.
pub fn run(
    (expanded, manifest): (&Expanded, Option<&Path>),
    settings: &Settings,
    on_event: &mut dyn FnMut(Event),
    stop: &AtomicBool,
) -> Result<Summary, Error> {
    let start = Instant::now();
    let out = &settings.places.out;
    let assets = &expanded.assets;
    std::fs::create_dir_all(out).map_err(|source| Error::Io { path: out.clone(), source })?;
    let (journal, records) = Journal::open(out, settings.shard)?;
    clear_folders(&settings.places, assets);
    let mut notes = expanded.notes.clone();
    notes.extend(tidy(out, assets, settings.leftovers)?);
    let mut crew = Crew::new(&settings.worker, settings.jobs, settings.max_memory, stop);
    let (own, shard_costs) = match settings.shard {
        Some(part) => {
            let costs = costs(assets, settings, &mut crew)?;
            let costs: Vec<Option<Cost>> = costs.into_iter().map(Result::ok).collect();
            let shards = shard::partition(&costs, part.count);
            let own = (0..assets.len()).filter(|&index| shards[index] + 1 == part.index).collect();
            (own, costs)
        }
        None => ((0..assets.len()).collect::<Vec<_>>(), Vec::new()),
    };
    let own_assets: Vec<&PlannedAsset> = own.iter().map(|&index| &assets[index]).collect();
    let decisions = decisions(&own_assets, settings, &records);
    let mut batch = Batch { journal, records, settings, on_event, entries: Vec::new(), failure: None };
    batch.entries = own_assets
        .into_iter()
        .zip(decisions)
        .zip(&own)
        .map(|((asset, decision), &position)| {
            let cost = shard_costs.get(position).copied().flatten();
            Entry { asset, decision, position, cost, report: None }
        })
        .collect();
    batch.settle_the_easy()?;
    batch.estimate(&mut crew)?;
    batch.make(&mut crew)?;
    drop(crew);
    let (summary, journal) = batch.finish(stop.load(Ordering::Relaxed))?;
    let summary = Summary {
        manifest: manifest.map(|path| relative(path, out)),
        notes,
        seconds: start.elapsed().as_secs_f64(),
        ..summary
    };
    publish(&summary, out)?;
    journal.end()?;
    Ok(summary)
}

/// A path as seen from a folder, if both can be found; else as it is.
fn relative(path: &Path, folder: &Path) -> String {
    let (Ok(path), Ok(folder)) = (path.canonicalize(), folder.canonicalize()) else {
        return path.display().to_string();
    };
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| "..".to_owned());
    let down = path.components().skip(shared).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// Writes `summary.json`, `summary.html` and `junit.xml`, or those of a shard, into the output folder.
///
/// # Errors
/// Files that can't be written.
pub fn publish(summary: &Summary, out: &Path) -> Result<(), Error> {
    let file = |stem, ending| out.join(places::of_shard(stem, ending, summary.shard));
    asset::publish(&file("summary", "html"), page(summary, out).to_html().as_bytes())?;
    asset::publish(&file("junit", "xml"), junit(summary).as_bytes())?;
    let json = serde_json::to_string_pretty(summary).expect("plain data") + "\n";
    Ok(asset::publish(&file("summary", "json"), json.as_bytes())?)
}

/// What is to be done with each asset, in their order.
pub fn decisions(assets: &[&PlannedAsset], settings: &Settings, records: &Records) -> Vec<Decision> {
    let known = Known { rebuild: settings.rebuild, ..Known::new(&settings.places, records) };
    in_pool(settings.threads, || assets.par_iter().map(|asset| decide(asset, &known)).collect())
}

/// Runs on so many threads.
pub fn in_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

/// What killed batches left of files.
fn clear_folders(places: &Places, assets: &[PlannedAsset]) {
    let mut folders: Vec<PathBuf> = vec![places.out.clone()];
    for asset in assets {
        let files = places.files(&asset.name, "00", false);
        let parents =
            [&files.output, &files.rejected, &files.preview].map(|file| file.parent().map(Path::to_owned));
        folders.extend(parents.into_iter().flatten());
    }
    folders.sort();
    folders.dedup();
    // Folders that aren't there have nothing left in them.
    folders.iter().for_each(|folder| _ = clear_leftovers(folder));
}

/// Estimates what each asset costs, or says why it can't be made.
///
/// # Errors
/// A worker that can't be started.
pub fn costs(
    assets: &[PlannedAsset],
    settings: &Settings,
    crew: &mut Crew,
) -> Result<Vec<Result<Cost, String>>, Error> {
    let all: Vec<(usize, &PlannedAsset)> = assets.iter().enumerate().collect();
    let mut out = vec![Err("the batch was stopped before".to_owned()); assets.len()];
    for (index, cost) in estimates(&all, settings, crew)? {
        out[index] = cost;
    }
    Ok(out)
}

type Estimates = Vec<(usize, Result<Cost, String>)>;

fn estimates(
    assets: &[(usize, &PlannedAsset)],
    settings: &Settings,
    crew: &mut Crew,
) -> Result<Estimates, Error> {
    // The largest files first; their memory isn't known before.
    let size = |asset: &PlannedAsset| std::fs::metadata(&asset.mesh).map_or(0, |found| found.len());
    let costs: Vec<(usize, Cost)> = assets
        .iter()
        .enumerate()
        .map(|(at, (_, asset))| (at, Cost { seconds: size(asset) as f64 + 1.0, memory: 0, file: 0 }))
        .collect();
    // One thread reads a mesh.
    let jobs = settings.jobs.min(settings.threads);
    let mut schedule = Schedule::new(&costs, jobs, jobs, 1);
    let mut estimator = Estimator { assets, default_timeout: settings.timeout, found: Vec::new() };
    crew.work(&mut schedule, &mut estimator)?;
    Ok(estimator.found)
}

struct Estimator<'a> {
    assets: &'a [(usize, &'a PlannedAsset)],
    default_timeout: Option<f64>,
    found: Estimates,
}

impl Foreman for Estimator<'_> {
    fn job(&mut self, turn: &Turn) -> (Job, Option<f64>) {
        let asset = self.assets[turn.index].1;
        let job = Job { task: Task::Estimate(subject(asset)), threads: turn.threads };
        (job, asset.timeout.or(self.default_timeout))
    }

    fn done(&mut self, _: usize, turn: &Turn, reply: Result<Reply, String>) -> Result<bool, Error> {
        let cost = match reply {
            Ok(Reply::Estimated(cost)) => Ok(cost),
            Ok(Reply::Failed { error, .. }) | Err(error) => Err(error),
            Ok(other) => Err(format!("its worker answered {other:?}")),
        };
        self.found.push((self.assets[turn.index].0, cost));
        Ok(true)
    }
}

fn subject(asset: &PlannedAsset) -> Subject {
    Subject {
        mesh: asset.mesh.clone(),
        parameters: asset.parameters.clone(),
        error_points: asset.error_points,
    }
}

struct Batch<'a, 'e> {
    journal: Journal,
    records: Records,
    settings: &'a Settings,
    on_event: &'a mut dyn FnMut(Event<'_>),
    entries: Vec<Entry<'e>>,
    /// Why nothing more was begun.
    failure: Option<String>,
}

struct Entry<'e> {
    asset: &'e PlannedAsset,
    decision: Decision,
    /// In the manifest's order, from 0.
    position: usize,
    cost: Option<Cost>,
    report: Option<AssetReport>,
}

impl Batch<'_, '_> {
    /// Those that are as they should be, and those that can't be made.
    fn settle_the_easy(&mut self) -> Result<(), Error> {
        let to_make =
            self.entries.iter().filter(|entry| matches!(entry.decision.action, Action::Make(..))).count();
        (self.on_event)(Event::Checked { assets: self.entries.len(), to_make });
        for index in 0..self.entries.len() {
            let entry = &self.entries[index];
            let report = match &entry.decision.action {
                Action::Keep(kept) => kept_report(entry, kept, self.records.get(&entry.asset.name)),
                Action::Fail(error) => failed(entry, error.clone()),
                Action::Make(..) => continue,
            };
            self.settle(None, index, report)?;
        }
        Ok(())
    }

    fn settle(&mut self, seat: Option<usize>, index: usize, report: AssetReport) -> Result<(), Error> {
        (self.on_event)(Event::Finished { seat, report: &report });
        // What is unchanged stands in the last summary already.
        if matches!(report.outcome, Outcome::Built | Outcome::Reused | Outcome::Rejected) {
            self.journal.note(&report)?;
        }
        self.entries[index].report = Some(report);
        Ok(())
    }

    fn estimate(&mut self, crew: &mut Crew) -> Result<(), Error> {
        let open = |entry: &Entry| entry.report.is_none() && entry.cost.is_none();
        let entries = self.entries.iter().enumerate().filter(|(_, entry)| open(entry));
        let assets: Vec<(usize, &PlannedAsset)> =
            entries.map(|(index, entry)| (index, entry.asset)).collect();
        for (index, cost) in estimates(&assets, self.settings, crew)? {
            let most = self.settings.max_memory;
            match cost {
                Ok(cost) if cost.memory > most => {
                    let error = Error::Memory { needed: cost.memory, allowed: most }.to_string();
                    let report = failed(&self.entries[index], error);
                    self.settle(None, index, report)?;
                }
                Ok(cost) => self.entries[index].cost = Some(cost),
                Err(error) => {
                    let report = failed(&self.entries[index], error);
                    self.settle(None, index, report)?;
                }
            }
        }
        Ok(())
    }

    fn make(&mut self, crew: &mut Crew) -> Result<(), Error> {
        let open = self.entries.iter().enumerate().filter(|(_, entry)| entry.report.is_none());
        let costs: Vec<(usize, Cost)> =
            open.filter_map(|(index, entry)| Some((index, entry.cost?))).collect();
        (self.on_event)(Event::Estimated(costs.iter().map(|(_, cost)| cost.seconds).sum()));
        let Settings { jobs, threads, max_memory, .. } = *self.settings;
        let mut schedule = Schedule::new(&costs, jobs, threads, max_memory);
        crew.work(&mut schedule, self)
    }

    fn finish(mut self, interrupted: bool) -> Result<(Summary, Journal), Error> {
        let why = match &self.failure {
            Some(failure) => failure.clone(),
            None => "the batch was stopped before".into(),
        };
        for index in 0..self.entries.len() {
            if self.entries[index].report.is_none() {
                let entry = &self.entries[index];
                let report = AssetReport { reason: why.clone(), ..blank(entry, Outcome::NotTried) };
                self.settle(None, index, report)?;
            }
        }
        let assets: Vec<AssetReport> = self.entries.into_iter().filter_map(|entry| entry.report).collect();
        let summary = Summary {
            version: SUMMARY_VERSION,
            program_version: env!("CARGO_PKG_VERSION").into(),
            shard: self.settings.shard,
            interrupted,
            counts: Counts::of(&assets),
            jobs: self.settings.jobs,
            threads: self.settings.threads,
            assets,
            ..Summary::default()
        };
        Ok((summary, self.journal))
    }
}

impl Foreman for Batch<'_, '_> {
    fn job(&mut self, turn: &Turn) -> (Job, Option<f64>) {
        let Entry { asset, decision, .. } = &self.entries[turn.index];
        let identity = decision.identity.clone().unwrap_or_default();
        let files = self.settings.places.files(&asset.name, &identity.key, asset.report);
        let candidates = match &decision.action {
            Action::Make(_, candidates) => candidates.clone(),
            _ => Vec::new(),
        };
        let order = Order {
            subject: subject(asset),
            identity,
            gates: asset.gates.clone(),
            max_memory: self.settings.max_memory,
            candidates,
            files,
        };
        let job = Job { task: Task::Make(Box::new(order)), threads: turn.threads };
        (job, asset.timeout.or(self.settings.timeout))
    }

    fn begun(&mut self, seat: usize, turn: &Turn) {
        (self.on_event)(Event::Begun { seat, name: &self.entries[turn.index].asset.name });
    }

    fn step(&mut self, seat: usize, turn: &Turn, step: &str) {
        (self.on_event)(Event::Step { seat, name: &self.entries[turn.index].asset.name, step });
    }

    fn done(&mut self, seat: usize, turn: &Turn, reply: Result<Reply, String>) -> Result<bool, Error> {
        let entry = &self.entries[turn.index];
        let mut is_full = false;
        let report = match reply {
            Ok(Reply::Made(made)) => made_report(entry, *made, turn.threads, &self.settings.places),
            Ok(Reply::Failed { error, disk_full }) => {
                is_full = disk_full;
                failed(entry, error)
            }
            Ok(other) => failed(entry, format!("its worker answered {other:?}")),
            Err(error) => failed(entry, error),
        };
        if is_full {
            self.failure = Some("the disk was full before; make room, and run the batch again".into());
        }
        self.settle(Some(seat), turn.index, report)?;
        Ok(!is_full)
    }
}

fn blank(entry: &Entry, outcome: Outcome) -> AssetReport {
    let asset = entry.asset;
    AssetReport {
        name: asset.name.clone(),
        position: entry.position,
        mesh: asset.mesh_name.clone(),
        output: places::output(&asset.name),
        tags: asset.tags.clone(),
        outcome,
        reason: String::new(),
        error: None,
        failed_gates: Vec::new(),
        identity: entry.decision.identity.clone(),
        estimated_seconds: entry.cost.map(|cost| cost.seconds),
        seconds: None,
        threads: None,
        peak_memory: None,
        bytes: None,
        file_blake3: None,
        figures: None,
        preview: None,
        report: None,
    }
}

fn failed(entry: &Entry, error: String) -> AssetReport {
    let reason = match &entry.decision.action {
        Action::Make(reason, _) => reason.clone(),
        _ => String::new(),
    };
    AssetReport { reason, error: Some(error), ..blank(entry, Outcome::Failed) }
}

/// An asset that was made, where its files lie.
fn made_report(entry: &Entry, made: Made, threads: usize, places: &Places) -> AssetReport {
    let Action::Make(reason, _) = &entry.decision.action else { unreachable!("only these are made") };
    let name = &entry.asset.name;
    let outcome = match (&made.from, made.failed_gates.is_empty()) {
        (_, false) => Outcome::Rejected,
        (Some(from), true) if *from == places.out.join(places::output(name)) => Outcome::Unchanged,
        (Some(_), true) => Outcome::Reused,
        (None, true) => Outcome::Built,
    };
    let mut reason = reason.clone();
    if let (Some(from), Outcome::Reused) = (&made.from, outcome) {
        reason += &format!("; the same asset lay in {}", from.display());
    }
    made.notes.iter().for_each(|note| reason += &format!("; {note}"));
    AssetReport {
        reason,
        failed_gates: made.failed_gates,
        seconds: Some(made.seconds),
        threads: Some(threads),
        peak_memory: made.peak_memory,
        bytes: Some(made.bytes),
        file_blake3: Some(made.file_blake3),
        figures: Some(made.figures),
        ..placed(entry, outcome)
    }
}

fn placed(entry: &Entry, outcome: Outcome) -> AssetReport {
    let name = &entry.asset.name;
    AssetReport {
        output: if outcome == Outcome::Rejected { places::rejected(name) } else { places::output(name) },
        preview: Some(places::preview(name)),
        report: entry.asset.report.then(|| places::report(name)),
        ..blank(entry, outcome)
    }
}

fn kept_report(entry: &Entry, kept: &Kept, record: Option<&AssetReport>) -> AssetReport {
    let outcome = if kept.failed_gates.is_empty() { Outcome::Unchanged } else { Outcome::Rejected };
    // Times are those of the same file.
    let record = record.filter(|record| record.file_blake3.as_ref() == Some(&kept.file_blake3));
    let name = &entry.asset.name;
    AssetReport {
        output: if kept.is_rejected { places::rejected(name) } else { places::output(name) },
        reason: "mesh, parameters and program are the same".into(),
        failed_gates: kept.failed_gates.clone(),
        estimated_seconds: record.and_then(|record| record.estimated_seconds),
        seconds: record.and_then(|record| record.seconds),
        threads: record.and_then(|record| record.threads),
        peak_memory: record.and_then(|record| record.peak_memory),
        bytes: Some(kept.bytes),
        file_blake3: Some(kept.file_blake3.clone()),
        figures: Some(kept.figures.clone()),
        ..placed(entry, outcome)
    }
}
