//! Up to eight points that lie close together go down the tree together.
//!
//! Wald, Slusallek, Benthin and Wagner 2001, "Interactive rendering with coherent ray tracing", for points instead of
//! rays: a box or a triangle is loaded once and compared with all points, one to a lane, and is visited if one of them
//! needs it. The points of a lattice point and its edges are less than a cell apart, and mostly need the same.
//!
//! Distances are in single precision with bounds on their errors. They only tell which triangles can't be the closest;
//! the rest is looked at in double precision, so that the result doesn't depend on how the search went.

#[cfg(target_arch = "x86_64")]
use crate::sdf::avx2;
use crate::sdf::bvh::{Bvh, LEAF, NO_CHILD};
use crate::sdf::lanes::{Lanes, Row, Vectorized};
use wide::f32x8;

/// Leaves that are kept open at a time.
const MAX_OPEN: usize = 24;

/// Points in the frame of the tree, and the spheres around them in which the closest triangle is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Packet {
    pub points: [Row; 3],
    pub radius: Row,
    /// By how much a distance can be too long because the point is rounded.
    pub slack: Row,
}

/// A node or leaf to be visited, and the squared distances of its box.
#[derive(Clone, Copy, Debug)]
struct Entry {
    distance_squared: Row,
    child: u32,
}

/// A leaf that may hold the closest triangle of some point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpenLeaf {
    distance_squared: [Row; 4],
    pub block: u32,
    /// For each of its triangles, a bit for each point to which it may be the closest.
    pub candidates: [u32; 4],
}

/// What a search needs room for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    stack: Vec<Entry>,
    /// The leaves that are left in the end.
    pub open: Vec<OpenLeaf>,
}

impl Search {
    pub fn start(&mut self) {
        self.open.clear();
        self.stack.clear();
        self.stack.push(Entry { distance_squared: Row::default(), child: 0 });
    }

    /// Goes on until there is nothing left to visit, or too many leaves are open: true.
    pub fn go_on(&mut self, tree: &Bvh, packet: &mut Packet) -> bool {
        let visits = Visits { search: self, tree, packet };
        #[cfg(target_arch = "x86_64")]
        return avx2::run(visits).unwrap_or_else(|visits| visits.run::<f32x8>());
        #[cfg(not(target_arch = "x86_64"))]
        visits.run::<f32x8>()
    }
}

struct Visits<'a> {
    search: &'a mut Search,
    tree: &'a Bvh,
    packet: &'a mut Packet,
}

/// A packet in registers.
#[derive(Clone, Copy)]
struct Spheres<V> {
    points: [V; 3],
    radius: V,
    radius_squared: V,
}

impl Vectorized for Visits<'_> {
    type Output = bool;

    /// The box nearest to the first point comes first.
    #[inline(always)]
    fn run<V: Lanes>(self) -> bool {
        let Visits { search, tree, packet } = self;
        let [x, y, z] = &packet.points;
        let radius = V::load(&packet.radius);
        let mut spheres =
            Spheres { points: [V::load(x), V::load(y), V::load(z)], radius, radius_squared: radius * radius };
        let slack = V::load(&packet.slack);
        let mut full = false;
        while let Some(entry) = search.stack.pop() {
            if V::load(&entry.distance_squared).within(spheres.radius_squared) == 0 {
                continue;
            }
            if entry.child & LEAF == 0 {
                visit_node(search, tree, &spheres, entry.child);
                continue;
            }
            let upper = visit_leaf(search, tree, &spheres, entry.child & !LEAF);
            spheres.radius = spheres.radius.min(upper + slack);
            spheres.radius_squared = spheres.radius * spheres.radius;
            full = search.open.len() >= MAX_OPEN;
            if full {
                break;
            }
        }
        for leaf in &mut search.open {
            let reach_squared = tree.leaves.coarse[leaf.block as usize].reach_squared(spheres.radius);
            for (bits, distance_squared) in leaf.candidates.iter_mut().zip(&leaf.distance_squared) {
                *bits = V::load(distance_squared).within(reach_squared);
            }
        }
        packet.radius = spheres.radius.store();
        full
    }
}

#[inline(always)]
fn visit_node<V: Lanes>(search: &mut Search, tree: &Bvh, spheres: &Spheres<V>, node: u32) {
    let children = &tree.nodes[node as usize].children;
    let mut distances = [Row::default(); 4];
    let mut keys = [0; 4];
    for (slot, child) in children.iter().enumerate() {
        if child.child == NO_CHILD {
            break;
        }
        let distance_squared = child.bounds.distances_squared(&spheres.points);
        distances[slot] = distance_squared.store();
        if distance_squared.within(spheres.radius_squared) != 0 {
            // Floats of one sign order like integers: one comparison sorts distance and slot. 0 is none.
            keys[slot] = u64::from(distances[slot].0[0].to_bits()) << 32 | 4 | slot as u64;
        }
    }
    for key in farthest_first(keys) {
        if key == 0 {
            break;
        }
        let slot = (key & 3) as usize;
        search.stack.push(Entry { distance_squared: distances[slot], child: children[slot].child });
    }
}

/// Opens the leaf if it may hold what is closest to some point. Returns upper bounds on its distances.
#[inline(always)]
fn visit_leaf<V: Lanes>(search: &mut Search, tree: &Bvh, spheres: &Spheres<V>, block: u32) -> V {
    let coarse = &tree.leaves.coarse[block as usize];
    let mut leaf = OpenLeaf { distance_squared: [Row::INFINITE; 4], block, candidates: [0; 4] };
    let mut nearest = V::splat(f32::INFINITY);
    for (out, triangle) in leaf.distance_squared.iter_mut().zip(coarse.triangles()) {
        let distance_squared = triangle.distances_squared(&spheres.points);
        *out = distance_squared.store();
        nearest = nearest.min(distance_squared);
    }
    let [lower, upper] = coarse.bounds(nearest.sqrt());
    if lower.within(spheres.radius) != 0 {
        search.open.push(leaf);
    }
    upper
}

/// A sorting network.
#[inline(always)]
fn farthest_first([a, b, c, d]: [u64; 4]) -> [u64; 4] {
    let (a, b) = (a.min(b), a.max(b));
    let (c, d) = (c.min(d), c.max(d));
    let (a, c) = (a.min(c), a.max(c));
    let (b, d) = (b.min(d), b.max(d));
    [d, b.max(c), b.min(c), a]
}
