//! What a simulation leaves, on scenes that are made up: a wave in a tank, with a duck.

mod folder;
mod pictures;
mod scene;
