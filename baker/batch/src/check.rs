//! A batch before it is run: what would be made, and what it would cost.

use super::assets::Expanded;
use super::estimates::{Estimates, estimates, own_part, within};
use super::job::Cost;
use super::journal::past;
use super::pool::WorkerPool;
use super::queue::{Assignment, JobQueue};
use super::settings::BatchSettings;
use super::state::{Action, decisions};
use crate::error::Error;
use serde_json::{Value, json};
use volmap_bake::watch::Cancel;

/// What would come of a batch.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Each asset.
    pub assets: Vec<Checked>,
    /// Wall time of those that would be made, seconds.
    pub seconds: f64,
    /// Most memory at once, bytes.
    pub memory: u64,
    /// Size of their files, bytes.
    pub files: u64,
}

/// What would come of an asset.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// Its name.
    pub name: String,
    /// Why it would be made; none if it would stay.
    pub reason: Option<String>,
    /// What it would cost, or why it can't be made.
    pub cost: Result<Cost, String>,
    /// What a careful person would look at.
    pub warnings: Vec<String>,
}

impl Check {
    /// For programs: a list of assets, each with a cost or an error, and the sums.
    pub fn to_json(&self) -> Value {
        let asset = |asset: &Checked| match &asset.cost {
            Ok(cost) => json!({
                "name": asset.name, "reason": asset.reason, "cost": cost, "warnings": asset.warnings
            }),
            Err(error) => json!({ "name": asset.name, "reason": asset.reason, "error": error }),
        };
        let assets: Vec<Value> = self.assets.iter().map(asset).collect();
        json!({ "assets": assets, "seconds": self.seconds, "memory": self.memory, "files": self.files })
    }
}

/// A dry run: compares and estimates everything, and makes nothing.
///
/// # Errors
/// A worker that can't be started.
pub fn check(expanded: &Expanded, settings: &BatchSettings, cancel: &Cancel) -> Result<Check, Error> {
    let own: Estimates = match settings.shard {
        Some(shard) => own_part(&expanded.assets, shard, settings, cancel)?,
        None => {
            let all: Vec<_> = expanded.assets.iter().enumerate().collect();
            let mut pool = WorkerPool::new(&settings.worker, settings.jobs, settings.max_memory, cancel);
            let mut found = estimates(&all, settings, &mut pool)?;
            found.sort_by_key(|(index, _)| *index);
            found
        }
    };
    let assets: Vec<_> = own.iter().map(|(index, _)| &expanded.assets[*index]).collect();
    let decisions = decisions(&assets, settings, &past(&settings.places.out, settings.shard).records);
    let checked = own.iter().zip(&assets).zip(decisions).map(|(((_, estimate), asset), decision)| {
        let (reason, fault) = match decision.action {
            Action::Keep(_) => (None, None),
            Action::Make(reason, _) => (Some(reason), None),
            Action::Fail(error) => (Some(String::new()), Some(error)),
        };
        let cost = fault.map_or_else(|| within(estimate, settings.max_memory), Err);
        let warnings = estimate.as_ref().map_or(Vec::new(), |estimate| estimate.warnings.clone());
        Checked { name: asset.name.clone(), reason, cost, warnings }
    });
    let assets: Vec<Checked> = checked.collect();
    let made = assets.iter().filter(|asset| asset.reason.is_some());
    let to_make: Vec<Cost> = made.filter_map(|asset| asset.cost.as_ref().ok().copied()).collect();
    let (seconds, memory) = simulate(&to_make, settings);
    Ok(Check { assets, seconds, memory, files: to_make.iter().map(|cost| cost.file).sum() })
}

/// Wall time and memory of the queue, if the estimates were exact and threads didn't hinder each other.
fn simulate(costs: &[Cost], settings: &BatchSettings) -> (f64, u64) {
    let numbered: Vec<(usize, Cost)> = costs.iter().copied().enumerate().collect();
    let mut queue = JobQueue::new(&numbered, settings.jobs, settings.threads, settings.max_memory);
    let mut running: Vec<(f64, Assignment)> = Vec::new();
    let (mut now, mut most) = (0.0, 0);
    loop {
        while let Some(job) = queue.take() {
            running.push((now + costs[job.index].seconds / job.threads as f64, job));
        }
        most = most.max(running.iter().map(|(_, job)| job.memory).sum());
        let first = running.iter().enumerate().min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0));
        let Some(first) = first.map(|(at, _)| at) else { return (now, most) };
        let (end, job) = running.swap_remove(first);
        now = end;
        queue.release(&job);
    }
}
