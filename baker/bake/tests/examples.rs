//! The examples run to their ends.

#[path = "../examples/bake_arrays.rs"]
mod bake_arrays;
#[path = "../examples/bake_distance.rs"]
mod bake_distance;
#[path = "../examples/watch_and_stop.rs"]
mod watch_and_stop;

#[test]
fn arrays_are_baked() {
    bake_arrays::main().unwrap();
}

#[test]
fn own_distances_are_baked() {
    bake_distance::main().unwrap();
}

#[test]
fn bakes_are_watched_and_stopped() {
    watch_and_stop::main().unwrap();
}
