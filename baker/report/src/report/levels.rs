//! Cells of several sizes: how many there are of each level, how exact they are, and why they aren't larger.
//!
//! A cell that is twice as large would have the cubic through its own 32 nodes. Where that misses, within, by more than the
//! tolerance that the asset was baked for, the eight cells had to be; the largest miss names the cause. The volume is
//! compared with the map's; the distance with the mesh's, or with the map's if there is no mesh.

use super::model::{Model, Solid};
use super::statistics::Measurement;
use crate::error::Error;
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use volmap_bake::adaptive::DEPTH;
use volmap_bake::provenance;
use volmap_bake::sdf::SignedDistance;
use volmap_formats::asset::Asset;
use volmap_runtime::layout::serendipity::{NODES, node, shape, shape_and_gradient};
use volmap_runtime::layout::{FlatWall, Held, Levels};
use volmap_runtime::{Grid, Sample};

/// Larger cells that are looked at for each level, at most.
const LOOKED_AT: usize = 2_000;

/// The cells of a level.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LevelFacts {
    /// 0 for the largest cells, of half the size from level to level.
    pub level: u32,
    /// Longest edge of a cell, metres.
    pub edge: f64,
    /// Stored cells.
    pub cells: u64,
    /// Their part of the volume of all stored cells.
    pub part: f64,
    /// Points of the report in the fluid in them.
    pub points: usize,
    /// Largest error of the volume at those, against the verdict's reference, as a part of the full ball.
    pub max_error: f64,
    /// Why the cells aren't twice as large; none for level 0.
    pub causes: Option<Causes>,
}

/// What keeps cells from being twice as large. Parts of the larger cells that were looked at; they add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Causes {
    /// Larger cells that were looked at.
    pub looked_at: usize,
    /// The volume would be too wrong, in either form.
    pub volume: f64,
    /// The distance would be.
    pub distance: f64,
    /// The normal would be.
    pub normal: f64,
    /// Nothing would be there: cells beside these are still smaller, or their errors in place were too large.
    pub neighbours: f64,
    /// They would reach beyond the band, where nothing is stored that could be looked at.
    pub edge: f64,
}

/// The levels of an adaptive map.
pub struct LevelMap {
    levels: Levels,
    /// How many there are.
    pub count: u32,
}

impl LevelMap {
    /// None of uniform maps.
    pub fn new(asset: &Asset) -> Option<LevelMap> {
        let lists = asset.levels();
        let levels = asset.is_adaptive().then(|| Levels::new(Grid::from(asset.grid), &lists));
        let count = asset.cells_by_level().len() as u32;
        levels?.ok().map(|levels| LevelMap { levels, count })
    }

    /// The level of the cell that holds a point; none outside the band.
    pub fn level(&self, point: DVec3) -> Option<u32> {
        match self.levels.find(point) {
            Held::Band { level, .. } => Some(level),
            _ => None,
        }
    }

    /// Edges of the cells of a level, metres.
    pub fn cell_size(&self, level: u32) -> DVec3 {
        self.levels.grid(level).cell_size
    }

    /// All cells, by their levels and their lowest and highest corners, metres.
    pub fn boxes(&self) -> impl Iterator<Item = (u32, [DVec3; 2])> + '_ {
        self.levels.cells().map(|cell| {
            let grid = self.levels.grid(cell.level);
            (cell.level, [grid.cell_corner(cell.index), grid.cell_corner(cell.index + 1)])
        })
    }
}

/// The facts of all levels. `errors` are those of the verdict's reference.
///
/// # Errors
/// Tolerances that no bake writes.
pub fn facts(
    map: &LevelMap,
    asset: &Asset,
    model: &Model,
    solid: Option<&Solid>,
    errors: &[Measurement],
) -> Result<Vec<LevelFacts>, Error> {
    let cells = asset.cells_by_level();
    let weight = |level: usize| cells[level] as f64 / 8f64.powi(level as i32);
    let all: f64 = (0..cells.len()).map(weight).sum();
    let found: Vec<(u32, f64)> = errors
        .iter()
        .filter(|error| error.distance >= 0.0)
        .filter_map(|error| Some((map.level(error.point)?, error.error().abs() / model.ball)))
        .collect();
    let judge = Judge {
        model,
        solid,
        wall: FlatWall::new(asset.support_radius, asset.quadrature.ball_volume),
        tolerances: Tolerances::of(asset)?,
    };
    let of_level = |level: u32| {
        let own = || found.iter().filter(move |(of, _)| *of == level);
        LevelFacts {
            level,
            edge: map.cell_size(level).max_element(),
            cells: cells[level as usize],
            part: weight(level as usize) / all,
            points: own().count(),
            max_error: own().map(|(_, error)| *error).fold(0.0, f64::max),
            causes: (level > 0).then(|| judge.causes(map, level)),
        }
    };
    Ok((0..map.count).map(of_level).collect())
}

/// What the map was baked for.
struct Tolerances {
    volume: f64,
    distance: f64,
    /// Radians.
    normal: Option<f64>,
}

impl Tolerances {
    /// What the asset doesn't say was not asked for.
    fn of(asset: &Asset) -> Result<Tolerances, Error> {
        let real = |name| provenance::real(asset, name, f64::INFINITY);
        let normal = real("normal_tolerance")?;
        Ok(Tolerances {
            volume: real("tolerance")?,
            distance: real("distance_tolerance")?,
            normal: normal.is_finite().then(|| normal.to_radians()),
        })
    }
}

/// What larger cells are judged by.
struct Judge<'a> {
    model: &'a Model,
    solid: Option<&'a Solid>,
    wall: FlatWall,
    tolerances: Tolerances,
}

#[derive(Clone, Copy, PartialEq)]
enum Cause {
    Volume,
    Distance,
    Normal,
    Neighbours,
    Edge,
}

/// A cell twice as large as those that are there.
struct Larger {
    low: DVec3,
    size: DVec3,
}

/// Of the map at a place.
#[derive(Clone, Copy)]
struct Values {
    distance: f64,
    volume: f64,
}

impl Judge<'_> {
    /// Of the larger cells that hold those of a level, evenly chosen.
    fn causes(&self, map: &LevelMap, level: u32) -> Causes {
        let of_level = map.levels.cells().filter(|cell| cell.level == level);
        let parents: BTreeSet<[u32; 3]> = of_level.map(|cell| (cell.index / 2).to_array()).collect();
        let step = parents.len().div_ceil(LOOKED_AT).max(1);
        let chosen: Vec<[u32; 3]> = parents.into_iter().step_by(step).collect();
        let grid = map.levels.grid(level - 1);
        let larger = |index: [u32; 3]| Larger { low: grid.cell_corner(index.into()), size: grid.cell_size };
        let found: Vec<Cause> = chosen.into_par_iter().map(|index| self.cause(&larger(index))).collect();
        let part = |cause: Cause| {
            found.iter().filter(|own| **own == cause).count() as f64 / found.len().max(1) as f64
        };
        Causes {
            looked_at: found.len(),
            volume: part(Cause::Volume),
            distance: part(Cause::Distance),
            normal: part(Cause::Normal),
            neighbours: part(Cause::Neighbours),
            edge: part(Cause::Edge),
        }
    }

    fn cause(&self, cell: &Larger) -> Cause {
        let at_nodes: [Option<Values>; NODES] = std::array::from_fn(|a| self.at(cell.place(node(a))));
        let Some(nodes) = at_nodes.into_iter().collect::<Option<Vec<Values>>>() else { return Cause::Edge };
        let mut worst = [0.0f64; 4];
        for n in 0..125 {
            let xi = 0.5 * (IVec3::new(n % 5, n / 5 % 5, n / 25) - 2).as_dvec3();
            let found = self.errors(cell, xi, &nodes).unwrap_or_default();
            worst.iter_mut().zip(found).for_each(|(worst, error)| *worst = worst.max(error));
        }
        let [plain, plane, distance, normal] = worst;
        let found = [(Cause::Volume, plain.min(plane)), (Cause::Distance, distance), (Cause::Normal, normal)];
        let largest = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        largest.filter(|(_, error)| *error > 1.0).map_or(Cause::Neighbours, |(cause, _)| cause)
    }

    /// What a larger cell misses at a place, as parts of the tolerances: the volume in both forms, distance, normal.
    fn errors(&self, cell: &Larger, xi: DVec3, nodes: &[Values]) -> Option<[f64; 4]> {
        let place = cell.place(xi);
        let exact = self.at(place).filter(|exact| exact.distance >= -DEPTH * self.model.radius)?;
        let parts: [f64; NODES] = shape(xi);
        let sum = |value: &dyn Fn(&Values) -> f64| -> f64 {
            parts.iter().zip(nodes).map(|(part, node)| part * value(node)).sum()
        };
        let distance = sum(&|node| node.distance);
        let plain = sum(&|node| node.volume) - exact.volume;
        let difference = sum(&|node| node.volume - self.wall.volume(node.distance));
        let plane = difference + self.wall.volume(distance) - exact.volume;
        let of_ball = |error: f64| error.abs() / self.model.ball / self.tolerances.volume;
        let mut found = [of_ball(plain), of_ball(plane), 0.0, 0.0];
        if exact.distance <= self.model.radius {
            found[2] = (distance - exact.distance).abs() / self.model.radius / self.tolerances.distance;
            found[3] = self.normal_error(cell, xi, nodes, place);
        }
        Some(found)
    }

    /// Angle as a part of its tolerance.
    fn normal_error(&self, cell: &Larger, xi: DVec3, nodes: &[Values], place: DVec3) -> f64 {
        let Some(tolerance) = self.tolerances.normal else { return 0.0 };
        let Sample::Near(near) = self.model.map.sample(place) else { return 0.0 };
        let (_, slopes) = shape_and_gradient(xi);
        let slope: DVec3 = slopes.iter().zip(nodes).map(|(slope, node)| *slope * node.distance).sum();
        near.normal.angle_between(slope / cell.size) / tolerance
    }

    fn at(&self, x: DVec3) -> Option<Values> {
        let values = self.model.map.values(x);
        let distance = self.solid.map_or(values.distance, |solid| solid.phi.at(x));
        values.distance.is_finite().then_some(Values { distance, volume: values.volume })
    }
}

impl Larger {
    fn place(&self, xi: DVec3) -> DVec3 {
        self.low + self.size * (0.5 * (xi + 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_bake::bake::{BakeSettings, bake};
    use volmap_bake::input::{InputSettings, from_shape};
    use volmap_bake::primitive::Primitive;
    use volmap_bake::settings::{GridChoice, MapSettings, Tolerances};
    use volmap_bake::watch::Watch;

    fn cube(tolerances: Tolerances) -> (Asset, Solid) {
        let cube = Primitive::Box { size: [1.0; 3] };
        let input = from_shape(cube, &InputSettings::default()).unwrap();
        let grid = GridChoice::Tolerance(tolerances);
        let map = MapSettings { support_radius: Some(0.2), grid, invert: true, ..MapSettings::default() };
        let settings = BakeSettings { map, ..BakeSettings::default() };
        let asset = bake(input.clone(), &settings, &Watch::default()).unwrap().asset;
        let solid = Solid::new(&asset, input).unwrap();
        (asset, solid)
    }

    #[test]
    fn levels_are_those_of_the_asset_and_each_tolerance_is_a_cause() {
        let by_volume = Tolerances { volume: 0.01, distance: 10.0, normal: None };
        let by_distance = Tolerances { volume: 0.5, distance: 0.02, normal: None };
        for (tolerances, is_volume) in [(by_volume, true), (by_distance, false)] {
            let (asset, solid) = cube(tolerances);
            let model = Model::new(&asset).unwrap();
            let inside = DVec3::new(0.45, 0.0, 0.1);
            let error =
                Measurement { point: inside, distance: 0.05, value: model.ball, reference: 0.5 * model.ball };
            let map = LevelMap::new(&asset).unwrap();
            let levels = facts(&map, &asset, &model, Some(&solid), &[error]).unwrap();
            let cells: Vec<u64> = levels.iter().map(|level| level.cells).collect();
            assert_eq!(cells, asset.cells_by_level());
            let sizes = levels.iter().map(|level| level.cells as f64 * level.edge.powi(3));
            let all: f64 = sizes.clone().sum();
            assert!(levels.iter().zip(sizes).all(|(level, size)| (level.part - size / all).abs() < 1e-12));
            let hit: Vec<&LevelFacts> = levels.iter().filter(|level| level.points > 0).collect();
            assert!(hit.len() == 1 && hit[0].points == 1 && (hit[0].max_error - 0.5).abs() < 1e-12);
            assert!(levels[0].causes.is_none());
            let causes: Vec<Causes> = levels.iter().filter_map(|level| level.causes).collect();
            for c in causes.iter().filter(|causes| causes.looked_at > 0) {
                let sum = c.volume + c.distance + c.normal + c.neighbours + c.edge;
                assert!((sum - 1.0).abs() < 1e-12 && c.normal == 0.0, "{c:?}");
            }
            let most = |part: fn(&Causes) -> f64| causes.iter().map(part).fold(0.0, f64::max);
            let (volume, distance) = (most(|c| c.volume), most(|c| c.distance));
            assert!(if is_volume { volume > 0.2 && distance == 0.0 } else { distance > 0.2 }, "{causes:?}");
        }
    }
}
