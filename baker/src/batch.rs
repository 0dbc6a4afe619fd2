//! Many meshes to many assets, again and again: what changed is baked, what didn't isn't.
//!
//! ```text
//! manifest -> assets (globs, effective parameters) -> state (content keys) -> schedule -> workers -> summary, page, junit
//! ```

#[cfg(test)]
mod fixture;
pub mod junit;
pub mod log;
pub mod merge;
pub mod page;
pub mod preview;
pub mod read;
pub mod summary;
