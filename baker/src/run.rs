//! Subcommands: files in, files out, and what is said in between.

pub mod report;
