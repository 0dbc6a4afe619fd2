//! Walls and gaps that the cells can't resolve.

use glam::{DMat3, DVec3};
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{InputSettings, from_arrays};
use volmap_bake::plan::{GridChoice, MapSettings};
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
            let walls = baked(&plate, 0.05, |_| {}).thin.walls;
            assert!(walls.count > 50, "{degrees} {thickness}: {walls:?}");
            assert!((walls.width / thickness - 1.0).abs() < 0.01, "{degrees} {thickness}: {walls:?}");
        }
        // Twice as thick as a cell: resolved.
        let plate = turned(cuboid(DVec3::ZERO, DVec3::new(1.0, 0.8, 0.1)), degrees);
        let summary = baked(&plate, 0.05, |_| {});
        assert_eq!(summary.thin.walls.count, 0, "{degrees}");
        assert!(!warned(&summary, "thinner"));
    }
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
        assert_eq!((cube.thin.walls.count, cube.thin.gaps.count), (0, 0), "{degrees}");
    }
    // A corner of a cube: edges of 55 degrees and more.
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let corner = TriangleMesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] };
    assert_eq!(baked(&corner, 0.05, |_| {}).thin.walls.count, 0);
    let ball = baked(&icosphere(3), 0.1, |_| {});
    assert_eq!((ball.thin.walls.count, ball.thin.gaps.count), (0, 0));
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
