//! What came of an asset, as the summary has it.

use super::gates;
use super::item::BatchItem;
use super::job::MakeResult;
use super::places::{Places, names};
use super::state::{Action, Kept};
use super::summary::{AssetReport, Outcome};

/// Without a word on what came of it.
pub fn blank(item: &BatchItem, outcome: Outcome) -> AssetReport {
    let asset = item.asset;
    AssetReport {
        name: asset.name.clone(),
        position: item.position,
        mesh: asset.mesh_name.clone(),
        output: names(&asset.name, false).asset,
        tags: asset.tags.clone(),
        outcome,
        reason: String::new(),
        error: None,
        failed_gates: Vec::new(),
        identity: item.decision.identity.clone(),
        estimated_seconds: item.cost().map(|cost| cost.seconds),
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

/// One that can't be made.
pub fn failed(item: &BatchItem, error: String) -> AssetReport {
    let reason = match &item.decision.action {
        Action::Make(reason, _) => reason.clone(),
        _ => String::new(),
    };
    AssetReport { reason, error: Some(error), ..blank(item, Outcome::Failed) }
}

/// An asset that was made, where its files lie.
pub fn made(item: &BatchItem, result: MakeResult, threads: usize, places: &Places) -> AssetReport {
    let Action::Make(reason, _) = &item.decision.action else { unreachable!("only these are made") };
    let name = &item.asset.name;
    let outcome = match (&result.from, gates::outcome(&result.failed_gates)) {
        (_, Some(bad)) => bad,
        (Some(from), None) if *from == places.out.join(names(name, false).asset) => Outcome::Unchanged,
        (Some(_), None) => Outcome::Reused,
        (None, None) => Outcome::Built,
    };
    let mut reason = reason.clone();
    if let (Some(from), Outcome::Reused) = (&result.from, outcome) {
        reason += &format!("; the same asset lay in {}", from.display());
    }
    result.notes.iter().for_each(|note| reason += &format!("; {note}"));
    AssetReport {
        reason,
        failed_gates: gates::texts(&result.failed_gates),
        seconds: Some(result.seconds),
        threads: Some(threads),
        peak_memory: result.peak_memory,
        bytes: Some(result.bytes),
        file_blake3: Some(result.file_blake3),
        figures: Some(result.figures),
        ..placed(item, outcome, !result.failed_gates.is_empty())
    }
}

fn placed(item: &BatchItem, outcome: Outcome, is_rejected: bool) -> AssetReport {
    let names = names(&item.asset.name, is_rejected);
    AssetReport {
        output: names.asset,
        preview: Some(names.preview),
        report: item.asset.report.then_some(names.report),
        ..blank(item, outcome)
    }
}

/// An asset that stays as it is.
pub fn kept(item: &BatchItem, found: &Kept, record: Option<&AssetReport>) -> AssetReport {
    let outcome = gates::outcome(&found.failed_gates).unwrap_or(Outcome::Unchanged);
    // Times are those of the same file.
    let record = record.filter(|record| record.file_blake3.as_ref() == Some(&found.file_blake3));
    AssetReport {
        reason: "up to date: same mesh, parameters and program".into(),
        failed_gates: gates::texts(&found.failed_gates),
        estimated_seconds: record.and_then(|record| record.estimated_seconds),
        seconds: record.and_then(|record| record.seconds),
        threads: record.and_then(|record| record.threads),
        peak_memory: record.and_then(|record| record.peak_memory),
        bytes: Some(found.bytes),
        file_blake3: Some(found.file_blake3.clone()),
        figures: Some(found.figures.clone()),
        ..placed(item, outcome, found.is_rejected)
    }
}
