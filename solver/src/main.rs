//! The `volmap-sim` program: arguments, progress, signals and exit codes. All else is in the libraries.

mod args;
mod message;
mod run;
mod signals;

use anyhow::Result;
use args::{Arguments, Command};
use clap::Parser;
use run::experiments::ExperimentSet;
use std::io;
use std::process::ExitCode;
use volmap_experiments::{reproduce, validation};

#[global_allocator]
static ALLOCATOR: volmap_memory::Allocator = volmap_memory::Allocator;

/// What is said when the system has no memory left.
const OUT_OF_MEMORY: &str = "\
    error: the system has no memory left (exit code 3); allow more (ulimit -v, the container's limit), or need less: \
    fewer particles (a larger particle_radius, max_particles of emitters), larger cells (bake.cell_size), fewer \
    --threads. A run goes on from its last checkpoint by --resume. --max-memory refuses before the run what won't \
    fit\n";

fn main() -> ExitCode {
    // Where it is refused, the program only ends in another way.
    let _ = volmap_memory::tell(OUT_OF_MEMORY);
    match run(&Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of a pipe may have closed it.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            run::tell(format_args!("error: {}", message::of(&error)));
            exit_code(&error)
        }
    }
}

fn exit_code(error: &anyhow::Error) -> ExitCode {
    if message::is_cancelled(error) {
        signals::STOPPED.into()
    } else if error.is::<volmap_memory::NoThreads>() {
        volmap_memory::EXIT_CODE.into()
    } else {
        ExitCode::FAILURE
    }
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Run(arguments) => run::simulate::run_simulate(arguments),
        Command::Info(arguments) => run::info::run_info(arguments),
        Command::Check(arguments) => run::check::run_check(arguments),
        Command::New(arguments) => run::new::run_new(arguments),
        Command::Schema => run::schema::run_schema(),
        Command::Validate(arguments) => run::experiments::run_experiments(&VALIDATION, arguments),
        Command::Reproduce(arguments) => run::experiments::run_experiments(&REPRODUCTION, arguments),
    }
}

const VALIDATION: ExperimentSet =
    ExperimentSet { experiments: validation::EXPERIMENTS, results: "validation.json", is_strict: true };

const REPRODUCTION: ExperimentSet =
    ExperimentSet { experiments: reproduce::EXPERIMENTS, results: "reproduction.json", is_strict: false };

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}
