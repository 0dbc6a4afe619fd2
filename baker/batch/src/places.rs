//! Where everything of a batch lies.
//!
//! ```text
//! OUT/NAME.h5                    the asset
//! OUT/rejected/NAME.h5           the asset, if a gate refused it, with its picture and report
//! OUT/reports/NAME.preview.png   its picture
//! OUT/reports/NAME.report.html   its report, and .json
//! OUT/summary.json, .html, junit.xml (of a shard: summary.2-of-4.json, ...)
//! OUT/.volmap-batch.jsonl        what a batch in work has done so far
//! CACHE/ab/ab12...ef.h5          an asset by its content key
//! ```

use super::job::{AssetFiles, OutputFiles};
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

/// An asset and what belongs to it, relative to the output folder.
pub struct Names {
    /// The asset.
    pub asset: String,
    /// Its picture.
    pub preview: String,
    /// Its report.
    pub report: String,
}

/// The files of an asset, good or rejected.
pub fn names(name: &str, is_rejected: bool) -> Names {
    let (asset, rest) = if is_rejected { ("rejected/", "rejected/") } else { ("", "reports/") };
    Names {
        asset: format!("{asset}{name}.h5"),
        preview: format!("{rest}{name}.preview.png"),
        report: format!("{rest}{name}.report.html"),
    }
}

/// `STEM.ENDING` of a batch, or that of a part of it.
pub fn of_part(stem: &str, ending: &str, shard: Option<Shard>, tags: &[String]) -> String {
    let plain = |tag: &String| tag.replace(|c: char| !c.is_alphanumeric() && c != '-', "_");
    let tags: String = tags.iter().map(|tag| format!(".tag-{}", plain(tag))).collect();
    match shard {
        None => format!("{stem}{tags}.{ending}"),
        Some(Shard { index, count }) => format!("{stem}{tags}.{index}-of-{count}.{ending}"),
    }
}

impl Places {
    /// Files of an asset with this name and, for its place in the cache, key.
    pub fn files(&self, name: &str, key: Option<&str>, with_report: bool) -> OutputFiles {
        let files = |is_rejected| {
            let names = names(name, is_rejected);
            AssetFiles {
                asset: self.out.join(names.asset),
                preview: self.out.join(names.preview),
                report: with_report.then(|| self.out.join(names.report)),
            }
        };
        OutputFiles {
            good: files(false),
            rejected: files(true),
            cached: self.cache.as_deref().zip(key).map(|(cache, key)| cached(cache, key)),
        }
    }
}

fn cached(cache: &Path, key: &str) -> PathBuf {
    cache.join(&key[..2]).join(format!("{key}.h5"))
}
