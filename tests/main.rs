//! The tests of volmap, in one binary.
