//! Meshes and distances, compared with closed forms and with the slow twins.

mod distance;
mod orientation;
mod shapes;
mod sign;
mod thin;
mod topology;
mod union;
mod winding;
