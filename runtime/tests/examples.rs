//! The examples run, and what they assert holds.

// Each example has the ball that it samples.
#![allow(clippy::duplicate_mod)]

#[path = "../examples/batch.rs"]
mod batch;
#[path = "../examples/pose.rs"]
mod pose;
#[path = "../examples/sample.rs"]
mod sample;

#[test]
fn a_map_is_opened_and_sampled() {
    sample::main().unwrap();
}

#[test]
fn a_body_moves() {
    pose::main().unwrap();
}

#[test]
fn many_particles_feel_a_wall() {
    batch::main().unwrap();
}
