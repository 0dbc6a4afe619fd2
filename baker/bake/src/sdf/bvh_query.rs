//! The closest triangle, by the tree: single precision rules triangles out, double precision decides.

use glam::DVec3;
use std::cell::RefCell;

use crate::sdf::bvh::Bvh;
use crate::sdf::closest_point::{Closest, Feature, TrianglePoint, closest_point_on_triangle};
use crate::sdf::frame::Frame;
use crate::sdf::lanes::LANES;
use crate::sdf::packet::{Packet, Search};

/// Beyond this distance, in sizes of the mesh, boxes in single precision tell nothing any more.
const FAR: f32 = 1e12;

const NOTHING: u32 = u32::MAX;
const NOTHING_FOUND: Closest =
    Closest { distance_squared: f64::INFINITY, point: DVec3::NAN, triangle: NOTHING, feature: Feature::Face };

thread_local! {
    /// What a thread's searches of single points need room for.
    static SEARCH: RefCell<Search> = RefCell::default();
}

impl Bvh {
    /// Point closest to `p`. `upper_bound` is a distance that is known not to be exceeded, such as
    /// a neighbour's distance plus the way from it, or infinity; one that is too small costs time only.
    pub fn closest(&self, p: DVec3, upper_bound: f64) -> Closest {
        // Its lists would be allocated anew each time.
        SEARCH.with_borrow_mut(|search| self.closest_to_each(&[p], &[upper_bound; LANES], search)[0])
    }

    /// The points closest to each of up to [`LANES`] points, of which there must be at least one: `closest` of each,
    /// faster together the closer they are to each other. Only as many are set.
    pub(crate) fn closest_to_each(
        &self,
        points: &[DVec3],
        upper_bounds: &[f64; LANES],
        search: &mut Search,
    ) -> [Closest; LANES] {
        let mut best = [NOTHING_FOUND; LANES];
        for (best, bound) in best.iter_mut().zip(upper_bounds) {
            best.distance_squared = bound * bound * (1.0 + 1e-9);
        }
        let is_far = |p: &DVec3| self.frame.local(*p).iter().any(|x| x.is_nan() || x.abs() > FAR);
        if points.iter().any(is_far) {
            points.iter().zip(&mut best).for_each(|(p, best)| *best = self.closest_of_all(*p));
            return best;
        }
        self.search(points, search, &mut best);
        for (p, best) in points.iter().zip(&mut best).filter(|(_, best)| best.triangle == NOTHING) {
            let mut again = [NOTHING_FOUND; LANES];
            self.search(&[*p], search, &mut again);
            *best = if again[0].triangle == NOTHING { self.closest_of_all(*p) } else { again[0] };
        }
        best
    }

    /// The closest triangles within the bounds, if there are any.
    fn search(&self, points: &[DVec3], search: &mut Search, best: &mut [Closest; LANES]) {
        let mut packet = self.packet(points, best);
        search.start();
        while search.go_on(self, &mut packet) {
            self.close(points, search, best);
        }
        self.close(points, search, best);
    }

    /// The points in the frame of the tree; lanes to spare hold the last.
    fn packet(&self, points: &[DVec3], best: &[Closest; LANES]) -> Packet {
        let mut packet = Packet::default();
        for lane in 0..LANES {
            let from = lane.min(points.len() - 1);
            let local = self.frame.local(points[from]);
            let slack = Frame::slack(local);
            (0..3).for_each(|axis| packet.points[axis].0[lane] = local[axis]);
            packet.radius.0[lane] = self.frame.radius(best[from].distance_squared, slack);
            packet.slack.0[lane] = slack as f32;
        }
        packet
    }

    /// Looks at the triangles of the open leaves that may be the closest, in double precision.
    fn close(&self, points: &[DVec3], search: &mut Search, best: &mut [Closest; LANES]) {
        for leaf in search.open.drain(..) {
            for (place, mut bits) in leaf.candidates.into_iter().enumerate() {
                // Lanes to spare repeat the last point.
                bits &= (1 << points.len()) - 1;
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    self.visit(leaf.block as usize, place, points[lane], &mut best[lane]);
                }
            }
        }
    }

    /// Takes the point of a triangle if none before was closer.
    #[inline]
    fn visit(&self, block: usize, place: usize, p: DVec3, best: &mut Closest) {
        let corners = self.leaves.blocks[block].triangle(place);
        let triangle = self.leaves.ids[block][place];
        let TrianglePoint { distance_squared, point, feature } = closest_point_on_triangle(p, &corners);
        let closer = distance_squared < best.distance_squared;
        if closer || distance_squared == best.distance_squared && triangle < best.triangle {
            *best = Closest { distance_squared, point, triangle, feature };
        }
    }

    /// For points so far away that the tree cannot help, or that are not numbers.
    fn closest_of_all(&self, p: DVec3) -> Closest {
        let mut best = NOTHING_FOUND;
        for block in self.block_numbers() {
            (0..4).for_each(|place| self.visit(block, place, p, &mut best));
        }
        if best.triangle == NOTHING {
            // Nothing is closer than infinity.
            let first = self.block_numbers().min().expect("a tree has triangles");
            let corners = self.leaves.blocks[first].triangle(0);
            let TrianglePoint { distance_squared, point, feature } = closest_point_on_triangle(p, &corners);
            best = Closest { distance_squared, point, triangle: self.leaves.ids[first][0], feature };
        }
        best
    }
}
