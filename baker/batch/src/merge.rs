//! The summaries of a batch's parts as that of the whole.

use super::summary::{AssetReport, Counts, Shard, Summary};
use crate::error::Error;

/// Joins the summaries of all parts of a batch. Its wall time is that of the longest part, as if they had run side by
/// side; its jobs and threads are those of all parts together.
///
/// # Errors
/// Parts that are missing, there twice, or not of the same batch.
pub fn merge(mut parts: Vec<Summary>) -> Result<Summary, Error> {
    let shards = shards(&parts)?;
    require_all(&shards)?;
    require_same_batch(&parts)?;
    let notes = joined(&parts, |part| &part.notes);
    let unreadable = joined(&parts, |part| &part.unreadable);
    let leftovers = joined(&parts, |part| &part.leftovers);
    let mut assets: Vec<AssetReport> =
        parts.iter_mut().flat_map(|part| std::mem::take(&mut part.assets)).collect();
    assets.sort_by_key(|asset| asset.position);
    require_each_once(&assets)?;
    let first = &parts[0];
    Ok(Summary {
        version: first.version,
        program_version: first.program_version.clone(),
        manifest: first.manifest.clone(),
        shard: None,
        tags: Vec::new(),
        interrupted: parts.iter().any(|part| part.interrupted),
        counts: Counts::of(&assets),
        seconds: parts.iter().map(|part| part.seconds).fold(0.0, f64::max),
        jobs: parts.iter().map(|part| part.jobs).sum(),
        threads: parts.iter().map(|part| part.threads).sum(),
        notes,
        left_out: first.left_out.clone(),
        unreadable,
        leftovers,
        plan: first.plan.clone(),
        assets,
    })
}

fn refused(reason: impl Into<String>) -> Error {
    Error::setting("merge", reason)
}

/// Which parts they are.
fn shards(parts: &[Summary]) -> Result<Vec<Shard>, Error> {
    let shard = |part: &Summary| {
        part.shard
            .ok_or_else(|| refused("one of the summaries is of a whole batch; give those of parts alone"))
    };
    parts.iter().map(shard).collect()
}

/// All of 1 to N, once.
fn require_all(shards: &[Shard]) -> Result<(), Error> {
    let Some(first) = shards.first() else { return Err(refused("there is no summary to merge")) };
    let count = first.count;
    if let Some(other) = shards.iter().find(|shard| shard.count != count) {
        return Err(refused(format!(
            "some summaries are of {count} parts and some of {}; remove those of the older batch",
            other.count
        )));
    }
    if let Some(wrong) = shards.iter().find(|shard| !(1..=count).contains(&shard.index)) {
        return Err(refused(format!("there can't be a part {} of {count}", wrong.index)));
    }
    let mut indices: Vec<u32> = shards.iter().map(|shard| shard.index).collect();
    indices.sort_unstable();
    let double: Vec<u32> =
        indices.chunk_by(|a, b| a == b).filter(|same| same.len() > 1).map(|same| same[0]).collect();
    if !double.is_empty() {
        return Err(refused(format!("{} there more than once, of {count}; give each once", named(&double))));
    }
    if indices.len() < count as usize {
        let missing: Vec<u32> = (1..=count).filter(|index| indices.binary_search(index).is_err()).collect();
        return Err(refused(format!("{} missing, of {count}; run these shards first", named(&missing))));
    }
    Ok(())
}

/// How many parts a message names.
const NAMED: usize = 8;

/// `part 3 is`, `parts 1, 2 and 4 more are`.
fn named(indices: &[u32]) -> String {
    let list: Vec<String> = indices.iter().take(NAMED).map(u32::to_string).collect();
    let list = list.join(", ");
    match indices.len() {
        1 => format!("part {list} is"),
        n if n > NAMED => format!("parts {list} and {} more are", n - NAMED),
        _ => format!("parts {list} are"),
    }
}

fn require_same_batch(parts: &[Summary]) -> Result<(), Error> {
    let first = &parts[0];
    let index = |part: &Summary| part.shard.map_or(0, |shard| shard.index);
    for part in &parts[1..] {
        if part.program_version != first.program_version {
            return Err(refused(format!(
                "part {} is by version {} of the program and part {} by {}; run both with the same one",
                index(first),
                first.program_version,
                index(part),
                part.program_version
            )));
        }
        if part.plan != first.plan && part.manifest == first.manifest {
            return Err(refused(format!(
                "the manifest changed between part {} and part {}; run the older ones again",
                index(first),
                index(part)
            )));
        }
        if part.manifest != first.manifest {
            let name = |part: &Summary| part.manifest.clone().unwrap_or_else(|| "no manifest".into());
            return Err(refused(format!(
                "part {} is of {} and part {} of {}; merge parts of one batch",
                index(first),
                name(first),
                index(part),
                name(part)
            )));
        }
    }
    Ok(())
}

/// That each place of the manifest's order is taken once; `assets` are sorted by it.
fn require_each_once(assets: &[AssetReport]) -> Result<(), Error> {
    let cure = "the parts were run on different manifests or meshes; run them again on the same";
    match assets.iter().enumerate().find(|(place, asset)| asset.position != *place) {
        None => Ok(()),
        Some((place, asset)) if asset.position < place => Err(refused(format!(
            "{} and {} have the same place in the manifest; {cure}",
            assets[place - 1].name,
            asset.name
        ))),
        Some((_, asset)) => Err(refused(format!("what comes before {} is in no part; {cure}", asset.name))),
    }
}

/// The notes of all parts, each once.
fn joined(parts: &[Summary], of: impl Fn(&Summary) -> &Vec<String>) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for note in parts.iter().flat_map(of) {
        if !out.contains(note) {
            out.push(note.clone());
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::fixture::mixed;
    use super::*;

    /// The batch in so many parts, its assets dealt out by turns.
    fn parts(whole: &Summary, count: u32) -> Vec<Summary> {
        let part = |index: u32| {
            let mine = |asset: &&AssetReport| asset.position as u32 % count == index - 1;
            let assets: Vec<AssetReport> = whole.assets.iter().filter(mine).cloned().collect();
            Summary {
                shard: Some(Shard { index, count }),
                counts: Counts::of(&assets),
                seconds: f64::from(index),
                assets,
                ..whole.clone()
            }
        };
        (1..=count).map(part).collect()
    }

    fn refusal(parts: Vec<Summary>) -> String {
        merge(parts).unwrap_err().to_string()
    }

    #[test]
    fn parts_make_the_whole() {
        let mut whole = mixed();
        whole.notes = vec!["one".into(), "two".into()];
        let mut given = parts(&whole, 4);
        given[1].notes = vec!["two".into()];
        given[3].interrupted = false;
        given.rotate_left(3);
        let merged = merge(given).unwrap();
        assert_eq!((merged.seconds, merged.jobs, merged.threads), (4.0, 8, 8));
        assert_eq!(merged, Summary { seconds: 4.0, jobs: 8, threads: 8, ..whole.clone() });
        let one = merge(parts(&whole, 1)).unwrap();
        assert_eq!(one, Summary { seconds: 1.0, ..whole });
    }

    #[test]
    fn parts_without_assets_count() {
        let merged = merge(parts(&mixed(), 20)).unwrap();
        assert_eq!((merged.assets.len(), merged.counts), (6, mixed().counts));
    }

    #[test]
    fn missing_and_double_parts_are_named() {
        let given = || parts(&mixed(), 4);
        assert!(refusal(Vec::new()).contains("no summary"));
        let missing = given().into_iter().filter(|part| part.shard.unwrap().index % 2 == 1).collect();
        assert!(refusal(missing).contains("parts 2, 4 are missing, of 4; run these"));
        let double = given().into_iter().chain([given()[2].clone()]).collect();
        assert!(refusal(double).contains("part 3 is there more than once, of 4"));
        assert!(refusal(vec![mixed()]).contains("whole batch"));
        let other = given().into_iter().chain(parts(&mixed(), 3)).collect();
        assert!(refusal(other).contains("of 4 parts and some of 3"));
        let mut wrong = given();
        wrong[0].shard = Some(Shard { index: 5, count: 4 });
        assert!(refusal(wrong).contains("part 5 of 4"));
        let few = parts(&mixed(), 1000).into_iter().take(1).collect();
        assert!(refusal(few).contains("parts 2, 3, 4, 5, 6, 7, 8, 9 and 991 more"));
    }

    #[test]
    fn parts_of_different_batches_are_refused() {
        let given = || parts(&mixed(), 3);
        let mut other = given();
        other[1].program_version = "0.2.0".into();
        assert!(refusal(other).contains("part 1 is by version 0.1.0 of the program and part 2 by 0.2.0"));
        let mut other = given();
        other[2].manifest = None;
        assert!(refusal(other).contains("part 3 of no manifest"));
        let mut other = given();
        other[1].assets[0].position = 0;
        assert!(refusal(other).contains("props/trees/oak and duck have the same place"));
        let mut other = given();
        other[1].assets.remove(0);
        assert!(refusal(other).contains("before tank is in no part"));
    }
}
