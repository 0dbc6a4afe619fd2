//! Many meshes to many assets, again and again: what changed is baked, what didn't isn't.
//!
//! ```text
//! manifest -> assets (globs, effective parameters) -> state (content keys) -> schedule -> workers -> summary, page, junit
//! ```

pub mod assets;
pub mod manifest;
pub mod names;
pub mod pattern;
pub mod summary;
