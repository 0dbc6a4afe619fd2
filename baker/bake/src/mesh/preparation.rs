//! Orientation and diagnosis of a mesh in one go, with what both need found once.

use volmap_formats::mesh::TriangleMesh;

use crate::mesh::diagnosis::{Diagnosis, diagnose_with};
use crate::mesh::orientation::{OrientationRepair, orient_with};
use crate::mesh::topology::Topology;

/// What is known of a mesh once its triangles run the same way round.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Its edges.
    pub topology: Topology,
    /// What orienting did.
    pub repair: OrientationRepair,
    /// What is wrong with it still.
    pub diagnosis: Diagnosis,
}

/// Orients a mesh, unless it is to be kept as it comes, and examines it; linear time.
pub fn prepare(mesh: &mut TriangleMesh, keep_orientation: bool) -> Prepared {
    let mut topology = Topology::new(mesh);
    let (repair, components) = match keep_orientation {
        true => (OrientationRepair::default(), None),
        false => {
            let (repair, patches, nesting) = orient_with(mesh, &mut topology);
            // Patches end where an edge has more than two faces, components don't.
            let same = topology.edges().all(|edge| edge.sides.len() <= 2);
            (repair, same.then_some((patches, nesting)))
        }
    };
    let diagnosis = diagnose_with(mesh, &topology, components);
    Prepared { topology, repair, diagnosis }
}
