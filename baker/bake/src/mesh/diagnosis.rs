//! What is wrong with a mesh: counts, and the first few places of each defect.

use glam::DVec3;
use serde::Serialize;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::boundary::{BoundaryLoop, boundary_loops};
use crate::mesh::fans::count_fans;
use crate::mesh::nesting::{Nesting, find_nesting};
use crate::mesh::parts::{Bounds, Parts, corners, surplus};
use crate::mesh::topology::{Edge, Topology};

/// Places that are kept of each defect.
const MAX_PLACES: usize = 8;
/// Boundary loops that are kept.
const MAX_LOOPS: usize = 32;

/// How often a defect occurs, and where first.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Defect {
    /// How often.
    pub count: usize,
    /// Points of the first few.
    pub places: Vec<[f64; 3]>,
}

impl Defect {
    fn add(&mut self, place: DVec3) {
        self.count += 1;
        if self.places.len() < MAX_PLACES {
            self.places.push(place.to_array());
        }
    }
}

/// All that is found out about a mesh. Components are sets of triangles connected by edges.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagnosis {
    /// Number of vertices that triangles use.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of components.
    pub components: usize,
    /// Every edge has an even number of faces: nothing has a rim.
    pub closed: bool,
    /// No edge with two faces is run through by both in the same direction.
    pub oriented: bool,
    /// No edge has more than two faces.
    pub manifold_edges: bool,
    /// The faces around every vertex form one fan.
    pub manifold_vertices: bool,
    /// Every edge is run through as often one way as the other, so that winding numbers are integers.
    /// True of closed, oriented meshes, and of solids that touch along edges.
    pub balanced: bool,
    /// Vertices - edges + triangles.
    pub euler_characteristic: i64,
    /// Handles of all components together, for closed, oriented manifolds.
    pub genus: Option<i64>,
    /// Surface area.
    pub area: f64,
    /// Signed volume; means nothing where the mesh isn't `balanced`.
    pub volume: f64,
    /// The mesh's box.
    pub bounds: Bounds,
    /// Triangles without area.
    pub zero_area_triangles: Defect,
    /// Edges with one face.
    pub boundary_edges: Defect,
    /// Edges with more than two faces.
    pub non_manifold_edges: Defect,
    /// Edges that both of their faces run through in the same direction.
    pub misoriented_edges: Defect,
    /// Vertices whose faces form several fans.
    pub non_manifold_vertices: Defect,
    /// Number of boundary loops.
    pub boundary_loop_count: usize,
    /// The longest boundary loops, longest first.
    pub boundary_loops: Vec<BoundaryLoop>,
    /// Balanced components that are turned inside out: with nothing solid around them, negative volume.
    pub inside_out_components: Defect,
    /// Balanced components of negative volume inside another's solid: hollows.
    pub cavities: Defect,
    /// Balanced components of positive volume inside another's solid.
    pub nested_solids: Defect,
    /// Pairs of balanced components with overlapping boxes, neither inside the other.
    pub overlapping_boxes: Defect,
    /// False where there were too many components to look at all pairs.
    pub nesting_complete: bool,
}

/// Examines a mesh; linear time, and that of sorting its holes.
pub fn diagnose(mesh: &TriangleMesh) -> Diagnosis {
    let topology = Topology::new(mesh);
    diagnose_with(mesh, &topology, None)
}

/// `diagnose`, for who has the topology already, and the components and their nesting where they are known.
pub fn diagnose_with(
    mesh: &TriangleMesh,
    topology: &Topology,
    components: Option<(Parts, Nesting)>,
) -> Diagnosis {
    let ((non_manifold_vertices, vertices), (parts, nesting)) = rayon::join(
        || non_manifold_vertices(mesh, topology),
        || {
            components.unwrap_or_else(|| {
                let (label, count) = topology.components();
                let parts = Parts::new(mesh, topology, &label, count);
                let nesting = find_nesting(mesh, &parts);
                (parts, nesting)
            })
        },
    );
    let components = parts.list.len();
    let edges = examine_edges(mesh, topology);
    let mut boundary_loops = boundary_loops(mesh, topology);
    let boundary_loop_count = boundary_loops.len();
    boundary_loops.truncate(MAX_LOOPS);
    let closed = edges.closed;
    let oriented = edges.misoriented.count == 0;
    let euler = vertices as i64 - topology.edge_count() as i64 + mesh.triangles.len() as i64;
    let manifold = closed && oriented && edges.non_manifold.count == 0 && non_manifold_vertices.count == 0;
    let mut diagnosis = Diagnosis {
        vertices,
        edges: topology.edge_count(),
        triangles: mesh.triangles.len(),
        components,
        closed,
        oriented,
        manifold_edges: edges.non_manifold.count == 0,
        manifold_vertices: non_manifold_vertices.count == 0,
        balanced: edges.balanced,
        euler_characteristic: euler,
        genus: manifold.then_some(components as i64 - euler / 2),
        area: parts.list.iter().map(|part| part.area).sum(),
        volume: parts.list.iter().map(|part| part.volume).sum(),
        bounds: parts.list.iter().fold(Bounds::EMPTY, |all, part| all.joined(&part.bounds)),
        zero_area_triangles: zero_area_triangles(mesh),
        boundary_edges: edges.boundary,
        non_manifold_edges: edges.non_manifold,
        misoriented_edges: edges.misoriented,
        non_manifold_vertices,
        boundary_loop_count,
        boundary_loops,
        inside_out_components: Defect::default(),
        cavities: Defect::default(),
        nested_solids: Defect::default(),
        overlapping_boxes: Defect::default(),
        nesting_complete: nesting.complete,
    };
    add_nesting(&mut diagnosis, mesh, &parts, &nesting);
    diagnosis
}

fn add_nesting(diagnosis: &mut Diagnosis, mesh: &TriangleMesh, parts: &Parts, nesting: &Nesting) {
    let place = |i: usize| corners(mesh, parts.triangles(i)[0] as usize)[0];
    for (i, part) in parts.list.iter().enumerate() {
        if !part.balanced {
            continue;
        }
        let in_solid = nesting.winding_around(parts, i) > 0;
        match (in_solid, part.volume < 0.0) {
            (true, true) => diagnosis.cavities.add(place(i)),
            (true, false) => diagnosis.nested_solids.add(place(i)),
            (false, true) => diagnosis.inside_out_components.add(place(i)),
            (false, false) => {}
        }
    }
    for &(i, _) in &nesting.overlapping {
        diagnosis.overlapping_boxes.add(place(i as usize));
    }
}

struct EdgeDefects {
    boundary: Defect,
    non_manifold: Defect,
    misoriented: Defect,
    balanced: bool,
    closed: bool,
}

fn examine_edges(mesh: &TriangleMesh, topology: &Topology) -> EdgeDefects {
    let mut found = EdgeDefects {
        boundary: Defect::default(),
        non_manifold: Defect::default(),
        misoriented: Defect::default(),
        balanced: true,
        closed: true,
    };
    for edge in topology.edges() {
        let surplus = surplus(edge.sides.iter().copied());
        found.balanced &= surplus == 0;
        found.closed &= edge.sides.len() % 2 == 0;
        match edge.sides.len() {
            1 => found.boundary.add(middle(mesh, &edge)),
            2 if surplus != 0 => found.misoriented.add(middle(mesh, &edge)),
            2 => {}
            _ => found.non_manifold.add(middle(mesh, &edge)),
        }
    }
    found
}

fn middle(mesh: &TriangleMesh, edge: &Edge) -> DVec3 {
    let [a, b] = edge.ends.map(|v| DVec3::from(mesh.vertices[v as usize]));
    a * 0.5 + b * 0.5
}

/// Those, and how many vertices have faces at all.
fn non_manifold_vertices(mesh: &TriangleMesh, topology: &Topology) -> (Defect, usize) {
    let fans = count_fans(mesh, topology);
    let mut defect = Defect::default();
    for (vertex, _) in mesh.vertices.iter().zip(&fans).filter(|(_, fans)| **fans > 1) {
        defect.add(DVec3::from(*vertex));
    }
    (defect, fans.into_iter().filter(|&fans| fans > 0).count())
}

fn zero_area_triangles(mesh: &TriangleMesh) -> Defect {
    let mut defect = Defect::default();
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = corners(mesh, triangle);
        if (b - a).cross(c - a) == DVec3::ZERO {
            defect.add(a);
        }
    }
    defect
}
