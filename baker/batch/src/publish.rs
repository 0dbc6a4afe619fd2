//! What a batch writes of itself: the summary, for programs, people and build servers.

use super::junit::junit;
use super::page::{Running, page, page_of_running};
use super::places::of_part;
use super::summary::Summary;
use crate::error::Error;
use std::path::Path;
use volmap_formats::asset;

/// A path as seen from a folder, if both can be found; else as it is.
pub fn relative(path: &Path, folder: &Path) -> String {
    let (Ok(path), Ok(folder)) = (path.canonicalize(), folder.canonicalize()) else {
        return path.display().to_string();
    };
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| "..".to_owned());
    let down = path.components().skip(shared).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// Writes `summary.html`, or that of a part, of a batch that is at work.
///
/// # Errors
/// A file that can't be written.
pub fn publish_running(summary: &Summary, running: &Running, out: &Path) -> Result<(), Error> {
    let file = out.join(of_part("summary", "html", summary.shard, &summary.tags));
    Ok(asset::publish(&file, page_of_running(summary, running, out).to_html().as_bytes())?)
}

/// Writes `summary.json`, `summary.html` and `junit.xml`, or those of a part, into the output folder.
///
/// # Errors
/// Files that can't be written.
pub fn publish(summary: &Summary, out: &Path) -> Result<(), Error> {
    let file = |stem, ending| out.join(of_part(stem, ending, summary.shard, &summary.tags));
    asset::publish(&file("summary", "html"), page(summary, out).to_html().as_bytes())?;
    asset::publish(&file("junit", "xml"), junit(summary).as_bytes())?;
    let json = serde_json::to_string_pretty(summary).expect("plain data") + "\n";
    Ok(asset::publish(&file("summary", "json"), json.as_bytes())?)
}
