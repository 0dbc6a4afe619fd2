//! Eq. 12 of Bender et al. 2020 at any point, on a discretised distance: what the oracle does, line by line.
//!
//! On a line along x, s = 1 - Phi / r is a cubic in each cell. The points of a rule that lie on one line and in one
//! cell share it; cells in which gamma* is 0 or 1 everywhere need no points.

use super::cell_cut::{BlockCell, cubic_on_line, surface_at};
use super::kernel::Content;
use super::quadrature::Point;
use super::window::{contents, monomials_of};
use crate::sdf::field::DistanceField;
use glam::{DVec3, IVec3};
use volmap_formats::asset::Exterior;
use volmap_runtime::layout::Cell;
use volmap_runtime::layout::serendipity::NODES;

/// A rule for the unit ball, as lines along x.
#[derive(Clone, Debug)]
pub struct LineRule {
    /// Sorted by z, then y.
    pub(crate) lines: Vec<Line>,
    pub(crate) x: Vec<f64>,
    pub(crate) weight: Vec<f64>,
    /// Sums of the weights before each point, and of all.
    pub(crate) summed: Vec<f64>,
}

/// Points of a rule on a line along x.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub y: f64,
    pub z: f64,
    pub first: usize,
    pub end: usize,
}

impl LineRule {
    /// The same rule.
    pub fn new(mut points: Vec<Point>) -> LineRule {
        points.sort_by(|a, b| {
            let ([xa, ya, za], [xb, yb, zb]) = (a.position.to_array(), b.position.to_array());
            za.total_cmp(&zb).then(ya.total_cmp(&yb)).then(xa.total_cmp(&xb))
        });
        let mut rule = LineRule { lines: Vec::new(), x: Vec::new(), weight: Vec::new(), summed: vec![0.0] };
        for own in points.chunk_by(|a, b| (a.position.y, a.position.z) == (b.position.y, b.position.z)) {
            let first = rule.x.len();
            let [_, y, z] = own[0].position.to_array();
            rule.lines.push(Line { y, z, first, end: first + own.len() });
            for point in own {
                rule.x.push(point.position.x);
                rule.weight.push(point.weight);
                rule.summed.push(rule.summed[rule.summed.len() - 1] + point.weight);
            }
        }
        rule
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        self.x.len()
    }

    /// Volume that the rule gives the unit ball.
    pub fn ball_volume(&self) -> f64 {
        self.summed[self.count()]
    }
}

/// A field and a radius, ready for integrals.
pub struct Integrator<'a> {
    pub(super) field: &'a DistanceField,
    contents: Vec<u8>,
    pub(super) radius: f64,
}

/// The cells around the last point, which often are those around the next.
#[derive(Clone, Debug, Default)]
pub struct Block {
    low: IVec3,
    size: IVec3,
    cells: Vec<BlockCell>,
    monomials: Vec<[f64; NODES]>,
    /// Room for a layer of cells.
    layer: Vec<Surface>,
}

impl<'a> Integrator<'a> {
    /// For the support radius in metres.
    pub fn new(field: &'a DistanceField, radius: f64) -> Integrator<'a> {
        Integrator { field, contents: contents(field, radius), radius }
    }

    /// The field.
    pub fn field(&self) -> &DistanceField {
        self.field
    }

    /// For x, y, z, whether the lower and the upper side of the domain cut the surface's surroundings: whether a cell
    /// there holds anything but what lies outside. Integrals that reach across such a side don't know what is there.
    pub fn cut_sides(&self) -> [[bool; 2]; 3] {
        let n = self.field.grid.resolution;
        let outside = content_outside(self.field.exterior);
        let mut cut = [[false; 2]; 3];
        let mut mark = |cell: [u32; 3]| {
            for (axis, (at, last)) in cell.into_iter().zip((n - 1).to_array()).enumerate() {
                cut[axis][0] |= at == 0;
                cut[axis][1] |= at == last;
            }
        };
        for (j, k) in (0..n.z).flat_map(|k| (0..n.y).map(move |j| (j, k))) {
            let mut runs = self.field.cells.runs_from(0, j, k).peekable();
            let whole_row = j == 0 || k == 0 || j == n.y - 1 || k == n.z - 1;
            for i in (0..n.x).filter(|&i| whole_row || i == 0 || i == n.x - 1) {
                while runs.next_if(|(range, _)| range.end <= i).is_some() {}
                let content = match runs.peek() {
                    Some((range, Cell::Band(numbers))) if range.start <= i => {
                        self.contents[numbers.along(i - range.start).cell()]
                    }
                    Some((range, Cell::Solid)) if range.start <= i => Content::One as u8,
                    _ => Content::Zero as u8,
                };
                if content != outside as u8 {
                    mark([i, j, k]);
                }
            }
        }
        cut
    }

    /// Boundary volume at a point by each of the rules, m^3.
    pub fn volumes<const N: usize>(&self, rules: [&LineRule; N], x: DVec3, block: &mut Block) -> [f64; N] {
        let grid = &self.field.grid;
        let (place, reach) = ((x - grid.origin) / grid.cell_size, self.radius / grid.cell_size);
        self.fill(block, (place - reach).floor().as_ivec3(), (place + reach).floor().as_ivec3());
        let cube = self.radius.powi(3);
        let kind = |content| block.cells.iter().all(|cell| cell.content == content);
        if kind(Content::Zero) {
            return [0.0; N];
        }
        if kind(Content::One) {
            return rules.map(|rule| cube * rule.ball_volume());
        }
        let mut layer = std::mem::take(&mut block.layer);
        let volumes = rules.map(|rule| cube * integral(rule, block, place, reach, &mut layer));
        block.layer = layer;
        volumes
    }

    /// Looks the cells from `low` to `high` up, unless the block holds these.
    fn fill(&self, block: &mut Block, low: IVec3, high: IVec3) {
        let size = high - low + 1;
        if (low, size) == (block.low, block.size) {
            return;
        }
        (block.low, block.size) = (low, size);
        block.cells.clear();
        block.monomials.clear();
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let cell = self.block_cell(IVec3::new(x, y, z), &mut block.monomials);
                    block.cells.push(cell);
                }
            }
        }
    }

    /// What a cell holds; its monomials of s, if that is mixed, come to the others.
    pub(super) fn block_cell(&self, at: IVec3, monomials: &mut Vec<[f64; NODES]>) -> BlockCell {
        let known = |content| BlockCell { content, number: 0 };
        let resolution = self.field.grid.resolution.as_ivec3();
        if at.cmplt(IVec3::ZERO).any() || at.cmpge(resolution).any() {
            return known(content_outside(self.field.exterior));
        }
        let numbers = match self.field.cells.find(at.as_uvec3()) {
            Cell::Band(numbers) => numbers,
            Cell::Solid => return known(Content::One),
            Cell::Fluid => return known(Content::Zero),
        };
        match self.contents[numbers.cell()] {
            content if content == Content::Zero as u8 => known(Content::Zero),
            content if content == Content::One as u8 => known(Content::One),
            _ => {
                monomials.push(monomials_of(&numbers, &self.field.values, 1.0 / self.radius));
                BlockCell { content: Content::Mixed, number: monomials.len() as u32 - 1 }
            }
        }
    }
}

fn content_outside(exterior: Exterior) -> Content {
    match exterior {
        Exterior::Solid => Content::One,
        Exterior::Fluid => Content::Zero,
    }
}

/// Integral of gamma* over the unit ball around a place, which is in cells of the grid, as is the radius.
fn integral(rule: &LineRule, block: &Block, place: DVec3, reach: DVec3, layer: &mut Vec<Surface>) -> f64 {
    let mut sum = 0.0;
    for lines in rule.lines.chunk_by(|a, b| a.z == b.z) {
        let z = place.z + reach.z * lines[0].z;
        let k = floor(z);
        block.cut(k as i32, 2.0 * (z - k) - 1.0, layer);
        for line in lines {
            let y = place.y + reach.y * line.y;
            let j = floor(y);
            let row = (j as i32 - block.low.y) * block.size.x - block.low.x;
            let local = 2.0 * (y - j) - 1.0;
            let along = Along { place: place.x, reach: reach.x };
            sum += along_line(rule, *line, along, |i| (&layer[(row + i) as usize], local));
        }
    }
    sum
}

/// Where a line of the rule lies along x, in cells: the middle, and the radius.
#[derive(Clone, Copy)]
struct Along {
    place: f64,
    reach: f64,
}

/// The same over a line, given what is in its i-th cell.
fn along_line<'a>(
    rule: &LineRule,
    line: Line,
    Along { place, reach }: Along,
    cell: impl Fn(i32) -> (&'a Surface, f64),
) -> f64 {
    let mut sum = 0.0;
    let mut at = line.first;
    while at < line.end {
        let i = floor(place + reach * rule.x[at]);
        let points = &rule.x[at..line.end];
        // Rounding may take a point to the cell before; there it is as good.
        let count = points.iter().take_while(|x| place + reach * **x < i + 1.0).count().max(1);
        match cell(i as i32) {
            (Surface::Zero, _) => {}
            (Surface::One, _) => sum += rule.summed[at + count] - rule.summed[at],
            (Surface::Mixed(surface), y) => {
                let cubic = cubic_on_line(surface, y);
                let offset = 2.0 * (place - i) - 1.0;
                sum += sum_on_line(&cubic, offset, 2.0 * reach, &points[..count], &rule.weight[at..]);
            }
        }
        at += count;
    }
    sum
}

/// The function of the mathematical library isn't inlined for the baseline of x86-64.
pub(crate) fn floor(x: f64) -> f64 {
    let towards_zero = x as i64 as f64;
    if towards_zero > x { towards_zero - 1.0 } else { towards_zero }
}

/// Sum of gamma* at offset + scale x, by Eq. 13 in truncated powers (as in `kernel`).
#[inline]
pub(crate) fn sum_on_line(
    [c0, c1, c2, c3]: &[f64; 4],
    offset: f64,
    scale: f64,
    points: &[f64],
    weights: &[f64],
) -> f64 {
    let (mut outer, mut inner) = (0.0, 0.0);
    for (x, weight) in points.iter().zip(weights) {
        let x = offset + scale * x;
        let a = (((c3 * x + c2) * x + c1) * x + c0).clamp(0.0, 1.0);
        let b = (a - 0.5).max(0.0);
        outer += weight * (a * a * a);
        inner += weight * (b * b * b);
    }
    2.0 * outer - 8.0 * inner
}

/// What is known of a cell at constant z: gamma* is 0 or 1, or s is a polynomial of x and y: coefficients of 1, y, y^2,
/// y^3, the same times x, and of x^2, x^2 y, x^3, x^3 y.
#[derive(Clone, Copy, Debug)]
enum Surface {
    Zero,
    One,
    Mixed([f64; 12]),
}

impl Block {
    /// Cuts the cells of layer k at z, in [-1, 1].
    fn cut(&self, k: i32, z: f64, layer: &mut Vec<Surface>) {
        let size = (self.size.x * self.size.y) as usize;
        let cells = &self.cells[(k - self.low.z) as usize * size..][..size];
        let surface = |cell: &BlockCell| match cell.content {
            Content::Zero => Surface::Zero,
            Content::One => Surface::One,
            Content::Mixed => Surface::Mixed(surface_at(&self.monomials[cell.number as usize], z)),
        };
        layer.clear();
        layer.extend(cells.iter().map(surface));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sdf::band::find_band;
    use crate::volume_map::oracle;
    use crate::volume_map::quadrature::Rule;
    use crate::watch::Work;
    use glam::UVec3;
    use volmap_runtime::Grid;
    use volmap_runtime::layout::Nodes;

    /// Cells of three lengths, a ball that the domain cuts, both exteriors, points beyond the domain.
    #[test]
    fn integrals_are_those_of_the_oracle() {
        let grid = Grid {
            origin: DVec3::new(-1.3, -0.9, -1.0),
            cell_size: DVec3::new(0.2, 0.25, 0.3),
            resolution: UVec3::new(13, 6, 7),
        };
        for (exterior, invert) in [(Exterior::Fluid, 1.0), (Exterior::Solid, -1.0)] {
            let phi = |p: DVec3| invert * (p.length() - 0.8);
            let cells = find_band(&grid, 0.5, &phi, &Work::default()).unwrap();
            let nodes = Nodes::new(grid.resolution, &cells.band).unwrap();
            let field = DistanceField::sample(grid, &cells, &nodes, exterior, &phi);
            for (radius, rule) in
                [(0.25, Rule::Chord(6)), (0.25, Rule::GaussLegendre(12)), (0.6, Rule::Ball(5))]
            {
                let integrator = Integrator::new(&field, radius);
                let lines = LineRule::new(rule.points());
                let mut block = Block::default();
                for step in 0..300 {
                    let t = f64::from(step);
                    let direction = DVec3::new((t * 0.7).sin(), (t * 1.3).cos(), (t * 2.1).sin());
                    let x = direction * (0.2 + 0.006 * t);
                    let [found] = integrator.volumes([&lines], x, &mut block);
                    let expected = oracle::volume(&field, &rule.points(), radius, x);
                    assert!((found - expected).abs() < 1e-12, "{rule} at {x}: {found}, {expected}");
                }
            }
        }
    }
}
