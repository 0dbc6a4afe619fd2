//! Errors as the user reads them: what the libraries say, and the option that helps.

use volmap_scenes::Error;

/// The message of an error, in one line.
pub fn of(error: &anyhow::Error) -> String {
    let text = error.to_string().replace("`max_memory`", "--max-memory");
    match error.downcast_ref().and_then(cure) {
        Some(cure) => format!("{text}; {cure}"),
        None => text,
    }
}

/// Whether a command ended because it was asked to, without a result.
pub fn is_cancelled(error: &anyhow::Error) -> bool {
    let scene = error.downcast_ref().is_some_and(Error::is_cancelled);
    scene || error.downcast_ref().is_some_and(volmap_fluid::Error::is_cancelled)
}

/// The libraries name settings; here are their options.
fn cure(error: &Error) -> Option<&'static str> {
    match error {
        Error::RunExists { .. } => Some("--resume continues it, --overwrite replaces it"),
        Error::NoCheckpoint { .. } => Some("start it with --overwrite"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_behind_the_libraries_messages() {
        let exists = Error::RunExists { folder: "out".into() };
        assert_eq!(
            of(&exists.into()),
            "out: has a run already; --resume continues it, --overwrite replaces it"
        );
        assert_eq!(of(&anyhow::anyhow!("full")), "full");
    }
}
