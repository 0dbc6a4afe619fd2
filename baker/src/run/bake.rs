//! `volmap bake`.

use crate::args::BakeArguments;
use crate::is_same_file;
use crate::options::with_options;
use crate::progress::Progress;
use anyhow::{Result, bail};
use std::io::{self, Write};
use std::time::Instant;
use volmap_bake::bake::plan_bake;
use volmap_bake::input;
use volmap_formats::asset;
use volmap_formats::text::bytes;
use volmap_memory::start_threads;
use volmap_report::info;

/// Bakes a mesh and says what came of it.
pub fn run_bake(arguments: &BakeArguments) -> Result<()> {
    let output = arguments.output();
    if arguments.parameters.given.shape.is_none() && is_same_file(&arguments.mesh(), &output) {
        bail!("{}: would overwrite the mesh; name another file with --output", output.display());
    }
    asset::check_target(&output)?;
    start_threads(arguments.threads)?;
    let mut progress = Progress::new(arguments.quiet)?;
    let watch = progress.watch();
    let start = Instant::now();
    let recipe = arguments.recipe();
    let input = input::load(&arguments.mesh(), &recipe.input)?;
    let read_seconds = start.elapsed().as_secs_f64();
    let planned = plan_bake(input, &recipe.bake, &watch);
    let planned = planned.map_err(|error| arguments.parameters.given.explain(error))?;
    planned.plan().into_iter().for_each(|plan| progress.plan(plan));
    let mut baked = planned.run(&watch)?;
    watch.check()?;
    progress.finish();
    let start = Instant::now();
    asset::write(&output, &baked.asset, recipe.compression)?;
    baked.summary.seconds.insert(0, ("read", read_seconds));
    baked.summary.seconds.push(("write", start.elapsed().as_secs_f64()));
    let file_bytes = std::fs::metadata(&output)?.len();
    let mut out = io::stdout().lock();
    if arguments.json {
        writeln!(out, "{:#}", info::to_json(&baked.asset, file_bytes))?;
    } else if !arguments.quiet {
        writeln!(out, "{}", with_options(&baked.summary.to_string()))?;
        writeln!(out, "asset      {} ({})", output.display(), bytes(file_bytes))?;
        writeln!(
            out,
            "next       volmap info {0}\n           volmap query {0} --points points.csv",
            output.display()
        )?;
    }
    Ok(())
}
