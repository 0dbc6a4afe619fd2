//! Subcommands: files in, files out, and what is said in between.

pub mod bake;
pub mod batch;
pub mod cache;
pub mod exchange;
pub mod manual;
pub mod outline;
pub mod query;
pub mod report;
pub mod reproduce;
pub mod slice;
