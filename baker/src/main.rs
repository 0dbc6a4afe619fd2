//! The `volmap` program: parses, reports progress, maps errors to exit codes. All else is in the library.

mod args;
mod options;
mod progress;
mod run;
mod signals;

use anyhow::Result;
use args::{Arguments, Command};
use clap::Parser;
use run::{bake, batch, cache, exchange, manual, outline, query, report, reproduce, slice};
use std::io;
use std::path::Path;
use std::process::ExitCode;
use volmap_batch::process::WORKER;
use volmap_formats::text::printable;
use volmap_memory::{NoThreads, start_threads};

#[global_allocator]
static ALLOCATOR: volmap_memory::Allocator = volmap_memory::Allocator;

/// What is said when the system has no memory left.
const OUT_OF_MEMORY: &str = "\
    error: the system has no memory left (exit code 3); allow more (ulimit -v, the container's limit), or need less: \
    larger cells (--cell-size, --resolution, --support-radius), fewer --threads or --jobs. --max-memory refuses before \
    the work what won't fit\n";

fn main() -> ExitCode {
    // Where it is refused, the program only ends in another way.
    let _ = volmap_memory::tell(OUT_OF_MEMORY);
    match start() {
        Ok(code) => code,
        // The reader of a pipe may have had enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) if signals::is_cancelled(&error) => {
            eprintln!("stopped; nothing was written");
            ExitCode::from(signals::STOPPED)
        }
        Err(error) => {
            eprintln!("error: {}", message(&error));
            if error.is::<NoThreads>() { volmap_memory::EXIT_CODE.into() } else { ExitCode::FAILURE }
        }
    }
}

fn start() -> Result<ExitCode> {
    // No command for people, so that neither help nor completions have it.
    if std::env::args_os().nth(1).is_some_and(|argument| argument == WORKER) {
        batch::run_worker()?;
        return Ok(ExitCode::SUCCESS);
    }
    run(Arguments::parse().command)
}

fn run(command: Command) -> Result<ExitCode> {
    match command {
        Command::Bake(arguments) => bake::run_bake(&arguments)?,
        Command::BakeOutline(arguments) => outline::run_bake_outline(&arguments)?,
        Command::Batch(arguments) => return Ok(batch::run_batch(&arguments)),
        Command::Verify(arguments) => return Ok(batch::run_verify(&arguments)),
        Command::Info { asset, all, json } => {
            start_threads(None)?;
            query::run_info(&asset, all, json)?;
        }
        Command::Query { asset, points, json } => {
            start_threads(None)?;
            query::run_query(&asset, &points, json)?;
        }
        Command::Report(arguments) => return report::run_report(&arguments),
        Command::Slice(arguments) => {
            start_threads(None)?;
            slice::run_slice(&arguments)?;
        }
        Command::Export(arguments) => {
            start_threads(None)?;
            exchange::run_export(&arguments)?;
        }
        Command::Import(arguments) => {
            start_threads(None)?;
            exchange::run_import(&arguments)?;
        }
        Command::Reproduce(arguments) => reproduce::run_reproduce(&arguments)?,
        Command::Cache(arguments) => cache::run_cache(&arguments)?,
        Command::Completions { shell } => manual::run_completions(shell)?,
        Command::Man { output } => manual::run_man(output.as_deref())?,
    }
    Ok(ExitCode::SUCCESS)
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// The chain of causes; those that the message before already holds are left out.
fn message(error: &anyhow::Error) -> String {
    let mut out = options::message(error).unwrap_or_default();
    for cause in error.chain().skip(usize::from(!out.is_empty())).map(ToString::to_string) {
        if out.is_empty() {
            out = cause;
        } else if !out.contains(&cause) {
            out = format!("{out}: {cause}");
        }
    }
    // Names of files may hold what a terminal would obey.
    printable(&out)
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}
