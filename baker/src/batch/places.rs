//! Where everything of a batch lies.
//!
//! ```text
//! OUT/NAME.h5                    the asset
//! OUT/rejected/NAME.h5           the asset, if a gate refused it
//! OUT/reports/NAME.preview.png   its picture
//! OUT/reports/NAME.report.html   its report, and .json
//! OUT/summary.json, .html, junit.xml (of a shard: summary.2-of-4.json, ...)
//! OUT/.volmap-batch.jsonl        what a batch in work has done so far
//! CACHE/ab/ab12...ef.h5          an asset by its content key
//! ```

use super::job::Files;
use super::make::with_ending;
use super::summary::Shard;
use std::path::{Path, PathBuf};

/// The output folder and the cache.
#[derive(Clone, Debug)]
pub struct Places {
    /// The output folder.
    pub out: PathBuf,
    /// The cache, if there is one.
    pub cache: Option<PathBuf>,
}

/// The asset's file, relative to the output folder.
pub fn output(name: &str) -> String {
    format!("{name}.h5")
}

/// Its picture.
pub fn preview(name: &str) -> String {
    format!("reports/{name}.preview.png")
}

/// Its report.
pub fn report(name: &str) -> String {
    format!("reports/{name}.report.html")
}

/// Where it lies if a gate refused it.
pub fn rejected(name: &str) -> String {
    format!("rejected/{name}.h5")
}

/// `STEM.ENDING` of a batch, or that of a shard.
pub fn of_shard(stem: &str, ending: &str, shard: Option<Shard>) -> String {
    match shard {
        None => format!("{stem}.{ending}"),
        Some(Shard { index, count }) => format!("{stem}.{index}-of-{count}.{ending}"),
    }
}

impl Places {
    /// Files of an asset with this name and key.
    pub fn files(&self, name: &str, key: &str, with_report: bool) -> Files {
        Files {
            output: self.out.join(output(name)),
            rejected: self.out.join(rejected(name)),
            cached: self.cache.as_deref().map(|cache| cached(cache, key)),
            preview: self.out.join(preview(name)),
            report: with_report.then(|| with_ending(&self.out.join("reports").join(name), ".report")),
        }
    }
}

fn cached(cache: &Path, key: &str) -> PathBuf {
    cache.join(&key[..2]).join(format!("{key}.h5"))
}
