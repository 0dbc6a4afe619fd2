//! `volmap slice`.

use crate::args::slice::SliceArguments;
use crate::is_same_file;
use crate::progress::Progress;
use anyhow::{Result, bail};
use std::path::PathBuf;
use volmap_bake::area_map::require_space;
use volmap_bake::{input, provenance};
use volmap_formats::asset;
use volmap_report::slice;
use volmap_runtime::VolumeMap;

/// Draws a map on a plane.
pub fn run_slice(arguments: &SliceArguments) -> Result<()> {
    let sources: Vec<&PathBuf> = [&arguments.asset].into_iter().chain(&arguments.mesh).collect();
    let targets: Vec<&PathBuf> = [&arguments.output].into_iter().chain(&arguments.csv).collect();
    for target in &targets {
        if let Some(source) = sources.iter().find(|source| is_same_file(source, target)) {
            bail!("{}: would overwrite {}; name another file", target.display(), source.display());
        }
        asset::check_target(target)?;
    }
    let mut progress = Progress::new(false)?;
    let content = asset::read(&arguments.asset)?;
    require_space(&content, "volmap slice")?;
    let input = match &arguments.mesh {
        Some(path) => Some(input::load(path, &provenance::input_settings(&content)?)?),
        None => None,
    };
    let warning = input.as_ref().and_then(|input| provenance::other_mesh(&content, &input.source));
    warning.iter().for_each(|warning| eprintln!("warning: {warning}"));
    let map = VolumeMap::from_asset(&content)?;
    let mesh = input.as_ref().map(|input| slice::NamedMesh { mesh: &input.mesh, name: &input.source.file });
    let slice = slice::slice(&map, &arguments.settings(), mesh, &progress.watch())?;
    progress.finish();
    asset::publish(&arguments.output, &slice.figure.to_png())?;
    if let Some(path) = &arguments.csv {
        let mut table = Vec::new();
        slice::write_csv(&slice.raster, &mut table)?;
        asset::publish(path, &table)?;
    }
    Ok(())
}
