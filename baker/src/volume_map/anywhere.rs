//! Eq. 12 of Bender et al. 2020 at any point, on a discretised distance: what the oracle does, line by line.
//!
//! On a line along x, s = 1 - Phi / r is a cubic in each cell. The points of a rule that lie on one line and in one
//! cell share it; cells in which gamma* is 0 or 1 everywhere need no points.

use super::kernel::Content;
use super::quadrature::Point;
use super::window::{contents, monomials_of};
use crate::sdf::field::DistanceField;
use glam::{DVec3, IVec3};
use volmap_formats::asset::Exterior;
use volmap_runtime::Cell;
use volmap_runtime::serendipity::NODES;

/// A rule for the unit ball, as lines along x.
#[derive(Clone, Debug)]
pub struct LineRule {
    lines: Vec<Line>,
    x: Vec<f64>,
    weight: Vec<f64>,
    /// Sums of the weights before each point, and of all.
    summed: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Line {
    y: f64,
    z: f64,
    first: usize,
    end: usize,
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
    field: &'a DistanceField,
    contents: Vec<u8>,
    radius: f64,
}

/// The cells around the last point, which often are those around the next.
#[derive(Clone, Debug, Default)]
pub struct Block {
    low: IVec3,
    size: IVec3,
    cells: Vec<BlockCell>,
    monomials: Vec<[f64; NODES]>,
}

#[derive(Clone, Copy, Debug)]
struct BlockCell {
    content: Content,
    /// In the block's monomials, if the content is mixed.
    number: u32,
}

impl Block {
    fn cell(&self, at: IVec3) -> BlockCell {
        let IVec3 { x, y, z } = at - self.low;
        self.cells[(x + self.size.x * (y + self.size.y * z)) as usize]
    }
}

impl<'a> Integrator<'a> {
    /// For the support radius in metres.
    pub fn new(field: &'a DistanceField, radius: f64) -> Integrator<'a> {
        Integrator { field, contents: contents(field, radius), radius }
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
        let all_solid = kind(Content::One);
        rules.map(|rule| match all_solid {
            true => cube * rule.ball_volume(),
            false => cube * integral(rule, block, place, reach),
        })
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

    fn block_cell(&self, at: IVec3, monomials: &mut Vec<[f64; NODES]>) -> BlockCell {
        let known = |content| BlockCell { content, number: 0 };
        let resolution = self.field.grid.resolution.as_ivec3();
        if at.cmplt(IVec3::ZERO).any() || at.cmpge(resolution).any() {
            let solid = self.field.exterior == Exterior::Solid;
            return known(if solid { Content::One } else { Content::Zero });
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

/// Integral of gamma* over the unit ball around a place, which is in cells of the grid, as is the radius.
fn integral(rule: &LineRule, block: &Block, place: DVec3, reach: DVec3) -> f64 {
    let mut sum = 0.0;
    for line in &rule.lines {
        let (y, z) = (place.y + reach.y * line.y, place.z + reach.z * line.z);
        let (j, k) = (y.floor(), z.floor());
        let across = [2.0 * (y - j) - 1.0, 2.0 * (z - k) - 1.0];
        let mut at = line.first;
        while at < line.end {
            let i = (place.x + reach.x * rule.x[at]).floor();
            let points = &rule.x[at..line.end];
            // Rounding may take a point to the cell before; there it is as good.
            let count = points.iter().take_while(|x| place.x + reach.x * **x < i + 1.0).count().max(1);
            let cell = block.cell(DVec3::new(i, j, k).as_ivec3());
            match cell.content {
                Content::Zero => {}
                Content::One => sum += rule.summed[at + count] - rule.summed[at],
                Content::Mixed => {
                    let cubic = cubic_on_line(&block.monomials[cell.number as usize], across);
                    let offset = 2.0 * (place.x - i) - 1.0;
                    sum += on_line(&cubic, offset, 2.0 * reach.x, (&points[..count], &rule.weight[at..]));
                }
            }
            at += count;
        }
    }
    sum
}

/// Sum of gamma* at offset + scale x, by Eq. 13 in truncated powers (as in `kernel`).
fn on_line([c0, c1, c2, c3]: &[f64; 4], offset: f64, scale: f64, (points, weights): (&[f64], &[f64])) -> f64 {
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

/// The coefficients of 1, x, x^2, x^3 at constant y and z; the monomials are listed in `kernel`.
fn cubic_on_line(m: &[f64; NODES], [y, z]: [f64; 2]) -> [f64; 4] {
    let pair = |at: usize| m[at] + m[at + 1] * y + (m[at + 2] + m[at + 3] * y) * z;
    let side = |a: usize| {
        let in_y = |c: usize| {
            m[a + 4 * c] + y * (m[a + 2 + 4 * c] + y * (m[16 + a + 2 * c] + y * m[20 + a + 2 * c]))
        };
        let in_z = |at: usize| m[at + a] + m[at + a + 2] * y;
        in_y(0) + z * (in_y(1) + z * (in_z(24) + z * in_z(28)))
    };
    [side(0), side(1), pair(8), pair(12)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sdf::band::find_band;
    use crate::volume_map::oracle;
    use crate::volume_map::quadrature::Rule;
    use crate::work::Work;
    use glam::UVec3;
    use volmap_runtime::{Grid, Nodes};

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
            let cells = find_band(&grid, 0.5, &phi, &Work::new(0));
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
