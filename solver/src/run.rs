//! The commands of `volmap-sim`.

pub mod check;
pub mod info;
pub mod schema;
pub mod simulate;
pub mod validate;
