//! `volmap-sim new`.

use crate::args::{NewArguments, Template};
use anyhow::{Context, Result, bail};
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};

/// Writes a scene to start from.
pub fn run_new(arguments: &NewArguments) -> Result<()> {
    let (path, name) = (&arguments.file, arguments.file.display());
    if path.extension().is_none_or(|extension| extension != "toml") {
        bail!("{name}: scenes to start from are TOML; give a name that ends in .toml");
    }
    let mut file = match OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            bail!("{name}: is there already and stays as it is; give another name")
        }
        Err(error) => return Err(error).with_context(|| name.to_string()),
    };
    file.write_all(text(arguments.template).as_bytes()).with_context(|| name.to_string())?;
    println!("scene      {name}");
    println!("next       volmap-sim check {name}\n           volmap-sim run {name} -o out");
    Ok(())
}

fn text(template: Template) -> &'static str {
    match template {
        Template::Tank => include_str!("new/tank.toml"),
        Template::Jet => include_str!("new/jet.toml"),
    }
}
