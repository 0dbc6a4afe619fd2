//! Walls and gaps that the cells can't resolve.

use glam::{DMat3, DVec3};
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{InputSettings, from_arrays};
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_bake::sdf::thin::ThinPlaces;
use volmap_bake::summary::Summary;
use volmap_formats::mesh::TriangleMesh;

use crate::shapes::{cuboid, icosphere, merged};

fn baked(mesh: &TriangleMesh, cell: f64, change: impl Fn(&mut MapSettings)) -> Summary {
    let input = from_arrays("made", &mesh.vertices, &mesh.triangles, &InputSettings::default()).unwrap();
    let mut map =
        MapSettings { support_radius: Some(0.1), grid: GridChoice::CellSize(cell), ..MapSettings::default() };
    change(&mut map);
    bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Default::default()).unwrap().summary
}

fn turned(mut mesh: TriangleMesh, degrees: f64) -> TriangleMesh {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), degrees.to_radians());
    mesh.vertices.iter_mut().for_each(|v| *v = (turn * DVec3::from(*v)).to_array());
    mesh
}

fn warned(summary: &Summary, words: &str) -> bool {
    summary.warnings.iter().any(|warning| warning.contains(words))
}

#[test]
fn plates_thinner_than_a_cell_are_told_however_they_lie() {
    for degrees in [0.0, 7.0, 33.0, 45.0] {
        for thickness in [0.002, 0.02, 0.04] {
            let plate = turned(cuboid(DVec3::ZERO, DVec3::new(1.0, 0.8, thickness)), degrees);
            let ThinPlaces { walls, rods, .. } = baked(&plate, 0.05, |_| {}).thin;
            assert!(walls.count > 50, "{degrees} {thickness}: {walls:?}");
            assert!((walls.width / thickness - 1.0).abs() < 0.01, "{degrees} {thickness}: {walls:?}");
            assert_eq!(rods.count, 0, "{degrees} {thickness}: {rods:?}");
        }
        // Twice as thick as a cell: resolved.
        let plate = turned(cuboid(DVec3::ZERO, DVec3::new(1.0, 0.8, 0.1)), degrees);
        let summary = baked(&plate, 0.05, |_| {});
        assert_eq!(summary.thin.walls.count, 0, "{degrees}");
        assert!(!warned(&summary, "thinner"));
    }
}

/// A prism around the z-axis, of so many sides, radius and length, in so many pieces.
fn prism(sides: u32, radius: f64, length: f64, pieces: u32) -> TriangleMesh {
    let corner = |piece: u32, side: u32| {
        let angle = std::f64::consts::TAU * (f64::from(side) + 0.5) / f64::from(sides);
        [radius * angle.cos(), radius * angle.sin(), length * f64::from(piece) / f64::from(pieces)]
    };
    let all = (0..=pieces).flat_map(|piece| (0..sides).map(move |side| corner(piece, side)));
    let mut prism = TriangleMesh { vertices: all.collect(), triangles: Vec::new() };
    for (piece, side) in (0..pieces).flat_map(|piece| (0..sides).map(move |side| (piece, side))) {
        let (a, b) = (piece * sides + side, piece * sides + (side + 1) % sides);
        prism.triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
    }
    let top = pieces * sides;
    for side in 1..sides - 1 {
        prism.triangles.extend([[0, side + 1, side], [top, top + side, top + side + 1]]);
    }
    prism
}

#[test]
fn rods_thinner_than_a_cell_are_told_however_they_lie() {
    // A body beside them, so that the map has a solid.
    let body = cuboid(DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.5, 0.5, 1.0));
    let mut wrong = Vec::new();
    for (degrees, sides, pieces) in [(0.0, 4, 1), (7.0, 4, 1), (33.0, 3, 1), (45.0, 6, 10), (20.0, 16, 10)] {
        for radius in [0.001, 0.01, 0.015] {
            let rod = turned(merged(&[prism(sides, radius, 1.0, pieces), body.clone()]), degrees);
            let summary = baked(&rod, 0.05, |_| {});
            let (rods, walls) = (&summary.thin.rods, &summary.thin.walls);
            let inner = 2.0 * radius * (std::f64::consts::PI / f64::from(sides)).cos();
            let width = if rods.count > 0 { rods.width } else { walls.width };
            let told = format!("{degrees} {sides} {radius}: {rods:?} {walls:?}");
            let is_told = rods.count + walls.count > 5 && warned(&summary, "thinner than a cell (0.05 m)");
            if !is_told || !(0.7 * inner..1.05 * inner).contains(&width) {
                wrong.push(told);
            }
        }
        // Twice as thick as a cell: resolved.
        let thick = turned(merged(&[prism(sides, 0.12, 1.0, pieces), body.clone()]), degrees);
        assert_eq!(baked(&thick, 0.05, |_| {}).thin.rods.count, 0, "{degrees} {sides}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn gaps_are_told_and_thickness_narrows_them() {
    let pair = |gap: f64| {
        let right = cuboid(DVec3::new(0.5 + gap, 0.0, 0.0), DVec3::new(1.0 + gap, 0.5, 0.5));
        turned(merged(&[cuboid(DVec3::ZERO, DVec3::splat(0.5)), right]), 11.0)
    };
    let summary = baked(&pair(0.01), 0.05, |_| {});
    assert!(summary.thin.gaps.count > 10 && summary.thin.walls.count == 0, "{:?}", summary.thin);
    assert!((summary.thin.gaps.width / 0.01 - 1.0).abs() < 0.01);
    assert!(warned(&summary, "gaps narrower than a cell"));
    assert_eq!(baked(&pair(0.08), 0.05, |_| {}).thin.gaps.count, 0);
    let narrowed = baked(&pair(0.08), 0.05, |map| map.thickness = 0.02).thin.gaps;
    assert!((narrowed.width / 0.04 - 1.0).abs() < 0.02, "{narrowed:?}");
}

#[test]
fn a_thickened_plate_is_resolved_and_a_container_has_its_gaps_and_walls_the_other_way_round() {
    let plate = turned(cuboid(DVec3::ZERO, DVec3::new(1.0, 0.8, 0.004)), 7.0);
    assert_eq!(baked(&plate, 0.05, |map| map.thickness = 0.03).thin.walls.count, 0);
    let flat_container = baked(&plate, 0.05, |map| map.invert = true).thin;
    assert!(flat_container.gaps.count > 50 && flat_container.walls.count == 0, "{flat_container:?}");
}

#[test]
fn edges_and_round_bodies_are_not_thin() {
    for degrees in [0.0, 20.0, 45.0] {
        let cube = baked(&turned(cuboid(DVec3::ZERO, DVec3::splat(0.7)), degrees), 0.05, |_| {});
        let thin = &cube.thin;
        assert_eq!((thin.walls.count, thin.gaps.count, thin.rods.count), (0, 0, 0), "{degrees}");
    }
    // A corner of a cube: edges of 55 degrees and more.
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let corner = TriangleMesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] };
    let thin = baked(&corner, 0.05, |_| {}).thin;
    assert_eq!((thin.walls.count, thin.rods.count), (0, 0));
    let ball = baked(&icosphere(3), 0.1, |_| {});
    assert_eq!((ball.thin.walls.count, ball.thin.gaps.count, ball.thin.rods.count), (0, 0, 0));
}

#[test]
fn a_container_that_its_thickness_fills_is_told() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let filled = baked(&cube, 0.05, |map| (map.invert, map.thickness) = (true, 0.6));
    assert!(warned(&filled, "nothing is left for the fluid"), "{:?}", filled.warnings);
    assert!(!warned(&baked(&cube, 0.05, |map| map.invert = true), "nothing is left"));
}

#[test]
fn why_a_map_has_no_solid_is_told() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let doubled = merged(&[cube.clone(), crate::shapes::flipped(cube.clone())]);
    assert!(warned(&baked(&doubled, 0.05, |_| {}), "the opposite way round"));
    let input = from_arrays(
        "made",
        &cube.vertices,
        &crate::shapes::flipped(cube.clone()).triangles,
        &InputSettings::default(),
    );
    let map = MapSettings { support_radius: Some(0.1), ..MapSettings::default() };
    let settings = BakeSettings { map, keep_orientation: true, ..BakeSettings::default() };
    let summary = bake(input.unwrap(), &settings, &Default::default()).unwrap().summary;
    assert!(warned(&summary, "faces point inwards"), "{:?}", summary.warnings);
}

#[test]
fn coordinates_coarser_than_the_cells_are_told() {
    let far = |rounded: fn(f64) -> f64| {
        let mut ball = icosphere(3);
        ball.vertices.iter_mut().flatten().for_each(|x| *x = rounded(*x + 4_650_000.0));
        baked(&ball, 0.05, |_| {})
    };
    assert!(warned(&far(|x| f64::from(x as f32)), "the file's coordinates lie 0.5 m apart"));
    assert!(!warned(&far(|x| x), "coordinates lie"));
}
