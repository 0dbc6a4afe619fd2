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

fn main() -> ExitCode {
    match run(&Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of a pipe may have closed it.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            run::tell(format_args!("error: {}", message::of(&error)));
            if message::is_cancelled(&error) { signals::STOPPED.into() } else { ExitCode::FAILURE }
        }
    }
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Run(arguments) => run::simulate::run_simulate(arguments),
        Command::Info(arguments) => run::info::run_info(arguments),
        Command::Check(arguments) => run::check::run_check(arguments),
        Command::Schema => run::schema::run_schema(),
        Command::Validate(arguments) => run::experiments::run_experiments(&VALIDATION, arguments),
        Command::Reproduce(arguments) => run::experiments::run_experiments(&REPRODUCTION, arguments),
    }
}

const VALIDATION: ExperimentSet =
    ExperimentSet { experiments: validation::EXPERIMENTS, results: "validation.json" };

const REPRODUCTION: ExperimentSet =
    ExperimentSet { experiments: reproduce::EXPERIMENTS, results: "reproduction.json" };

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}
