//! The tests of volmap that go through more than one crate, in one binary.

mod analytic;
