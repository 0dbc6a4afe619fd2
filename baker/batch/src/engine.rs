//! The batch: what is to be done, in which order, and what came of it.

use super::asset_report::{blank, failed, kept, made};
use super::assets::{Expanded, PlannedAsset};
use super::crew::{Crew, Foreman};
use super::estimates::{estimates, own_part, subject, within};
use super::job::{Cost, Job, Order, Reply, Task};
use super::journal::{Journal, Records};
use super::places::Places;
use super::prune::{Leftovers, Tidied, tidy};
use super::publish::{publish, relative};
use super::schedule::{Schedule, Turn};
use super::state::{Action, Decision, Kept, Known, decide};
use super::summary::{AssetReport, Counts, Outcome, SUMMARY_VERSION, Shard, Summary};
use crate::error::Error;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use volmap_formats::asset::clear_leftovers;

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
    /// Only assets with one of these tags are looked at; none: all.
    pub tags: Vec<String>,
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

/// What came of a batch.
pub struct Ran {
    /// The summary.
    pub summary: Summary,
    /// Why it couldn't be written, if it couldn't.
    pub unwritten: Option<Error>,
}

/// Runs a batch of the assets of a manifest and writes its summary. `stop` ends it soon: workers are ended, what is done
/// stays.
///
/// # Errors
/// What keeps a batch from beginning: a folder that can't be used. Whatever comes later stands in the summary.
pub fn run(
    (expanded, manifest): (&Expanded, Option<&Path>),
    settings: &Settings,
    on_event: &mut dyn FnMut(Event),
    stop: &AtomicBool,
) -> Result<Ran, Error> {
    let start = Instant::now();
    let out = &settings.places.out;
    std::fs::create_dir_all(out).map_err(|source| Error::io(out, source))?;
    let (journal, past) = Journal::open(out, settings.shard)?;
    let known_names = past.names();
    let records = past.records;
    clear_folders(&settings.places, &expanded.assets);
    let own = match settings.shard {
        Some(shard) => {
            let part = own_part(&expanded.assets, shard, settings, stop)?;
            part.into_iter().map(|(index, cost)| (index, Some(cost))).collect()
        }
        None => (0..expanded.assets.len()).map(|index| (index, None)).collect::<Vec<_>>(),
    };
    let assets: Vec<&PlannedAsset> = own.iter().map(|(index, _)| &expanded.assets[*index]).collect();
    let decisions = decisions(&assets, settings, &records);
    let entries = assets.into_iter().zip(decisions).zip(own);
    let entries = entries.map(|((asset, decision), (position, estimate))| Entry {
        asset,
        decision,
        position,
        estimate,
        report: None,
    });
    let mut batch = Batch { journal, records, settings, on_event, entries: entries.collect(), failure: None };
    if !stop.load(Ordering::Relaxed) {
        batch.work(stop);
    }
    let interrupted = stop.load(Ordering::Relaxed);
    let tidied = leftovers(expanded, settings, (known_names, interrupted))?;
    let (summary, journal) = batch.finish(interrupted);
    let summary = Summary {
        manifest: manifest.map(|path| relative(path, out)),
        plan: expanded.fingerprint(),
        notes: [&expanded.notes[..], &expanded.unreadable, &tidied.notes].concat(),
        unreadable: expanded.unreadable.clone(),
        leftovers: tidied.left,
        seconds: start.elapsed().as_secs_f64(),
        ..summary
    };
    let unwritten = publish(&summary, out).and_then(|()| journal.end()).err();
    Ok(Ran { summary, unwritten })
}

/// After the work, which may take assets of earlier names for new ones. Only if it is sure what the manifest has.
fn leftovers(
    expanded: &Expanded,
    settings: &Settings,
    (known, interrupted): (BTreeSet<String>, bool),
) -> Result<Tidied, Error> {
    let is_sure = !interrupted && expanded.notes.is_empty() && expanded.unreadable.is_empty();
    match settings.leftovers {
        Leftovers::Remove if !is_sure => {
            let mut tidied = tidy(&settings.places, &expanded.assets, known, Leftovers::Tell)?;
            tidied.notes.push("nothing was pruned, as it isn't sure that all meshes were found".into());
            Ok(tidied)
        }
        other => tidy(&settings.places, &expanded.assets, known, other),
    }
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
        let files = places.files(&asset.name, None, false);
        let files = [files.good.all(), files.rejected.all()].concat();
        folders.extend(files.iter().filter_map(|file| file.parent().map(Path::to_owned)));
    }
    folders.sort();
    folders.dedup();
    // Folders that aren't there have nothing left in them.
    folders.iter().for_each(|folder| _ = clear_leftovers(folder));
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

/// An asset on its way through a batch.
pub struct Entry<'e> {
    /// The asset.
    pub asset: &'e PlannedAsset,
    /// What is to be done.
    pub decision: Decision,
    /// In the manifest's order, from 0.
    pub position: usize,
    /// What it costs, or why that can't be told, once it is estimated.
    pub estimate: Option<Result<Cost, String>>,
    /// What came of it, once it is known.
    pub report: Option<AssetReport>,
}

impl Entry<'_> {
    /// What it costs, if that is known.
    pub fn cost(&self) -> Option<Cost> {
        self.estimate.as_ref()?.as_ref().ok().copied()
    }
}

impl Batch<'_, '_> {
    /// An error after the beginning is told in the summary.
    fn work(&mut self, stop: &AtomicBool) {
        let Settings { worker, jobs, max_memory, .. } = self.settings;
        let mut crew = Crew::new(worker, *jobs, *max_memory, stop);
        self.settle_the_easy();
        let worked = self.estimate(&mut crew).and_then(|()| self.make(&mut crew));
        if let Err(error) = worked {
            self.failure = Some(error.to_string());
        }
    }

    /// Those that are as they should be, and those that can't be made.
    fn settle_the_easy(&mut self) {
        let is_open = |entry: &&Entry| matches!(entry.decision.action, Action::Make(..));
        let to_make = self.entries.iter().filter(is_open).count();
        (self.on_event)(Event::Checked { assets: self.entries.len(), to_make });
        for index in 0..self.entries.len() {
            let entry = &self.entries[index];
            let report = match &entry.decision.action {
                Action::Keep(found) => {
                    self.forget_rejected(entry, found);
                    kept(entry, found, self.records.get(&entry.asset.name))
                }
                Action::Fail(error) => failed(entry, error.clone()),
                Action::Make(..) => continue,
            };
            self.settle(None, index, report);
        }
    }

    /// What was refused between is of another time, if the good asset is the wanted one again.
    fn forget_rejected(&self, entry: &Entry, found: &Kept) {
        if !found.is_rejected {
            self.settings.places.files(&entry.asset.name, None, true).rejected.forget();
        }
    }

    fn settle(&mut self, seat: Option<usize>, index: usize, report: AssetReport) {
        (self.on_event)(Event::Finished { seat, report: &report });
        // What is unchanged stands in the last summary already. Without a note the next batch has to look at the asset.
        if matches!(report.outcome, Outcome::Built | Outcome::Reused | Outcome::Rejected) {
            let _ = self.journal.note(&report);
        }
        self.entries[index].report = Some(report);
    }

    fn estimate(&mut self, crew: &mut Crew) -> Result<(), Error> {
        let is_open = |entry: &Entry| entry.report.is_none() && entry.estimate.is_none();
        let entries = self.entries.iter().enumerate().filter(|(_, entry)| is_open(entry));
        let assets: Vec<(usize, &PlannedAsset)> =
            entries.map(|(index, entry)| (index, entry.asset)).collect();
        for (index, estimate) in estimates(&assets, self.settings, crew)? {
            self.entries[index].estimate = Some(estimate);
        }
        for index in 0..self.entries.len() {
            let entry = &self.entries[index];
            let (None, Some(estimate)) = (&entry.report, &entry.estimate) else { continue };
            if let Err(error) = within(estimate, self.settings.max_memory) {
                self.settle(None, index, failed(entry, error));
            }
        }
        Ok(())
    }

    fn make(&mut self, crew: &mut Crew) -> Result<(), Error> {
        let open = self.entries.iter().enumerate().filter(|(_, entry)| entry.report.is_none());
        let costs: Vec<(usize, Cost)> =
            open.filter_map(|(index, entry)| Some((index, entry.cost()?))).collect();
        (self.on_event)(Event::Estimated(costs.iter().map(|(_, cost)| cost.seconds).sum()));
        let Settings { jobs, threads, max_memory, .. } = *self.settings;
        let mut schedule = Schedule::new(&costs, jobs, threads, max_memory);
        crew.work(&mut schedule, self)
    }

    fn finish(mut self, interrupted: bool) -> (Summary, Journal) {
        let why = match &self.failure {
            Some(failure) => failure.clone(),
            None => "the batch was stopped before".into(),
        };
        for index in 0..self.entries.len() {
            if self.entries[index].report.is_none() {
                let entry = &self.entries[index];
                let report = AssetReport { reason: why.clone(), ..blank(entry, Outcome::NotTried) };
                self.settle(None, index, report);
            }
        }
        let assets: Vec<AssetReport> = self.entries.into_iter().filter_map(|entry| entry.report).collect();
        let summary = Summary {
            version: SUMMARY_VERSION,
            program_version: env!("CARGO_PKG_VERSION").into(),
            shard: self.settings.shard,
            tags: self.settings.tags.clone(),
            interrupted,
            counts: Counts::of(&assets),
            jobs: self.settings.jobs,
            threads: self.settings.threads,
            assets,
            ..Summary::default()
        };
        (summary, self.journal)
    }
}

impl Foreman for Batch<'_, '_> {
    fn job(&mut self, turn: &Turn) -> (Job, Option<f64>) {
        let Entry { asset, decision, .. } = &self.entries[turn.index];
        let identity = decision.identity.clone().unwrap_or_default();
        let files = self.settings.places.files(&asset.name, Some(&identity.key), asset.report);
        let candidates = match &decision.action {
            Action::Make(_, candidates) => candidates.clone(),
            _ => Vec::new(),
        };
        let order = Order {
            subject: subject(asset),
            identity,
            gates: asset.gates,
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
            Ok(Reply::Made(result)) => made(entry, *result, turn.threads, &self.settings.places),
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
        self.settle(Some(seat), turn.index, report);
        Ok(!is_full)
    }
}
