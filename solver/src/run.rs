//! The commands of `volmap-sim`.

pub mod check;
pub mod experiments;
pub mod info;
pub mod schema;
pub mod simulate;
