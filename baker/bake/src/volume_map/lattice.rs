//! Eq. 12 of Bender et al. 2020, or Eq. 9, at all nodes of a grid.
//!
//! On a regular lattice, the cell and the local coordinates of (node + quadrature point) depend only on the class
//! of the node: corner, or one of the two thirds of an edge along x, y or z; 7 classes. So the points of a class are
//! laid out once: by the row of cells, relative to the node's, that they fall into, by cell, and in it by planes and
//! lines. The nodes of a row are then worked on together: for each row of cells within reach, its polynomials are laid
//! side by side in a [`Window`], which serves all classes. Cells in which gamma* is 0 or 1 everywhere need no work.

use super::dispatch::{self, Kernel};
use super::kernel::{self, Content, Group, Window, linear};
use super::quadrature::Point;
use super::window::{FieldWindows, contents};
use crate::rows::{NodeRow, RowCluster, fill_clusters};
use crate::sdf::field::DistanceField;
use crate::watch::{Cancelled, Work};
use glam::{DVec3, IVec3, UVec3};
use volmap_runtime::layout::{Family, Nodes};

/// The points of all classes that fall into one row of cells.
struct RowOfCells {
    /// The row, from the node's.
    y: i32,
    z: i32,
    /// Lowest and highest step along x of any group.
    steps: [i32; 2],
    /// Per family and node of a lattice point, the groups.
    classes: [Vec<Vec<Group>>; 4],
}

/// A rule laid out on a lattice of cells.
pub struct LatticeRule {
    rows: Vec<RowOfCells>,
    /// Cells along x that one node reaches, at most.
    reach: usize,
    extension: Extension,
    /// Where the extension function becomes 0, metres.
    length: f64,
    /// Of the sums.
    factor: f64,
}

/// Which extension function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extension {
    /// gamma*, Eq. 13.
    Cubic,
    /// gamma, Eq. 11, which grows on into the solid.
    Linear,
}

/// Cells of a window: 16 KiB of polynomials, which stay in the first cache.
const WINDOW: usize = 64;
/// For support radii of very many cells.
const WIDE_WINDOW: usize = 2048;
/// Cells along x within the support radius of a node, at most.
pub const MAX_REACH: f64 = 900.0;

/// What a thread reuses from row to row.
#[derive(Default)]
struct Scratch<const S: usize> {
    window: Window<S>,
    /// Per node row and node of a lattice point, the sums so far.
    sums: Vec<Vec<f64>>,
}

impl LatticeRule {
    /// Lays the rule's points (of the unit ball) out on cells of the given size; metres. The radius may be up to
    /// [`MAX_REACH`] cells.
    pub fn new(points: &[Point], radius: f64, cell_size: DVec3) -> LatticeRule {
        let rows = rows(points, radius / cell_size);
        let reach =
            rows.iter().map(|cells| (cells.steps[1] - cells.steps[0]) as usize + 1).max().unwrap_or(0);
        LatticeRule { rows, reach, extension: Extension::Cubic, length: radius, factor: radius.powi(3) }
    }

    /// The same for the density, from points whose weights hold the smoothing kernel of unit support. `length`: where
    /// the extension function becomes 0, metres.
    pub fn for_density(points: &[Point], radius: f64, cell_size: DVec3, length: f64) -> LatticeRule {
        let mut rule = LatticeRule::new(points, radius, cell_size);
        let classes = rule.rows.iter_mut().flat_map(|row| &mut row.classes);
        for group in classes.flatten().flatten() {
            group.moments = linear::moments(group);
        }
        LatticeRule { extension: Extension::Linear, length, factor: 1.0, ..rule }
    }

    /// Boundary volume at every node, m^3, or its density over rest density. The nodes' lattice lies `shift` cells
    /// inside the field's grid. For the density, the field must hold all of the ball around each node that is
    /// solid. Each node counts as work.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn integrals(
        &self,
        field: &DistanceField,
        nodes: &Nodes,
        shift: UVec3,
        work: &Work,
    ) -> Result<Vec<f64>, Cancelled> {
        let contents = contents(field, self.length);
        let windows = FieldWindows { field, contents: &contents, inverse_radius: 1.0 / self.length, shift };
        let integrals = match (2 * self.reach <= WINDOW, self.extension) {
            (true, Extension::Cubic) => {
                self.integrals_by(&windows, nodes, dispatch::kernel::<WINDOW>(), work)
            }
            (false, Extension::Cubic) => {
                self.integrals_by(&windows, nodes, dispatch::kernel::<WIDE_WINDOW>(), work)
            }
            (true, Extension::Linear) => {
                self.integrals_by(&windows, nodes, dispatch::linear_kernel::<WINDOW>(), work)
            }
            (false, Extension::Linear) => {
                self.integrals_by(&windows, nodes, dispatch::linear_kernel::<WIDE_WINDOW>(), work)
            }
        };
        work.check()?;
        Ok(integrals)
    }

    fn integrals_by<const S: usize>(
        &self,
        windows: &FieldWindows,
        nodes: &Nodes,
        kernel: Kernel<S>,
        work: &Work,
    ) -> Vec<f64> {
        // A window holds what the nodes reach, and whole lanes.
        let length = S - self.reach - 2 * kernel::LANES;
        fill_clusters(nodes, length as u32, Scratch::default, |scratch, cluster| {
            if work.is_cancelled() {
                return;
            }
            self.cluster(windows, scratch, cluster, &kernel);
            work.add(cluster.rows.iter().map(|(_, own)| own.len() as u64).sum());
        })
    }

    fn cluster<const S: usize>(
        &self,
        windows: &FieldWindows,
        scratch: &mut Scratch<S>,
        cluster: &mut RowCluster,
        kernel: &Kernel<S>,
    ) {
        let places = sum_places(cluster);
        scratch.sums.resize_with(scratch.sums.len().max(places.len()), Vec::new);
        for (sums, (row, _)) in scratch.sums.iter_mut().zip(&places) {
            sums.clear();
            sums.resize(((row.end - row.first) as usize).next_multiple_of(kernel::LANES), 0.0);
        }
        for cells in &self.rows {
            let first = i64::from(cluster.first) + i64::from(cells.steps[0]);
            let width = (cluster.end - cluster.first) as usize + (cells.steps[1] - cells.steps[0]) as usize;
            let width = (width + kernel::LANES).next_multiple_of(kernel::LANES);
            let at = [i64::from(cluster.j) + i64::from(cells.y), i64::from(cluster.k) + i64::from(cells.z)];
            match windows.contents(first, at, width, &mut scratch.window) {
                Some(Content::Zero) => continue,
                Some(_) if self.extension == Extension::Cubic => {}
                _ => windows.polynomials(first, at, &mut scratch.window, kernel),
            }
            for (sums, &(row, t)) in scratch.sums.iter_mut().zip(&places) {
                let groups = &cells.classes[row.family as usize][t];
                let column = (row.first - cluster.first) as i32 - cells.steps[0];
                (kernel.accumulate)(groups, &scratch.window, column, sums);
            }
        }
        self.write(&scratch.sums, cluster);
    }

    fn write(&self, sums: &[Vec<f64>], cluster: &mut RowCluster) {
        let mut sums = sums.iter();
        for (row, out) in &mut cluster.rows {
            let per_point = row.family.nodes_per_point() as usize;
            for (t, sums) in sums.by_ref().take(per_point).enumerate() {
                let own = out.iter_mut().skip(t).step_by(per_point);
                own.zip(sums).for_each(|(value, sum)| *value = self.factor * sum);
            }
        }
    }
}

/// The rows of nodes of a cluster, once per node of a lattice point.
fn sum_places(cluster: &RowCluster) -> Vec<(NodeRow, usize)> {
    let thirds = |row: NodeRow| (0..row.family.nodes_per_point() as usize).map(move |t| (row, t));
    cluster.rows.iter().flat_map(|(row, _)| thirds(*row)).collect()
}

/// A point of the rule, seen from a node of some class.
#[derive(Clone, Copy)]
struct Placed {
    family: Family,
    t: u32,
    cell: IVec3,
    xi: DVec3,
    weight: f64,
}

/// All points of all classes, by the row of cells that they fall into.
fn rows(points: &[Point], scale: DVec3) -> Vec<RowOfCells> {
    let classes =
        Family::ALL.into_iter().flat_map(|family| (0..family.nodes_per_point()).map(move |t| (family, t)));
    let place = |(family, t): (Family, u32)| {
        points.iter().map(move |point| {
            let u = family.offset(t) + scale * point.position;
            let cell = u.floor();
            let xi = (u - cell) * 2.0 - DVec3::ONE;
            Placed { family, t, cell: cell.as_ivec3(), xi, weight: point.weight }
        })
    };
    let mut placed: Vec<Placed> = classes.flat_map(place).collect();
    // Stable and total: the order of the sum is the same on every machine.
    placed.sort_by(|a, b| {
        let row = |p: &Placed| (p.cell.z, p.cell.y, p.family as u32, p.t, p.cell.x);
        let inside =
            a.xi.y.total_cmp(&b.xi.y).then(a.xi.z.total_cmp(&b.xi.z)).then(a.xi.x.total_cmp(&b.xi.x));
        row(a).cmp(&row(b)).then(inside)
    });
    placed.chunk_by(|a, b| (a.cell.y, a.cell.z) == (b.cell.y, b.cell.z)).map(row_of_cells).collect()
}

fn row_of_cells(members: &[Placed]) -> RowOfCells {
    let steps = || members.iter().map(|p| p.cell.x);
    let mut classes = Family::ALL.map(|family| vec![Vec::new(); family.nodes_per_point() as usize]);
    for own in members.chunk_by(|a, b| (a.family, a.t, a.cell.x) == (b.family, b.t, b.cell.x)) {
        classes[own[0].family as usize][own[0].t as usize].push(group(own));
    }
    RowOfCells {
        y: members[0].cell.y,
        z: members[0].cell.z,
        steps: [steps().min().unwrap_or(0), steps().max().unwrap_or(0)],
        classes,
    }
}

fn group(members: &[Placed]) -> Group {
    let mut group = Group { step: members[0].cell.x, ..Group::default() };
    for plane in members.chunk_by(|a, b| a.xi.y == b.xi.y) {
        let lines = plane.chunk_by(|a, b| a.xi.z == b.xi.z);
        group.planes.push((plane[0].xi.y, lines.clone().count() as u32));
        group.lines.extend(lines.map(|line| (line[0].xi.z, line.len() as u32)));
        group.points.extend(plane.iter().map(|p| [p.xi.x, p.weight]));
    }
    group.total = kernel::total(&group);
    group
}
