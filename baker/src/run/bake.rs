//! `volmap bake`.

use crate::args::BakeArguments;
use crate::is_same_file;
use crate::options::with_options;
use crate::progress::Progress;
use anyhow::{Result, bail};
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use volmap_bake::bake::bake;
use volmap_bake::input;
use volmap_formats::asset;
use volmap_formats::text::bytes;
use volmap_report::info;

/// Bakes a mesh and says what came of it.
pub fn run_bake(arguments: &BakeArguments) -> Result<()> {
    let output = arguments.output();
    if is_same_file(&arguments.mesh, &output) {
        bail!("{}: would overwrite the mesh; name another file with --output", output.display());
    }
    asset::check_target(&output)?;
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    let writing = exit_between_writes()?;
    let mut progress = Progress::new(arguments.quiet);
    let start = Instant::now();
    let recipe = arguments.recipe();
    let input = input::load(&arguments.mesh, &recipe.input)?;
    let read_seconds = start.elapsed().as_secs_f64();
    let mut baked =
        bake(input, &recipe.bake, &mut |plan| progress.plan(plan), &mut |step| progress.step(step))?;
    progress.finish();
    let start = Instant::now();
    {
        let mut written = writing.lock().unwrap_or_else(PoisonError::into_inner);
        asset::write(&output, &baked.asset, recipe.compression)?;
        *written = true;
    }
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

/// Ends the program on Ctrl-C at once, but not while the lock is held: nothing half-written stays. The flag says
/// whether the asset is written.
pub(super) fn exit_between_writes() -> Result<Arc<Mutex<bool>>> {
    let writing = Arc::new(Mutex::new(false));
    let handler_lock = writing.clone();
    ctrlc::set_handler(move || {
        let written = handler_lock.lock().unwrap_or_else(PoisonError::into_inner);
        eprintln!("stopped; {}", if *written { "the asset is complete" } else { "nothing was written" });
        std::process::exit(130);
    })?;
    Ok(writing)
}
