//! The tests of volmap that go through more than one crate, in one binary.

mod analytic;
mod peer;

#[cfg(feature = "interop")]
mod interop_meshes;
