//! Looks into assets: measures how exact they are, draws them, and carries them to and from other programs.
//!
//! ```text
//! Asset -> report (errors, causes, pictures) -> page
//!       -> slice -> PNG
//!       -> export -> VTKHDF, VTI, PLY, CDM        import: CDM -> Asset
//! experiments (rows, targets, a paper's figures) <- reproduce
//! ```
//!
//! # Tour
//!
//! - [`report::report`] measures an asset, with its mesh or without, and gives [`report::findings::Findings`]: a
//!   verdict, statistics of errors and of their parts, thin places. [`report::page::page`] makes an HTML page of them.
//! - [`slice::slice`] draws a field of a map on a plane.
//! - [`export`] and [`import`] write and read files of other programs.
//! - [`info`] and [`points`] describe an asset, and ask a map at points.
//! - [`experiments`] is the frame of experiments, which knows no map: choose them by name, run them, print a table or
//!   JSON. [`reproduce`] has the paper's experiments with maps in it.
//!
//! The program `examples/report.rs` bakes a sphere, measures it and prints the verdict.
//!
//! # Guarantees
//! Numbers and pictures depend on asset, mesh and settings alone: not on threads, time or machine. Random points come
//! from a seed. An asset that can't be used is an [`Error`], never a panic.
//!
//! Not guaranteed: that the random points meet the largest error there is. The verdict says how much of the fluid may
//! have a larger one, with 95 % confidence.

pub mod error;
pub mod experiments;
pub mod export;
pub mod import;
pub mod info;
pub mod points;
pub mod report;
pub mod reproduce;
pub mod slice;

pub use error::Error;
