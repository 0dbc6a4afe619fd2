//! The `volmap` program: parses, reports progress, maps errors to exit codes. All else is in the library.

mod args;
mod progress;

use anyhow::{Context, Result, bail};
use args::exchange::{ExportArguments, ImportArguments};
use args::{Arguments, BakeArguments, Command};
use clap::Parser;
use progress::Progress;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use volmap_baker::bake::bake;
use volmap_baker::summary::{bytes, thousands};
use volmap_baker::{export, import, info, input, points};
use volmap_formats::asset::{self, Compression};
use volmap_runtime::VolumeMap;

fn main() -> ExitCode {
    match run(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of a pipe may have had enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", message(&error));
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> Result<()> {
    match command {
        Command::Bake(arguments) => run_bake(&arguments),
        Command::Info { asset, json } => run_info(&asset, json),
        Command::Query { asset, points, json } => run_query(&asset, &points, json),
        Command::Export(arguments) => run_export(&arguments),
        Command::Import(arguments) => run_import(&arguments),
    }
}

fn run_bake(arguments: &BakeArguments) -> Result<()> {
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
    let input = input::load(&arguments.mesh, &arguments.input())?;
    let read_seconds = start.elapsed().as_secs_f64();
    let mut baked =
        bake(input, &arguments.settings(), &mut |plan| progress.plan(plan), &mut |step| progress.step(step))?;
    progress.finish();
    let start = Instant::now();
    {
        let mut written = writing.lock().unwrap_or_else(PoisonError::into_inner);
        asset::write(&output, &baked.asset, arguments.compression())?;
        *written = true;
    }
    baked.summary.seconds.insert(0, ("read", read_seconds));
    baked.summary.seconds.push(("write", start.elapsed().as_secs_f64()));
    let file_bytes = std::fs::metadata(&output)?.len();
    let mut out = io::stdout().lock();
    if arguments.json {
        writeln!(out, "{:#}", info::to_json(&baked.asset, file_bytes))?;
    } else if !arguments.quiet {
        writeln!(out, "{}", baked.summary)?;
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
fn exit_between_writes() -> Result<Arc<Mutex<bool>>> {
    let writing = Arc::new(Mutex::new(false));
    let handler_lock = writing.clone();
    ctrlc::set_handler(move || {
        let written = handler_lock.lock().unwrap_or_else(PoisonError::into_inner);
        eprintln!("stopped; {}", if *written { "the asset is complete" } else { "nothing was written" });
        std::process::exit(130);
    })?;
    Ok(writing)
}

fn run_info(path: &Path, json: bool) -> Result<()> {
    let asset = asset::read(path)?;
    let file_bytes = std::fs::metadata(path)?.len();
    let mut out = io::stdout().lock();
    match json {
        true => writeln!(out, "{:#}", info::to_json(&asset, file_bytes))?,
        false => write!(out, "{}", info::to_text(&asset, file_bytes))?,
    }
    Ok(())
}

fn run_query(path: &Path, table: &Path, json: bool) -> Result<()> {
    let map = VolumeMap::open(path)?;
    let name = || table.display().to_string();
    let points: Box<dyn io::Read> = match table.as_os_str() == "-" {
        true => Box::new(io::stdin().lock()),
        false => Box::new(std::fs::File::open(table).with_context(name)?),
    };
    let mut out = BufWriter::new(io::stdout().lock());
    match json {
        true => points::query_json(&map, points, &mut out).with_context(name)?,
        false => points::query_csv(&map, points, &mut out).with_context(name)?,
    }
    Ok(out.flush()?)
}

fn run_export(arguments: &ExportArguments) -> Result<()> {
    let output = &arguments.output;
    if is_same_file(&arguments.asset, output) {
        bail!("{}: would overwrite the asset; name another file with --output", output.display());
    }
    asset::check_target(output)?;
    let content = export::export(&asset::read(&arguments.asset)?, output, &arguments.settings())?;
    let file_bytes = std::fs::metadata(output)?.len();
    Ok(writeln!(io::stdout(), "{}: {content} ({})", output.display(), bytes(file_bytes))?)
}

fn run_import(arguments: &ImportArguments) -> Result<()> {
    let output = &arguments.output;
    if is_same_file(&arguments.map, output) {
        bail!("{}: would overwrite the map; name another file with --output", output.display());
    }
    asset::check_target(output)?;
    let import = import::import(&arguments.map, &arguments.settings())?;
    asset::write(output, &import.asset, Compression::default())?;
    import.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    let nodes = import.asset.volume.len() as u64;
    let file_bytes = std::fs::metadata(output)?.len();
    Ok(writeln!(io::stdout(), "{}: {} nodes ({})", output.display(), thousands(nodes), bytes(file_bytes))?)
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// The chain of causes; those that the message before already holds are left out.
fn message(error: &anyhow::Error) -> String {
    let mut out = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if out.is_empty() {
            out = cause;
        } else if !out.contains(&cause) {
            out = format!("{out}: {cause}");
        }
    }
    out
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}
