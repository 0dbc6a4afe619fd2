//! Pages for people: one HTML file without network, readable on a phone and in print, light and dark.
//!
//! ```text
//! Page (title, verdict, sections of blocks) -> render -> text of the file
//! ```
//! Guaranteed: whatever stands in a text is shown as it is, never taken as markup; the page's own policy
//! (Content-Security-Policy) forbids every request and every script but the one that sorts tables.

mod document;
mod render;

pub use crate::escape::escape;
pub use document::{Block, Cell, Column, Image, Link, Outcome, Page, Parameter, Section, Table, Verdict};
