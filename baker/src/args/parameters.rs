//! Options of bakes, made from the table of parameters: one for each row.

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgGroup, ArgMatches, Args, Command, FromArgMatches, error::ErrorKind};
use std::marker::PhantomData;
use volmap_bake::parameters::{Group, Parameter, Parameters, Section, TABLE};

/// The parameters of a command that takes some of the table's rows.
#[derive(Clone, Debug)]
pub struct ParameterArguments<R: Rows> {
    /// What is given.
    pub given: Parameters,
    rows: PhantomData<R>,
}

/// Which rows a command takes.
pub trait Rows {
    /// Whether it takes this one.
    fn has(row: &Parameter) -> bool;
    /// Heading of the options that are about reading the mesh.
    const MESH: &'static str = "Mesh";
}

/// All of them.
#[derive(Clone, Debug)]
pub struct All;

impl Rows for All {
    fn has(_: &Parameter) -> bool {
        true
    }
}

fn rows<R: Rows>() -> impl Iterator<Item = &'static Parameter> {
    TABLE.iter().filter(|row| R::has(row))
}

fn argument<R: Rows>(row: &'static Parameter) -> Arg {
    let heading = if row.section == Section::Mesh { R::MESH } else { row.section.name() };
    let arg = Arg::new(row.name)
        .long(row.option())
        .value_name(row.placeholder)
        .help(row.description())
        .help_heading(heading)
        .conflicts_with_all(row.excludes);
    let arg = match row.needs {
        Some(flag) => arg.requires(flag),
        None => arg,
    };
    match row {
        Parameter { is_flag: true, .. } => arg
            .num_args(0..=1)
            .require_equals(true)
            .default_missing_value("true")
            .value_parser(PossibleValuesParser::new(["true", "false"]))
            .hide_possible_values(true),
        Parameter { words: [_, ..], .. } => arg.value_parser(PossibleValuesParser::new(row.words)),
        // Lists of numbers may begin with a minus.
        _ => arg.allow_hyphen_values(row.placeholder != "LENGTH").value_parser(|text: &str| {
            let read = (row.set)(&mut Parameters::default(), text);
            read.map(|()| text.to_owned())
        }),
    }
}

impl<R: Rows> Args for ParameterArguments<R> {
    fn augment_args(command: Command) -> Command {
        let group = |group: Group| {
            let members = rows::<R>().filter(move |row| row.group == Some(group));
            // An argument may have the group's name.
            ArgGroup::new(format!("{} group", group.name())).args(members.map(|row| row.name))
        };
        command
            .allow_negative_numbers(true)
            .args(rows::<R>().map(argument::<R>))
            .groups(Group::ALL.map(group))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<R: Rows> FromArgMatches for ParameterArguments<R> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut out = ParameterArguments { given: Parameters::default(), rows: PhantomData };
        out.update_from_arg_matches(matches)?;
        Ok(out)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for row in rows::<R>() {
            if let Some(text) = matches.get_one::<String>(row.name) {
                (row.set)(&mut self.given, text)
                    .map_err(|error| clap::Error::raw(ErrorKind::InvalidValue, error))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_batch::manifest;
    use volmap_documents::Syntax;

    type AllArguments = ParameterArguments<All>;

    fn parse(words: &[String]) -> Result<Parameters, clap::Error> {
        let command = AllArguments::augment_args(Command::new("volmap").no_binary_name(true));
        AllArguments::from_arg_matches(&command.try_get_matches_from(words)?).map(|found| found.given)
    }

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(String::from).collect()
    }

    /// A row's parameter in a manifest: numbers and flags as such, else a text.
    fn in_manifest(row: &Parameter) -> Parameters {
        let is_bare = row.is_flag || row.example.parse::<f64>().is_ok();
        let value = if is_bare { row.example.to_owned() } else { format!("\"{}\"", row.example) };
        let flag = row.needs.map_or(String::new(), |flag| format!("{flag} = true\n"));
        // A shape is an asset's own: it has no mesh.
        let text = match row.name {
            "shape" => format!("version = 1\n[[assets]]\nname = \"a\"\nbake = {{ shape = {value} }}"),
            name => {
                format!("version = 1\n[[assets]]\nmesh = \"a.obj\"\n[defaults.bake]\n{flag}{name} = {value}")
            }
        };
        let manifest = manifest::parse(&text, Syntax::Toml, "m.toml").unwrap();
        if row.name == "shape" { manifest.assets[0].bake.clone() } else { manifest.defaults.bake }
    }

    #[test]
    fn every_row_is_an_option_and_a_key_of_manifests() {
        for row in TABLE {
            let flag = row.needs.map(|flag| format!("--{flag}"));
            let given = parse(
                &flag.into_iter().chain([format!("--{}={}", row.option(), row.example)]).collect::<Vec<_>>(),
            );
            let given = given.unwrap();
            assert!((row.is_given)(&given), "{}", row.name);
            assert_eq!(given, in_manifest(row), "{}", row.name);
        }
    }

    #[test]
    fn flags_may_have_a_value_and_numbers_a_sign() {
        let given = parse(&words("--invert --density=false --thickness -0.1 --domain -1,-1,-1,1,1,1"));
        let given = given.unwrap();
        assert_eq!((given.invert, given.density, given.thickness), (Some(true), Some(false), Some(-0.1)));
        assert_eq!(given.domain.unwrap().0[0], -1.0);
    }

    #[test]
    fn mistakes_are_told_in_the_words_of_the_command_line() {
        for (line, parts) in [
            ("--resolution 1,2", ["'1,2' for '--resolution <N>'", "give N, or NX,NY,NZ"]),
            ("--sign wind", ["'wind' for '--sign <SIGN>'", "[possible values: auto, pseudonormal, winding]"]),
            ("--invert=yes", ["'yes' for '--invert", "possible values: true, false"]),
            ("--kernel cubic", ["required arguments were not provided", "--density"]),
            ("--cell-size 1 --tolerance 1%", ["'--cell-size <LENGTH>' cannot be used with", "--tolerance"]),
            ("--precision f64 --max-rounding 1%", ["cannot be used with", "--max-rounding <FRACTION>"]),
            ("--support-radius 1 --particle-radius 1", ["cannot be used with", "--particle-radius"]),
            ("--tolerence 1%", ["unexpected argument '--tolerence'", "'--tolerance'"]),
        ] {
            let error = parse(&words(line)).unwrap_err().to_string();
            assert!(parts.iter().all(|part| error.contains(part)), "{line}: {error}");
        }
    }
}
