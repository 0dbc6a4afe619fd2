//! Parts of a batch for several machines, which see the same files and nothing of each other.

use super::job::Cost;
use super::summary::Shard;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::env::VarError;

/// Which shard each asset belongs to, from 0: the longest first, each to the shard with the least to do so far (Graham
/// 1969). Depends on the costs alone. Without a cost (a mesh that can't be read) an asset costs nothing.
pub fn partition(costs: &[Option<Cost>], count: u32) -> Vec<u32> {
    let seconds = |index: usize| costs[index].map_or(0.0, |cost| cost.seconds);
    let mut order: Vec<usize> = (0..costs.len()).collect();
    order.sort_by(|&i, &j| seconds(j).total_cmp(&seconds(i)).then(i.cmp(&j)));
    // Nanoseconds: they add up alike in any order, and compare.
    let nanoseconds = |index: usize| (1e9 * seconds(index)) as u64;
    let mut loads: BinaryHeap<Reverse<(u64, usize, u32)>> =
        (0..count).map(|shard| Reverse((0, 0, shard))).collect();
    let mut out = vec![0; costs.len()];
    for index in order {
        let Some(Reverse((load, assets, shard))) = loads.pop() else { break };
        loads.push(Reverse((load.saturating_add(nanoseconds(index)), assets + 1, shard)));
        out[index] = shard;
    }
    out
}

/// `I/N`, counted from 1; `auto`: both from the environment of an array job; `auto/N`: the index from there.
///
/// # Errors
/// Another text; an index that isn't among 1 to N; an environment that doesn't say.
pub fn parse(text: &str, variable: &dyn Fn(&str) -> Result<String, VarError>) -> Result<Shard, String> {
    let (index, count) = match text.split_once('/') {
        None if text == "auto" => from_environment(None, variable)?,
        Some(("auto", count)) => from_environment(Some(number(count)?), variable)?,
        Some((index, count)) => (number(index)?, number(count)?),
        None => return Err("give I/N, as 2/4, or auto, or auto/N".into()),
    };
    match (1..=count).contains(&index) {
        true => Ok(Shard { index, count }),
        false => Err(format!("shard {index} of {count}: the index is from 1 to {count}")),
    }
}

fn number(text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|count| (1..=100_000).contains(count));
    count.ok_or_else(|| format!("`{text}` is not a number from 1 to 100000"))
}

/// Where array jobs find their index: its name, that of the first index (or 0), that of their number if there is one.
const ARRAYS: [(&str, Option<&str>, Option<&str>); 4] = [
    ("SLURM_ARRAY_TASK_ID", Some("SLURM_ARRAY_TASK_MIN"), Some("SLURM_ARRAY_TASK_COUNT")),
    ("AWS_BATCH_JOB_ARRAY_INDEX", None, Some("AWS_BATCH_JOB_ARRAY_SIZE")),
    // Kubernetes' indexed jobs.
    ("JOB_COMPLETION_INDEX", None, None),
    // OpenCue.
    ("CUE_IFRAME", None, None),
];

/// OpenCue's frames begin with 1 as a rule.
const COUNTED_FROM_ONE: &str = "CUE_IFRAME";

fn from_environment(
    count: Option<u32>,
    variable: &dyn Fn(&str) -> Result<String, VarError>,
) -> Result<(u32, u32), String> {
    let read = |name: &str| -> Result<Option<u32>, String> {
        match variable(name) {
            Ok(text) => text.parse().map(Some).map_err(|_| format!("{name}=`{text}` is not a number")),
            Err(_) => Ok(None),
        }
    };
    if let Some(step) = read("SLURM_ARRAY_TASK_STEP")?.filter(|step| *step != 1) {
        return Err(format!("the array's step is {step}, not 1; give I/N"));
    }
    for (name, first, number) in ARRAYS {
        let Some(index) = read(name)? else { continue };
        let default = u32::from(name == COUNTED_FROM_ONE);
        let first = first.map(read).transpose()?.flatten().unwrap_or(default);
        if first > 1 {
            return Err(format!("the array begins with {first}: it is a part of one; give I/N"));
        }
        let counted = number.map(read).transpose()?.flatten();
        let Some(count) = count.or(counted) else {
            return Err(format!("{name} tells the index, but nothing how many there are; give auto/N"));
        };
        let index = index.checked_sub(first).and_then(|index| index.checked_add(1));
        return index.map(|index| (index, count)).ok_or_else(|| format!("{name} is less than {first}"));
    }
    let names: Vec<&str> = ARRAYS.iter().map(|(name, ..)| *name).collect();
    Err(format!("none of {} is set: this is no array job; give I/N", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parsed(text: &str, environment: &[(&str, &str)]) -> Result<Shard, String> {
        let find = |name: &str| environment.iter().find(|(known, _)| *known == name);
        parse(text, &|name| find(name).map(|(_, value)| (*value).to_owned()).ok_or(VarError::NotPresent))
    }

    #[test]
    fn shards_are_named_or_found() {
        let shard = |index, count| Ok(Shard { index, count });
        assert_eq!(parsed("2/4", &[]), shard(2, 4));
        let slurm =
            [("SLURM_ARRAY_TASK_ID", "3"), ("SLURM_ARRAY_TASK_MIN", "1"), ("SLURM_ARRAY_TASK_COUNT", "4")];
        assert_eq!(parsed("auto", &slurm), shard(3, 4));
        assert_eq!(
            parsed("auto", &[("SLURM_ARRAY_TASK_ID", "0"), ("SLURM_ARRAY_TASK_COUNT", "2")]),
            shard(1, 2)
        );
        let aws = [("AWS_BATCH_JOB_ARRAY_INDEX", "3"), ("AWS_BATCH_JOB_ARRAY_SIZE", "4")];
        assert_eq!(parsed("auto", &aws), shard(4, 4));
        assert_eq!(parsed("auto/4", &[("JOB_COMPLETION_INDEX", "0")]), shard(1, 4));
        assert_eq!(parsed("auto/4", &[("CUE_IFRAME", "4")]), shard(4, 4));
        for (text, environment, says) in [
            ("0/4", &[][..], "not a number from 1"),
            ("5/4", &[], "from 1 to 4"),
            ("x", &[], "give I/N"),
            ("auto", &[], "no array job"),
            ("auto", &[("JOB_COMPLETION_INDEX", "0")], "auto/N"),
            ("auto/2", &[("JOB_COMPLETION_INDEX", "2")], "shard 3 of 2"),
            ("auto/2", &[("CUE_IFRAME", "0")], "less than 1"),
            ("auto/4", &[("SLURM_ARRAY_TASK_ID", "3"), ("SLURM_ARRAY_TASK_MIN", "3")], "part of one"),
            ("auto/4", &[("SLURM_ARRAY_TASK_ID", "2"), ("SLURM_ARRAY_TASK_STEP", "2")], "step is 2"),
            ("auto/2", &[("JOB_COMPLETION_INDEX", "x")], "not a number"),
        ] {
            let error = parsed(text, environment).unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn shards_are_even(seconds in prop::collection::vec(0.0f64..10.0, 0..60), count in 1u32..9) {
            let costs: Vec<_> = seconds.iter().map(|&s| Some(Cost { seconds: s, ..Cost::default() })).collect();
            let shards = partition(&costs, count);
            let load = |shard| {
                let own = shards.iter().zip(&seconds).filter(|(of, _)| **of == shard);
                own.map(|(_, s)| s).sum::<f64>()
            };
            let loads: Vec<f64> = (0..count).map(load).collect();
            let (most, least) = loads.iter().fold((0.0f64, f64::MAX), |(m, l), &x| (m.max(x), l.min(x)));
            // The shard with the most had less than all others before its last.
            prop_assert!(most - least <= seconds.iter().copied().fold(0.0, f64::max) + 1e-9);
        }
    }

    #[test]
    fn assets_without_cost_are_spread() {
        let shards = partition(&[None; 6], 3);
        assert!((0..3).all(|shard| shards.iter().filter(|of| **of == shard).count() == 2));
    }
}
