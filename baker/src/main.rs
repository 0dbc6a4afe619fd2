//! The `volmap` program.
fn main() {}
