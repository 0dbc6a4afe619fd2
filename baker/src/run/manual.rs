//! `volmap completions` and `volmap man`: made of the arguments themselves.

use crate::args::Arguments;
use anyhow::{Context, Result};
use clap::CommandFactory;
use clap_complete::Shell;
use std::io::{self, Write};
use std::path::Path;
use volmap_formats::asset;

/// Prints completions for a shell.
pub fn run_completions(shell: Shell) -> Result<()> {
    // Into memory first: the generator panics where a pipe is closed.
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "volmap", &mut text);
    Ok(io::stdout().lock().write_all(&text)?)
}

/// Prints the page of the program, or writes those of all commands.
pub fn run_man(folder: Option<&Path>) -> Result<()> {
    let Some(folder) = folder else {
        return Ok(clap_mangen::Man::new(Arguments::command()).render(&mut io::stdout().lock())?);
    };
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let mut program = Arguments::command();
    // Gives commands the options that they inherit.
    program.build();
    page(&program, "volmap", folder)?;
    for command in program.get_subcommands().filter(|command| !command.is_hide_set()) {
        page(command, &format!("volmap-{}", command.get_name()), folder)?;
    }
    Ok(())
}

fn page(command: &clap::Command, name: &str, folder: &Path) -> Result<()> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command.clone().display_name(name.to_owned())).render(&mut text)?;
    Ok(asset::publish(&folder.join(format!("{name}.1")), &text)?)
}
