//! The cells that a tolerance finds, against the error measured at other points.

use volmap_bake::bake::{Bake, BakeSettings, bake};
use volmap_bake::input::{InputSettings, load};
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_bake::sdf::{MeshDistance, SignMethod};
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

/// One of 1 % takes ten times as long as one of 5 %.
const TOLERANCES: &[f64] = if cfg!(feature = "long") { &[0.05, 0.01] } else { &[0.05] };

#[test]
fn the_cells_found_keep_the_tolerance_and_coarser_ones_do_not() {
    println!("mesh, tolerance: cell, error as measured by the search; largest and 99 % at 400 other points");
    for (mesh, scale, invert) in
        [("peer/sphere.obj", 0.5, false), ("peer/torus.obj", 0.5, false), ("peer/UnitBox.obj", 1.0, true)]
    {
        for &tolerance in TOLERANCES {
            let bake = baked(mesh, scale, invert, GridChoice::Tolerance(tolerance));
            let found = bake.summary.tolerance.clone().unwrap();
            let [max, most] = true_errors(mesh, scale, invert, &bake);
            println!(
                "{mesh}, {tolerance}: {:.4} m, {:.4}; {max:.4}, {most:.4}",
                found.cell_size, found.error.max
            );
            assert!(found.error.max <= tolerance && found.error.rms <= found.error.max);
            // The largest of other points may be somewhat larger; nearly all must keep it.
            assert!(most <= tolerance && max <= 1.7 * tolerance, "{mesh}: {max} {most}");
            assert_eq!(bake.summary.plan.grid.cell_size, DVec3::splat(found.cell_size));
            // Of the cells tried, the largest that keep it were taken.
            let kept = found.tried.iter().filter(|(_, error)| *error <= tolerance).map(|(cell, _)| *cell);
            assert_eq!(kept.fold(0.0, f64::max), found.cell_size);
            // The same cells give the same map.
            let again = baked(mesh, scale, invert, GridChoice::CellSize(found.cell_size));
            assert_eq!(again.asset.volume, bake.asset.volume);
            // Those that failed do fail.
            let (coarser, _) = *found.tried.iter().rfind(|(_, error)| *error > tolerance).unwrap();
            let [max, _] =
                true_errors(mesh, scale, invert, &baked(mesh, scale, invert, GridChoice::CellSize(coarser)));
            assert!(max > 0.6 * tolerance, "{mesh}: cells of {coarser} m have an error of {max} only");
        }
    }
}
