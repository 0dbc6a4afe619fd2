//! Signed distance.

pub mod band;
pub mod field;
