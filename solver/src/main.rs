//! The `volmap-sim` program: parses, reports progress, maps errors to exit codes. All else is in the library.

fn main() {}
