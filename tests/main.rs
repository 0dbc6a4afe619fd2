//! The tests of volmap that go through more than one crate, in one binary.

mod analytic;

#[cfg(feature = "interop")]
mod interop_meshes;
