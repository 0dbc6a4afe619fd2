//! The batch: what is to be done, in which order, and what came of it.

use super::asset_report::{blank, failed, kept, made};
use super::assets::{Expanded, PlannedAsset};
use super::estimates::{bake_input, estimates, own_part, within};
use super::item::BatchItem;
use super::job::{Cost, Job, MakeTask, Reply, Task};
use super::journal::{Journal, Records};
use super::page::Running;
use super::places::Places;
use super::pool::{JobHandler, Limits, WorkerPool};
use super::prune::{Leftovers, Tidied, tidy};
use super::publish::{publish, publish_running, relative};
use super::queue::{Assignment, JobQueue};
use super::settings::BatchSettings;
use super::state::{Action, Kept, decisions};
use super::summary::{AssetReport, Counts, Outcome, SUMMARY_VERSION, Summary};
use crate::error::Error;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use volmap_bake::watch::Cancel;
use volmap_formats::asset::clear_leftovers;

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
    /// The job of an asset starts.
    Started {
        /// In which slot of the worker pool, from 0.
        slot: usize,
        /// Its name.
        name: &'a str,
    },
    /// A step of it starts.
    Step {
        /// In which slot.
        slot: usize,
        /// Its name.
        name: &'a str,
        /// What is done.
        step: &'a str,
    },
    /// An asset is finished.
    Finished {
        /// In which slot, if a job was needed.
        slot: Option<usize>,
        /// What came of it.
        report: &'a AssetReport,
    },
}

/// What came of a batch.
pub struct BatchResult {
    /// The summary.
    pub summary: Summary,
    /// Why it couldn't be written, if it couldn't.
    pub unwritten: Option<Error>,
}

/// Runs a batch of the assets of a manifest and writes its summary. `cancel` ends it soon: workers are ended, finished
/// assets stay.
///
/// # Errors
/// What keeps a batch from beginning: a folder that can't be used. Whatever comes later stands in the summary.
pub fn run(
    expanded: &Expanded,
    manifest: Option<&Path>,
    settings: &BatchSettings,
    on_event: &mut dyn FnMut(Event),
    cancel: &Cancel,
) -> Result<BatchResult, Error> {
    let start = Instant::now();
    let out = &settings.places.out;
    std::fs::create_dir_all(out).map_err(|source| Error::io(out, source))?;
    let (journal, past) = Journal::open(out, settings.shard)?;
    let known_names = past.names();
    let records = past.records;
    clear_folders(&settings.places, &expanded.assets);
    let own = match settings.shard {
        Some(shard) => {
            let part = own_part(&expanded.assets, shard, settings, cancel)?;
            part.into_iter().map(|(index, cost)| (index, Some(cost))).collect()
        }
        None => (0..expanded.assets.len()).map(|index| (index, None)).collect::<Vec<_>>(),
    };
    let assets: Vec<&PlannedAsset> = own.iter().map(|(index, _)| &expanded.assets[*index]).collect();
    let decisions = decisions(&assets, settings, &records);
    let items = assets.into_iter().zip(decisions).zip(own);
    let items = items.map(|((asset, decision), (position, estimate))| BatchItem {
        asset,
        decision,
        position,
        estimate,
        report: None,
    });
    let frame = frame(expanded, manifest, settings);
    let running = RunningPage { frame, start, in_work: BTreeSet::new(), written: None };
    let items = items.collect();
    let mut batch = Batch { journal, records, settings, on_event, items, running, failure: None };
    if !cancel.is_cancelled() {
        batch.work(cancel);
    }
    let interrupted = cancel.is_cancelled();
    let tidied = leftovers(expanded, settings, known_names, interrupted)?;
    let (summary, journal) = batch.finish(interrupted);
    let summary = Summary {
        notes: [&summary.notes[..], &tidied.notes].concat(),
        leftovers: tidied.left,
        seconds: start.elapsed().as_secs_f64(),
        ..summary
    };
    let unwritten = publish(&summary, out).and_then(|()| journal.end()).err();
    Ok(BatchResult { summary, unwritten })
}

/// The summary without the assets.
fn frame(expanded: &Expanded, manifest: Option<&Path>, settings: &BatchSettings) -> Summary {
    Summary {
        version: SUMMARY_VERSION,
        program_version: env!("CARGO_PKG_VERSION").into(),
        manifest: manifest.map(|path| relative(path, &settings.places.out)),
        plan: expanded.fingerprint(),
        notes: [&expanded.notes[..], &expanded.unreadable].concat(),
        left_out: expanded.left_out.clone(),
        unreadable: expanded.unreadable.clone(),
        shard: settings.shard,
        tags: settings.tags.clone(),
        jobs: settings.jobs,
        threads: settings.threads,
        ..Summary::default()
    }
}

/// After the work, which may take assets of earlier names for new ones. Only if it is sure what the manifest has.
fn leftovers(
    expanded: &Expanded,
    settings: &BatchSettings,
    known: BTreeSet<String>,
    interrupted: bool,
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

/// Removes the unfinished files of batches that were killed.
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

/// A page that takes longer than this to write isn't written at every event.
const QUICK: Duration = Duration::from_millis(100);
/// So many times as long as it took, it is left alone then.
const PAUSES: u32 = 10;

/// The page of the batch while it is at work.
struct RunningPage {
    /// The summary without assets.
    frame: Summary,
    /// When the batch began.
    start: Instant,
    /// Indices of the assets that are in work.
    in_work: BTreeSet<usize>,
    /// When the page was written, and how long that took.
    written: Option<(Instant, Duration)>,
}

struct Batch<'a, 'e> {
    journal: Journal,
    records: Records,
    settings: &'a BatchSettings,
    on_event: &'a mut dyn FnMut(Event<'_>),
    items: Vec<BatchItem<'e>>,
    running: RunningPage,
    /// Why nothing more was begun.
    failure: Option<String>,
}

impl Batch<'_, '_> {
    /// An error after the beginning is told in the summary.
    fn work(&mut self, cancel: &Cancel) {
        let BatchSettings { worker, jobs, max_memory, .. } = self.settings;
        let mut pool = WorkerPool::new(worker, *jobs, *max_memory, cancel);
        self.settle_the_easy();
        let worked = self.estimate(&mut pool).and_then(|()| self.make(&mut pool));
        if let Err(error) = worked {
            self.failure = Some(error.to_string());
        }
    }

    /// Those that are as they should be, and those that can't be made.
    fn settle_the_easy(&mut self) {
        let is_open = |item: &&BatchItem| matches!(item.decision.action, Action::Make(..));
        let to_make = self.items.iter().filter(is_open).count();
        (self.on_event)(Event::Checked { assets: self.items.len(), to_make });
        for index in 0..self.items.len() {
            let item = &self.items[index];
            let report = match &item.decision.action {
                Action::Keep(found) => {
                    self.forget_rejected(item, found);
                    kept(item, found, self.records.get(&item.asset.name))
                }
                Action::Fail(error) => failed(item, error.clone()),
                Action::Make(..) => continue,
            };
            self.settle(None, index, report);
        }
    }

    /// What was refused between is of another time, if the good asset is the wanted one again.
    fn forget_rejected(&self, item: &BatchItem, found: &Kept) {
        if !found.is_rejected {
            self.settings.places.files(&item.asset.name, None, true).rejected.forget();
        }
    }

    fn settle(&mut self, slot: Option<usize>, index: usize, report: AssetReport) {
        (self.on_event)(Event::Finished { slot, report: &report });
        // What is unchanged stands in the last summary already. Without a note the next batch has to look at the asset.
        if !matches!(report.outcome, Outcome::Unchanged | Outcome::Failed | Outcome::NotTried) {
            let _ = self.journal.note(&report);
        }
        self.items[index].report = Some(report);
    }

    fn estimate(&mut self, pool: &mut WorkerPool) -> Result<(), Error> {
        let is_open = |item: &BatchItem| item.report.is_none() && item.estimate.is_none();
        let items = self.items.iter().enumerate().filter(|(_, item)| is_open(item));
        let assets: Vec<(usize, &PlannedAsset)> = items.map(|(index, item)| (index, item.asset)).collect();
        for (index, estimate) in estimates(&assets, self.settings, pool)? {
            self.items[index].estimate = Some(estimate);
        }
        for index in 0..self.items.len() {
            let item = &self.items[index];
            let (None, Some(estimate)) = (&item.report, &item.estimate) else { continue };
            if let Err(error) = within(estimate, self.settings.max_memory) {
                self.settle(None, index, failed(item, error));
            }
        }
        Ok(())
    }

    fn make(&mut self, pool: &mut WorkerPool) -> Result<(), Error> {
        let open = self.items.iter().enumerate().filter(|(_, item)| item.report.is_none());
        let costs: Vec<(usize, Cost)> =
            open.filter_map(|(index, item)| Some((index, item.cost()?))).collect();
        (self.on_event)(Event::Estimated(costs.iter().map(|(_, cost)| cost.seconds).sum()));
        self.show();
        let BatchSettings { jobs, threads, max_memory, .. } = *self.settings;
        let mut queue = JobQueue::new(&costs, jobs, threads, max_memory);
        pool.run(&mut queue, self)
    }

    fn finish(mut self, interrupted: bool) -> (Summary, Journal) {
        let why = match &self.failure {
            Some(failure) => failure.clone(),
            None => "the batch was stopped before".into(),
        };
        for index in 0..self.items.len() {
            if self.items[index].report.is_none() {
                let item = &self.items[index];
                let report = AssetReport { reason: why.clone(), ..blank(item, Outcome::NotTried) };
                self.settle(None, index, report);
            }
        }
        let assets: Vec<AssetReport> = self.items.into_iter().filter_map(|item| item.report).collect();
        let summary = Summary { interrupted, counts: Counts::of(&assets), assets, ..self.running.frame };
        (summary, self.journal)
    }

    /// Writes the page as far as the batch is. Without it the batch does as well: errors are told at its end.
    fn show(&mut self) {
        let begin = Instant::now();
        let is_early = |(at, took): (Instant, Duration)| took > QUICK && begin - at < PAUSES * took;
        if self.running.written.is_some_and(is_early) {
            return;
        }
        let report = |item: &BatchItem| item.report.clone().unwrap_or_else(|| blank(item, Outcome::NotTried));
        let assets: Vec<AssetReport> = self.items.iter().map(report).collect();
        let open = self.items.iter().filter(|item| item.report.is_none());
        let left: f64 = open.filter_map(|item| Some(item.cost()?.seconds)).sum();
        let running = Running {
            in_work: self.running.in_work.iter().map(|index| self.items[*index].position).collect(),
            seconds_left: Some(left / self.settings.threads as f64),
        };
        let summary = Summary {
            counts: Counts::of(&assets),
            assets,
            seconds: self.running.start.elapsed().as_secs_f64(),
            ..self.running.frame.clone()
        };
        let _ = publish_running(&summary, &running, &self.settings.places.out);
        self.running.written = Some((Instant::now(), begin.elapsed()));
    }
}

impl JobHandler for Batch<'_, '_> {
    fn job(&mut self, assignment: &Assignment) -> (Job, Limits) {
        let BatchItem { asset, decision, .. } = &self.items[assignment.index];
        let identity = decision.identity.clone().unwrap_or_default();
        let files = self.settings.places.files(&asset.name, Some(&identity.key), asset.report);
        let candidates = match &decision.action {
            Action::Make(_, candidates) => candidates.clone(),
            _ => Vec::new(),
        };
        let task = MakeTask {
            input: bake_input(asset),
            identity,
            gates: asset.gates,
            max_memory: self.settings.max_memory,
            candidates,
            files,
        };
        let job = Job { task: Task::Make(Box::new(task)), threads: assignment.threads };
        let limits = Limits {
            bake: asset.timeout.or(self.settings.timeout),
            report: asset.report_timeout.or(self.settings.report_timeout),
        };
        (job, limits)
    }

    fn started(&mut self, slot: usize, assignment: &Assignment) {
        (self.on_event)(Event::Started { slot, name: &self.items[assignment.index].asset.name });
        self.running.in_work.insert(assignment.index);
        self.show();
    }

    fn step(&mut self, slot: usize, assignment: &Assignment, step: &str) {
        (self.on_event)(Event::Step { slot, name: &self.items[assignment.index].asset.name, step });
    }

    fn finished(
        &mut self,
        slot: usize,
        assignment: &Assignment,
        reply: Result<Reply, String>,
    ) -> Result<bool, Error> {
        let item = &self.items[assignment.index];
        let mut is_full = false;
        let report = match reply {
            Ok(Reply::Made(result)) => made(item, *result, assignment.threads, &self.settings.places),
            Ok(Reply::Failed { error, disk_full }) => {
                is_full = disk_full;
                failed(item, error)
            }
            Ok(other) => failed(item, format!("its worker answered {other:?}")),
            Err(error) => failed(item, error),
        };
        if is_full {
            self.failure = Some("the disk was full before; make room, and run the batch again".into());
        }
        self.settle(Some(slot), assignment.index, report);
        self.running.in_work.remove(&assignment.index);
        self.show();
        Ok(!is_full)
    }
}
