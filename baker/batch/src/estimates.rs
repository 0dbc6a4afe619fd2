//! Costs of many assets, found by the workers; and the part of a batch that is a shard's.

use super::assets::PlannedAsset;
use super::job::{BakeInput, Cost, Estimate, Job, Reply, Task};
use super::pool::{JobHandler, Limits, WorkerPool};
use super::queue::{Assignment, JobQueue};
use super::settings::BatchSettings;
use super::shard::partition;
use super::summary::Shard;
use crate::error::Error;
use volmap_bake::watch::Cancel;

/// Memory that reading a mesh takes, in bytes of its file: text grows in memory.
const MEMORY_PER_BYTE: u64 = 8;

/// Costs by index, or why there is none.
pub type Estimates = Vec<(usize, Result<Estimate, String>)>;

/// Estimates what assets cost. Those that had no assignment before the pool was stopped are left out.
///
/// # Errors
/// A worker that can't be started.
pub fn estimates(
    assets: &[(usize, &PlannedAsset)],
    settings: &BatchSettings,
    pool: &mut WorkerPool,
) -> Result<Estimates, Error> {
    // The largest files first.
    let size = |asset: &PlannedAsset| std::fs::metadata(&asset.mesh).map_or(0, |found| found.len());
    let cost = |size: u64| Cost {
        seconds: size as f64 + 1.0,
        memory: size.saturating_mul(MEMORY_PER_BYTE).min(settings.max_memory),
        file: 0,
    };
    let costs: Vec<(usize, Cost)> =
        assets.iter().enumerate().map(|(at, (_, asset))| (at, cost(size(asset)))).collect();
    // One thread reads a mesh.
    let jobs = settings.jobs.min(settings.threads);
    let mut queue = JobQueue::new(&costs, jobs, jobs, settings.max_memory);
    let mut estimator =
        Estimator { assets, timeout: settings.timeout, found: Vec::new(), all_or_none: false };
    pool.run(&mut queue, &mut estimator)?;
    Ok(estimator.found)
}

/// A shard's assets, in their order, and what they cost. Every machine finds the same: nothing is limited here, and a
/// worker that ends is an error.
///
/// # Errors
/// As [`estimates`]; a worker that ended; a batch that was stopped.
pub fn own_part(
    assets: &[PlannedAsset],
    shard: Shard,
    settings: &BatchSettings,
    cancel: &Cancel,
) -> Result<Estimates, Error> {
    let all: Vec<(usize, &PlannedAsset)> = assets.iter().enumerate().collect();
    let jobs = settings.jobs.min(settings.threads);
    let costs: Vec<(usize, Cost)> = all.iter().map(|(at, _)| (*at, Cost::default())).collect();
    let mut queue = JobQueue::new(&costs, jobs, jobs, 0);
    let mut estimator = Estimator { assets: &all, timeout: None, found: Vec::new(), all_or_none: true };
    WorkerPool::new(&settings.worker, jobs, u64::MAX, cancel).run(&mut queue, &mut estimator)?;
    if estimator.found.len() < assets.len() {
        return Err(Error::setting("shard", "the batch was stopped before its parts were found"));
    }
    let mut found = estimator.found;
    found.sort_by_key(|(index, _)| *index);
    let costs: Vec<Option<Cost>> = found.iter().map(|(_, found)| Some(found.as_ref().ok()?.cost)).collect();
    let shards = partition(&costs, shard.count);
    found.retain(|(index, _)| shards[*index] + 1 == shard.index);
    Ok(found)
}

struct Estimator<'a> {
    assets: &'a [(usize, &'a PlannedAsset)],
    /// Of assets whose manifest says nothing.
    timeout: Option<f64>,
    found: Estimates,
    all_or_none: bool,
}

impl JobHandler for Estimator<'_> {
    fn job(&mut self, assignment: &Assignment) -> (Job, Limits) {
        let asset = self.assets[assignment.index].1;
        let job = Job { task: Task::Estimate(Box::new(bake_input(asset))), threads: assignment.threads };
        let bake = asset.timeout.or(self.timeout).filter(|_| !self.all_or_none);
        (job, Limits { bake, report: None })
    }

    fn finished(
        &mut self,
        _: usize,
        assignment: &Assignment,
        reply: Result<Reply, String>,
    ) -> Result<bool, Error> {
        let (index, asset) = self.assets[assignment.index];
        let estimate = match reply {
            Ok(Reply::Estimated(estimate)) => Ok(estimate),
            Ok(Reply::Failed { error, .. }) => Err(error),
            Ok(other) => Err(format!("its worker answered {other:?}")),
            Err(how) if self.all_or_none => {
                return Err(Error::unusable(&asset.mesh, how));
            }
            Err(how) => Err(how),
        };
        self.found.push((index, estimate));
        Ok(true)
    }
}

/// The cost, if so much memory allows it.
///
/// # Errors
/// Why it can't be made, in words.
pub fn within(estimate: &Result<Estimate, String>, allowed: u64) -> Result<Cost, String> {
    let Estimate { cost, length, .. } = estimate.as_ref().map_err(String::clone)?;
    if cost.memory <= allowed {
        return Ok(*cost);
    }
    let reason = Box::new(volmap_bake::Error::Memory { needed: cost.memory, allowed });
    Err(volmap_bake::Error::Sized { about: length.clone(), reason }.to_string())
}

/// The mesh of an asset, and how it becomes one.
pub fn bake_input(asset: &PlannedAsset) -> BakeInput {
    BakeInput {
        mesh: asset.mesh.clone(),
        parameters: asset.parameters.clone(),
        error_points: asset.error_points,
        report: asset.report,
    }
}
