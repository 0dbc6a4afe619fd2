//! Maps baked for a tolerance, against the error measured at other points.

use volmap_bake::bake::{Bake, BakeSettings, bake};
use volmap_bake::input::{InputSettings, from_shape, load};
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_bake::sdf::{MeshDistance, SignMethod};
use volmap_bake::settings::Tolerances;
use volmap_bake::summary::Summary;
use volmap_bake::volume_map::extension::extension;
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::Watch;
use volmap_formats::mesh::Placement;
use volmap_runtime::{DVec3, VolumeMap};
use volmap_tests::Random;

fn baked(mesh: &str, scale: f64, invert: bool, grid: GridChoice) -> Bake {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(mesh);
    let placement = Placement { scale: [scale; 3], ..Placement::default() };
    let input = load(&path, &InputSettings { placement, ..InputSettings::default() }).unwrap();
    let map = MapSettings { support_radius: Some(0.1), grid, invert, ..MapSettings::default() };
    bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Watch::default()).unwrap()
}

/// Largest error and that of 99 % of random points of the fluid within 2 r, as parts of the ball.
fn true_errors(mesh: &str, scale: f64, invert: bool, bake: &Bake) -> [f64; 2] {
    const R: f64 = 0.1;
    let map = VolumeMap::from_asset(&bake.asset).unwrap();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(mesh);
    let placement = Placement { scale: [scale; 3], ..Placement::default() };
    let input = load(&path, &InputSettings { placement, ..InputSettings::default() }).unwrap();
    let exact = MeshDistance::new(&input.mesh, SignMethod::Auto, &bake.summary.diagnosis);
    let mut known = None;
    let mut phi = |x: DVec3| {
        let mut found = exact.distance_near(x, known.as_ref());
        let phi = exact.side(&mut found) * found.distance;
        known = Some(found);
        if invert { -phi } else { phi }
    };
    let rule = Rule::Ball(9).points();
    let (mut random, mut errors) = (Random::from_state(99), Vec::new());
    while errors.len() < 400 {
        let x = random.point(map.grid().origin, map.grid().max_corner());
        if !(0.0..2.0 * R).contains(&phi(x)) {
            continue;
        }
        let sum: f64 = rule.iter().map(|p| p.weight * extension(phi(x + R * p.position), 1.0 / R)).sum();
        let found = map.sample(x).near().unwrap().volume;
        errors.push((found / R.powi(3) - sum).abs() / (4.0 / 3.0 * std::f64::consts::PI));
    }
    errors.sort_by(f64::total_cmp);
    [errors[errors.len() - 1], errors[errors.len() * 99 / 100]]
}

/// One of 0.5 % takes longer.
const TOLERANCES: &[f64] = if cfg!(feature = "long") { &[0.05, 0.01, 0.005] } else { &[0.05, 0.01] };

const MESHES: [(&str, f64, bool); 3] =
    [("peer/sphere.obj", 0.5, false), ("peer/torus.obj", 0.5, false), ("peer/UnitBox.obj", 1.0, true)];

#[test]
fn adaptive_maps_keep_their_tolerance_at_other_points() {
    println!("mesh, tolerance: cells, error as measured by the bake; largest and 99 % at 400 other points");
    for (mesh, scale, invert) in MESHES {
        let mut before = usize::MAX;
        for &tolerance in TOLERANCES.iter().rev() {
            let bake = baked(mesh, scale, invert, GridChoice::Tolerance(Tolerances::of_volume(tolerance)));
            let found = bake.summary.adapted.clone().unwrap();
            let [max, most] = true_errors(mesh, scale, invert, &bake);
            let errors = found.errors;
            println!("{mesh}, {tolerance}: {:?}, {:.4}; {max:.4}, {most:.4}", found.cells, errors.volume.max);
            assert!(errors.volume.max <= tolerance && errors.volume.rms <= errors.volume.max);
            assert!(errors.distance.max <= 10.0 * tolerance && found.left == 0);
            assert!(most <= tolerance && max <= 1.3 * tolerance, "{mesh}: {max} {most}");
            // Coarser where that does, and the less is stored the more may be wrong.
            let sizes = found.cells.iter().filter(|count| **count > 0).count();
            assert!(sizes > 1 || tolerance > 0.01, "{:?}", found.cells);
            assert!(bake.asset.volume.len() < before, "{mesh}: {} of {before}", bake.asset.volume.len());
            before = bake.asset.volume.len();
        }
    }
}

/// Distance and normal have tolerances of their own. Beside a sphere's mesh, which is convex, the normal jumps nowhere;
/// beside a torus' facets it does, where cells of a quarter of the support radius are the last that are split for it: what
/// it misses is told.
#[test]
fn distances_and_normals_are_as_exact_as_asked_for() {
    let plain = Tolerances { volume: 0.1, distance: 0.5, normal: None };
    let [sphere, torus] = [0, 1].map(|n| {
        let (mesh, scale, invert) = MESHES[n];
        move |tolerances| baked(mesh, scale, invert, GridChoice::Tolerance(tolerances)).summary
    });
    let errors = |found: &Summary| found.adapted.as_ref().unwrap().errors;
    let coarse = torus(plain);
    let by_distance = torus(Tolerances { distance: 0.005, ..plain });
    assert!(errors(&by_distance).distance.max <= 0.005 && errors(&coarse).distance.max > 0.005);
    let angle = 4f64.to_radians();
    let by_normal = Tolerances { normal: Some(angle), ..plain };
    let found = [by_normal, plain].map(|asked| errors(&sphere(asked)).normal.max.to_degrees());
    assert!(found[0] <= 4.0 && found[1] > 4.0, "{found:?}");
    let by_normal = torus(by_normal);
    let found = [&by_normal, &coarse].map(|found| errors(found).normal.max.to_degrees());
    assert!(found[0] < 5.0 && found[1] > 10.0, "{found:?}");
    let told = by_normal.warnings.iter().any(|warning| warning.contains("misses its tolerance: the normal"));
    assert_eq!(told, found[0] > 4.0, "{:?}", by_normal.warnings);
}

/// Of a flat wall there is nothing to store but the distance: a plate's map has large cells but at its rims.
#[test]
fn a_flat_wall_needs_no_small_cells() {
    let shape = |shape: &str, domain: [[f64; 3]; 2]| {
        let settings = InputSettings { shape: Some(shape.parse().unwrap()), ..InputSettings::default() };
        let input = from_shape(settings.shape.unwrap().within(Some(domain)), &settings).unwrap();
        let map = MapSettings {
            support_radius: Some(0.1),
            grid: GridChoice::Tolerance(Tolerances::of_volume(0.005)),
            domain: Some(domain),
            ..MapSettings::default()
        };
        bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Watch::default()).unwrap()
    };
    let bake = shape("plane:0,1,0", [[-1.0, -0.3, -1.0], [1.0, 0.3, 1.0]]);
    let found = bake.summary.adapted.clone().unwrap();
    assert_eq!(found.cells.len(), 1, "{:?}", found.cells);
    let map = VolumeMap::from_asset(&bake.asset).unwrap();
    let ball = map.quadrature().ball_volume;
    let wall = volmap_runtime::layout::FlatWall::new(0.1, ball);
    let mut random = Random::from_state(5);
    for _ in 0..300 {
        let x = random.point(DVec3::new(-0.8, -0.15, -0.8), DVec3::new(0.8, 0.15, 0.8));
        let near = map.sample(x).near().unwrap();
        assert!((near.distance - x.y).abs() < 1e-6, "{x}: {}", near.distance);
        assert!((near.volume - wall.volume(x.y)).abs() < 2e-3 * ball, "{x}: {}", near.volume / ball);
    }
}
