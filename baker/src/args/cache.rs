//! Arguments of `volmap cache`.

use clap::{Args, Subcommand};
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Args)]
pub struct CacheArguments {
    /// What to do [default: show where the maps are, how many, and their size]
    #[command(subcommand)]
    pub action: Option<CacheAction>,
    /// Folder of the maps: that of a batch's --cache, or of a scene's `cache` [default: the one of volmap-sim]
    #[arg(long, value_name = "FOLDER", global = true)]
    pub folder: Option<PathBuf>,
}

#[derive(Clone, Debug, Subcommand)]
pub enum CacheAction {
    /// List the maps, the oldest first: size, age, file
    List,
    /// Remove the maps; they are baked again when they are needed
    Clear {
        /// Only those written longer ago than this, as 30d or 12h
        #[arg(long, value_name = "TIME", value_parser = age)]
        older_than: Option<Duration>,
    },
}

fn age(text: &str) -> Result<Duration, String> {
    let (number, seconds) = match (text.strip_suffix('d'), text.strip_suffix('h')) {
        (Some(days), _) => (days, 86_400.0),
        (_, Some(hours)) => (hours, 3600.0),
        _ => return Err("give days or hours, as 30d or 12h".into()),
    };
    let time = number.parse().ok().and_then(|n: f64| Duration::try_from_secs_f64(n * seconds).ok());
    time.ok_or_else(|| "give days or hours, as 30d or 12h".into())
}
