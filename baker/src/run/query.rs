//! `volmap info` and `volmap query`.

use anyhow::{Context, Result};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use volmap_formats::asset;
use volmap_report::{info, points};
use volmap_runtime::VolumeMap;

/// Shows what stands in an asset.
pub fn run_info(path: &Path, json: bool) -> Result<()> {
    let asset = asset::read(path)?;
    let file_bytes = std::fs::metadata(path)?.len();
    let mut out = io::stdout().lock();
    match json {
        true => writeln!(out, "{:#}", info::to_json(&asset, file_bytes))?,
        false => write!(out, "{}", info::to_text(&asset, file_bytes))?,
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
