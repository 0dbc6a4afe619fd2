//! `volmap info` and `volmap query`.

use crate::options::with_options;
use anyhow::{Context, Result};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use volmap_formats::asset;
use volmap_formats::text::{bytes, printable};
use volmap_report::{info, points};
use volmap_runtime::VolumeMap;

/// Shows what stands in an asset: a summary, or all of it.
pub fn run_info(path: &Path, all: bool, json: bool) -> Result<()> {
    let asset = asset::read(path)?;
    let file_bytes = std::fs::metadata(path)?.len();
    let mut out = io::stdout().lock();
    match (json, all) {
        (true, _) => writeln!(out, "{:#}", info::to_json(&asset, file_bytes))?,
        (_, true) => write!(out, "{}", info::to_text(&asset, file_bytes))?,
        _ => {
            let version = asset.format_version();
            write!(out, "{}", printable(&with_options(&info::to_summary(&asset))))?;
            writeln!(out, "asset      {} ({}), format version {version}", path.display(), bytes(file_bytes))?;
            writeln!(out, "next       volmap info {} --all", path.display())?;
        }
    }
    Ok(())
}

/// Asks a map at the points of a table.
pub fn run_query(path: &Path, table: &Path, json: bool) -> Result<()> {
    let map = VolumeMap::open(path)?;
    let name = || table.display().to_string();
    let points: Box<dyn io::Read> = match table.as_os_str() == "-" {
        true => Box::new(io::stdin().lock()),
        false => Box::new(std::fs::File::open(table).with_context(name)?),
    };
    let mut out = BufWriter::new(io::stdout().lock());
    let renamed = match json {
        true => points::query_json(&map, points, &mut out).map(|()| Vec::new()),
        false => points::query_csv(&map, points, &mut out),
    };
    let renamed = renamed.with_context(name)?;
    if !renamed.is_empty() {
        let columns = renamed.join(", ");
        eprintln!("warning: {} has columns of the answers' names; the new ones are {columns}", name());
    }
    Ok(out.flush()?)
}
