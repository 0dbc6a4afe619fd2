//! What a batch has done so far, a line of JSON an asset: a killed one leaves it to the next. It is also the lock that
//! keeps two batches out of one folder.

use super::places::of_part;
use super::summary::{AssetReport, Shard, Summary};
use crate::error::Error;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, TryLockError};
use std::io::{BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Component, Path, PathBuf};

/// How names of journals begin.
pub const JOURNAL: &str = ".volmap-batch";

/// The journal of a batch at work.
pub struct Journal {
    path: PathBuf,
    file: File,
}

/// What is known of assets from earlier batches, by their names.
pub type Records = BTreeMap<String, AssetReport>;

/// What earlier batches in a folder knew.
#[derive(Default)]
pub struct Past {
    /// Of assets.
    pub records: Records,
    /// Names of assets that they told of as left over.
    pub leftovers: BTreeSet<String>,
}

impl Past {
    /// Names of all assets that batches made in the folder, as far as is known.
    pub fn names(&self) -> BTreeSet<String> {
        self.records.keys().chain(&self.leftovers).cloned().collect()
    }
}

impl Journal {
    /// Begins, and says what earlier batches knew: their summaries, and what the journal of one that was killed holds.
    ///
    /// # Errors
    /// A folder that can't be written to, or in which another batch is at work.
    pub fn open(out: &Path, shard: Option<Shard>) -> Result<(Journal, Past), Error> {
        let path = path(out, shard);
        let io = |source| Error::io(&path, source);
        let options = &mut File::options();
        let mut file = options.read(true).write(true).create(true).truncate(false).open(&path).map_err(io)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(Error::unusable(
                out,
                "another batch is at work in this folder; wait for it, or take another folder",
            ));
        }
        let mut past = of_summaries(out);
        add_lines(&mut past.records, &file);
        // The last line may be a part of one.
        if file.seek(SeekFrom::End(0)).map_err(io)? > 0 {
            file.write_all(b"\n").map_err(io)?;
        }
        Ok((Journal { path, file }, past))
    }

    /// Notes an asset.
    ///
    /// # Errors
    /// A disk that is full.
    pub fn note(&mut self, report: &AssetReport) -> Result<(), Error> {
        let mut line = serde_json::to_vec(report).expect("plain data");
        line.push(b'\n');
        self.write(&line)
    }

    /// All of it stands in a summary now.
    ///
    /// # Errors
    /// The system's.
    pub fn end(mut self) -> Result<(), Error> {
        let emptied = self.file.set_len(0).and_then(|()| self.file.rewind());
        emptied.map_err(|source| Error::io(&self.path, source))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.file.write_all(bytes).map_err(|source| Error::io(&self.path, source))
    }
}

/// What earlier batches in a folder knew.
pub fn past(out: &Path, shard: Option<Shard>) -> Past {
    let mut past = of_summaries(out);
    if let Ok(file) = File::open(path(out, shard)) {
        add_lines(&mut past.records, &file);
    }
    past
}

fn add_lines(records: &mut Records, file: &File) {
    let lines = BufReader::new(file).lines().map_while(Result::ok);
    let reports = lines.filter_map(|line| serde_json::from_str::<AssetReport>(&line).ok());
    records.extend(reports.map(|report| (report.name.clone(), report)));
    records.retain(|name, _| stays_inside(name));
}

fn path(out: &Path, shard: Option<Shard>) -> PathBuf {
    out.join(of_part(JOURNAL, "jsonl", shard, &[]))
}

/// Of the batch's summary and of its parts'.
fn of_summaries(out: &Path) -> Past {
    let mut past = Past::default();
    for summary in summaries(out) {
        // What wasn't tried or failed says nothing of the asset that lies there.
        let known = summary.assets.into_iter().filter(|report| report.file_blake3.is_some());
        past.records.extend(known.map(|report| (report.name.clone(), report)));
        past.leftovers.extend(summary.leftovers);
    }
    past.records.retain(|name, _| stays_inside(name));
    past.leftovers.retain(|name| stays_inside(name));
    past
}

/// The oldest first. One that can't be read is as good as none: assets are looked at instead.
fn summaries(out: &Path) -> Vec<Summary> {
    let files = std::fs::read_dir(out).into_iter().flatten().filter_map(Result::ok);
    let is_summary = |name: &str| name.starts_with("summary.") && name.ends_with(".json");
    let names = files.filter_map(|file| file.file_name().into_string().ok()).filter(|name| is_summary(name));
    let mut paths: Vec<PathBuf> = names.map(|name| out.join(name)).filter(|path| path.is_file()).collect();
    let age = |path: &PathBuf| std::fs::metadata(path).and_then(|found| found.modified()).ok();
    paths.sort_by_cached_key(|path| (age(path), path.clone()));
    let texts = paths.iter().map(|path| std::fs::read_to_string(path).unwrap_or_default());
    texts.map(|text| serde_json::from_str(&text).unwrap_or_default()).collect()
}

/// Names are paths in the folder; what a strange summary says may lead anywhere.
fn stays_inside(name: &str) -> bool {
    !name.is_empty() && Path::new(name).components().all(|part| matches!(part, Component::Normal(_)))
}
