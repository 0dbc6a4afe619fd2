//! The tests of volmap that go through more than one crate, in one binary.

mod analytic;
mod density;
mod exchange;
mod peer;
mod queries;
mod report;
mod tolerance;
mod volume;

#[cfg(feature = "interop")]
#[path = "../runtime/tests/analytic/mod.rs"]
mod analytic_maps;
#[cfg(feature = "interop")]
mod interop_asset;
#[cfg(feature = "interop")]
mod interop_export;
#[cfg(feature = "interop")]
mod interop_meshes;
#[cfg(feature = "interop")]
mod interop_page;
#[cfg(feature = "interop")]
mod interop_pipelines;
#[cfg(feature = "interop")]
mod interop_report;
#[cfg(feature = "interop")]
mod interop_simulation;
