//! Libraries name parameters; the command line's words for them are options.

use crate::args::Arguments;
use clap::CommandFactory;
use volmap_bake::Error as BakeError;

/// What an error says of parameters, in the words of the command line; none if it says nothing of them.
pub fn message(error: &anyhow::Error) -> Option<String> {
    of_bake(bake_error(error)?)
}

fn of_bake(error: &BakeError) -> Option<String> {
    match error {
        BakeError::Setting { parameter, reason } => {
            let name = option(parameter).unwrap_or_else(|| (*parameter).to_owned());
            Some(format!("{name}: {}", with_options(reason)))
        }
        BakeError::Sized { about, reason } => {
            let reason = of_bake(reason).unwrap_or_else(|| reason.to_string());
            Some(format!("{}: {reason}", with_options(about)))
        }
        other @ (BakeError::Memory { .. } | BakeError::Unusable { .. }) => {
            Some(with_options(&other.to_string()))
        }
        _ => None,
    }
}

/// A text with an option for each parameter that stands in backquotes.
pub fn with_options(text: &str) -> String {
    let mut out = String::new();
    for (at, part) in text.split('`').enumerate() {
        match option(part).filter(|_| at % 2 == 1) {
            Some(option) => out += &option,
            None if at % 2 == 1 => out += &format!("`{part}`"),
            None => out += part,
        }
    }
    out
}

/// The option of this name, if some command has it.
fn option(parameter: &str) -> Option<String> {
    let long = parameter.replace('_', "-");
    let commands = Arguments::command();
    let mut longs = commands.get_subcommands().flat_map(|command| command.get_arguments());
    longs.any(|arg| arg.get_long() == Some(&long)).then(|| format!("--{long}"))
}

fn bake_error(error: &anyhow::Error) -> Option<&BakeError> {
    use volmap_batch::Error as BatchError;
    use volmap_report::Error as ReportError;
    if let Some(error) = error.downcast_ref() {
        return Some(error);
    }
    match (error.downcast_ref(), error.downcast_ref()) {
        (Some(ReportError::Bake(error)), _) => Some(error),
        (_, Some(BatchError::Bake(error) | BatchError::Report(ReportError::Bake(error)))) => Some(error),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_become_options_and_other_words_stay() {
        let of = |error: BakeError| message(&error.into()).unwrap();
        assert_eq!(
            of(BakeError::setting("max_rounding", "is more than `tolerance`; see `duck`")),
            "--max-rounding: is more than --tolerance; see `duck`"
        );
        assert_eq!(of(BakeError::setting("asset", "stores no cells")), "asset: stores no cells");
        let memory = of(BakeError::Memory { needed: 2 << 30, allowed: 1 << 30 });
        assert!(
            memory.contains("2048 MiB, more than the 1024 MiB that it may take (--max-memory)"),
            "{memory}"
        );
        assert!(memory.contains("(--cell-size, --resolution)"), "{memory}");
        let report: anyhow::Error =
            volmap_report::Error::from(BakeError::setting("plane", "is outside")).into();
        assert_eq!(message(&report).unwrap(), "--plane: is outside");
        assert_eq!(message(&anyhow::anyhow!("`domain` of another kind")), None);
    }
}
