//! Exact signed distance to a triangle mesh, and its discretisation on a sparse band of cells.
//!
//! `bvh` finds the closest triangles of points that lie together (`packet`), `closest_point` the point and the feature
//! of it, `pseudonormal` or `winding` the side, and `mesh_distance` puts them together. `sign` decides which of the two
//! signs a mesh can bear, `union` which faces are its surface. `thin` finds walls and
//! gaps that the cells can't resolve, by their `width`, and rods (`rod`). `band` finds the cells near the surface,
//! `field` samples their nodes. `brute_force` is the slow twin that the tests compare with.

#[cfg(target_arch = "x86_64")]
mod avx2;
pub mod band;
pub mod boundary_distance;
pub mod brute_force;
pub mod bvh;
mod bvh_build;
mod bvh_query;
mod cell_edges;
pub mod closest_point;
mod coarse_block;
pub mod field;
mod frame;
mod lanes;
pub mod leaks;
pub mod mesh_distance;
mod oriented_box;
mod packet;
pub mod pseudonormal;
mod rod;
mod sides;
pub mod sign;
pub mod sign_comparison;
pub mod thin;
mod union;
pub mod width;
pub mod winding;

pub use boundary_distance::{BoundaryDistance, ChangedDistance, SignedDistance};
pub use closest_point::{Closest, Feature};
pub use mesh_distance::{KnownDistance, MeshDistance, Neighbours};
pub use sign::{SignMethod, choose_sign};
pub use sign_comparison::{SignComparison, compare_signs, points_near_surface};
pub use union::{Overlaps, UnionSurface};
