//! `volmap bake-outline`.

use crate::args::outline::OutlineArguments;
use crate::is_same_file;
use crate::progress::Progress;
use anyhow::{Result, bail};
use std::io::{self, Write};
use volmap_bake::area_map::outline::bake_file;
use volmap_formats::asset::{self, Asset, Value};
use volmap_formats::text::{bytes, significant, thousands};
use volmap_memory::start_threads;
use volmap_report::info;

/// Bakes an outline and says what came of it.
pub fn run_bake_outline(arguments: &OutlineArguments) -> Result<()> {
    let output = arguments.output();
    if is_same_file(&arguments.outline, &output) {
        bail!("{}: would overwrite the outline; name another file with --output", output.display());
    }
    asset::check_target(&output)?;
    start_threads(arguments.threads)?;
    let mut progress = Progress::new(arguments.quiet)?;
    let watch = progress.watch();
    let baked = bake_file(&arguments.outline, arguments.placement(), &arguments.settings(), &watch)?;
    watch.check()?;
    progress.finish();
    asset::write(&output, &baked, arguments.compression())?;
    let file_bytes = std::fs::metadata(&output)?.len();
    let mut out = io::stdout().lock();
    if arguments.json {
        writeln!(out, "{:#}", info::to_json(&baked, file_bytes))?;
    } else if !arguments.quiet {
        write!(out, "{}", summary(&baked))?;
        writeln!(out, "asset      {} ({})", output.display(), bytes(file_bytes))?;
    }
    Ok(())
}

fn summary(asset: &Asset) -> String {
    let [x, y, _] = asset.grid.resolution;
    let [width, height, _] = asset.grid.cell_size;
    let cells: u64 = asset.band_count();
    let mut out = format!(
        "support    {} m\ngrid       {x} x {y} cells of {} x {} m\nband       {} cells, {} nodes\n",
        asset.support_radius,
        significant(width, 4),
        significant(height, 4),
        thousands(cells),
        thousands(asset.volume.len() as u64),
    );
    if let Some(Value::Text(warnings)) = asset.diagnosis.get("warnings") {
        warnings.lines().for_each(|line| out += &format!("warning    {line}\n"));
    }
    out
}
