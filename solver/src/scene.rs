//! The scene file: parsed, checked, turned into particles and bodies.
