//! `volmap export` and `volmap import`.

use crate::args::exchange::{ExportArguments, ImportArguments};
use crate::is_same_file;
use crate::options::with_options;
use crate::progress::Progress;
use anyhow::{Result, bail};
use std::io::{self, Write};
use volmap_formats::asset::{self, Compression};
use volmap_formats::text::{bytes, thousands};
use volmap_report::{export, import};

/// Writes a map for other programs.
pub fn run_export(arguments: &ExportArguments) -> Result<()> {
    let output = &arguments.output;
    if is_same_file(&arguments.asset, output) {
        bail!("{}: would overwrite the asset; name another file with --output", output.display());
    }
    asset::check_target(output)?;
    let mut progress = Progress::new(false)?;
    let asset = asset::read(&arguments.asset)?;
    let content = export::export(&asset, output, &arguments.settings(), &progress.watch())?;
    progress.finish();
    let file_bytes = std::fs::metadata(output)?.len();
    Ok(writeln!(io::stdout(), "{}: {content} ({})", output.display(), bytes(file_bytes))?)
}

/// Makes an asset of another program's map.
pub fn run_import(arguments: &ImportArguments) -> Result<()> {
    let output = &arguments.output;
    if is_same_file(&arguments.map, output) {
        bail!("{}: would overwrite the map; name another file with --output", output.display());
    }
    asset::check_target(output)?;
    let import = import::import(&arguments.map, &arguments.settings())?;
    asset::write(output, &import.asset, Compression::default())?;
    let told = import.warnings.iter().chain(&import.notes);
    told.for_each(|warning| eprintln!("warning: {}", with_options(warning)));
    let nodes = import.asset.volume.len() as u64;
    let file_bytes = std::fs::metadata(output)?.len();
    Ok(writeln!(io::stdout(), "{}: {} nodes ({})", output.display(), thousands(nodes), bytes(file_bytes))?)
}
