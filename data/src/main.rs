//! Makes the sample meshes.
fn main() {}
