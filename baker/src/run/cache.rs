//! `volmap cache`.

use crate::args::cache::{CacheAction, CacheArguments};
use anyhow::Result;
use std::io::{self, Write};
use std::time::{Duration, SystemTime};
use volmap_bake::cache::{CachedMap, clear, default_folder, list};
use volmap_formats::text::{bytes, duration, printable_line, thousands};

/// Shows, lists or clears the maps that are kept.
pub fn run_cache(arguments: &CacheArguments) -> Result<()> {
    let folder = arguments.folder.clone().unwrap_or_else(default_folder);
    let mut out = io::stdout().lock();
    match &arguments.action {
        None => {
            writeln!(out, "{}", printable_line(&format!("folder     {}", folder.display())))?;
            writeln!(out, "maps       {}", counted(&list(&folder)?))?;
        }
        Some(CacheAction::List) => {
            for map in list(&folder)? {
                let age = SystemTime::now().duration_since(map.written).unwrap_or_default();
                let (size, age) = (bytes(map.bytes), duration(age.as_secs_f64()));
                writeln!(
                    out,
                    "{}",
                    printable_line(&format!("{size:>10}  {age:>14}  {}", map.path.display()))
                )?;
            }
        }
        Some(CacheAction::Clear { older_than }) => {
            let gone = clear(&folder, older_than.unwrap_or(Duration::ZERO))?;
            writeln!(out, "removed    {}", counted(&gone))?;
        }
    }
    Ok(())
}

/// `3 (1.2 MB)`.
fn counted(maps: &[CachedMap]) -> String {
    let size: u64 = maps.iter().map(|map| map.bytes).sum();
    format!("{} ({})", thousands(maps.len() as u64), bytes(size))
}
