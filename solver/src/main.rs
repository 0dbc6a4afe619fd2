//! The `volmap-sim` program: parses, reports progress, maps errors to exit codes. All else is in the library.

mod args;
mod run;

use anyhow::Result;
use args::{Arguments, Command};
use clap::Parser;
use std::io;
use std::process::ExitCode;
use volmap_experiments::{reproduce, validation};

fn main() -> ExitCode {
    match run(&Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of a pipe may have had enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", with_options(error.to_string()));
            ExitCode::FAILURE
        }
    }
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Run(arguments) => run::simulate::run_simulate(arguments),
        Command::Info(arguments) => run::info::run_info(arguments),
        Command::Check(arguments) => run::check::run_check(arguments),
        Command::Schema => run::schema::run_schema(),
        Command::Validate(arguments) => {
            run::experiments::run_experiments(validation::EXPERIMENTS, "validation.json", arguments)
        }
        Command::Reproduce(arguments) => {
            run::experiments::run_experiments(reproduce::EXPERIMENTS, "reproduction.json", arguments)
        }
    }
}

/// Libraries name settings in backquotes; these are options here.
fn with_options(message: String) -> String {
    let settings = ["resume", "overwrite"];
    settings.iter().fold(message, |text, name| text.replace(&format!("`{name}`"), &format!("--{name}")))
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}
