//! Whether a map has a solid, and at what part of its nodes the sign is in doubt.

use volmap_bake::bake::{Bake, BakeSettings, bake};
use volmap_bake::describe::SIGN_DOUBT;
use volmap_bake::doubt::{MAX_SIGN_DISAGREEMENTS, has_solid};
use volmap_bake::input::{InputSettings, from_bytes};
use volmap_bake::settings::MapSettings;
use volmap_bake::watch::Watch;
use volmap_formats::asset::Value;

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

fn baked(mesh: &str, support_radius: f64, check_sign: bool) -> Bake {
    let input = from_bytes("mesh.obj".as_ref(), mesh.as_bytes(), &InputSettings::default()).unwrap();
    let map = MapSettings { support_radius: Some(support_radius), ..MapSettings::default() };
    let settings = BakeSettings { map, check_sign, ..BakeSettings::default() };
    bake(input, &settings, &Watch::default()).unwrap()
}

fn warns(bake: &Bake, text: &str) -> bool {
    bake.summary.warnings.iter().any(|warning| warning.contains(text))
}

#[test]
fn closed_meshes_have_exact_signs_and_nothing_is_compared() {
    let cube = baked(CUBE, 0.25, false);
    assert_eq!((cube.summary.sign_doubt(), cube.summary.sign_comparison.is_none()), (0.0, true));
    assert!(!cube.asset.diagnosis.contains_key(SIGN_DOUBT) && !warns(&cube, "in doubt"));
    assert!(has_solid(cube.asset.signed_distance.to_f64().into_iter(), 0.25));
    // Pseudonormals of cubes that intersect are wrong at some nodes, but the sign isn't theirs.
    let corners = CUBE.lines().filter(|line| line.starts_with('v'));
    let moved: String = corners.map(|line| line.replace(" 1", " 1.5").replace(" 0", " 0.5") + "\n").collect();
    let faces = "f 9 11 12 10\nf 13 14 16 15\nf 9 10 14 13\nf 11 15 16 12\nf 9 13 15 11\nf 10 12 16 14\n";
    let two = baked(&format!("{CUBE}{moved}{faces}"), 0.25, true).summary;
    assert!(two.sign_comparison.as_ref().unwrap().points > 0 && two.sign_doubt() == 0.0);
}

#[test]
fn a_missing_face_puts_signs_in_doubt() {
    let open = CUBE.replace("f 2 4 8 6\n", "");
    for radius in [0.1, 0.25] {
        let (sampled, whole) = (baked(&open, radius, false), baked(&open, radius, true));
        let (part, exact) = (sampled.summary.sign_doubt(), whole.summary.sign_doubt());
        assert!(part > MAX_SIGN_DISAGREEMENTS && (part - exact).abs() < 0.005, "{radius}: {part} {exact}");
        assert!(warns(&sampled, "the sign is in doubt at about"), "{:?}", sampled.summary.warnings);
        assert_eq!(sampled.asset.diagnosis[SIGN_DOUBT], Value::from(part));
        assert!(sampled.summary.sign_comparison.as_ref().unwrap().points <= 4096);
    }
    // With a narrow band the sign jumps where no node is: that counts, too.
    let narrow = baked(&open, 0.02, false).summary;
    let signs = narrow.sign_comparison.as_ref().unwrap();
    let differing = signs.disagreeing as f64 / signs.points as f64;
    let leaking = narrow.leaks as f64 / narrow.cells.band as f64;
    assert!(
        leaking > 0.005 && (narrow.sign_doubt() - differing - leaking).abs() < 1e-12,
        "{differing} {leaking}"
    );
}

#[test]
fn a_small_hole_is_no_doubt() {
    // A corner of a face of 0.1 x 0.1 is cut off.
    let mesh = CUBE.replace("f 2 4 8 6\n", "v 1 0.1 0\nv 1 0 0.1\nf 9 4 8 6 10\n");
    let bake =
        baked(&mesh.replace("f 1 3 4 2", "f 1 3 4 9 2").replace("f 1 2 6 5", "f 1 2 10 6 5"), 0.1, false);
    assert!(!bake.summary.diagnosis.closed && !bake.summary.has_exact_sign);
    assert!(bake.summary.sign_doubt() < MAX_SIGN_DISAGREEMENTS && !warns(&bake, "in doubt"));
}

#[test]
fn a_sheet_has_no_solid() {
    let sheet = baked("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n", 0.1, false);
    assert!(!has_solid(sheet.asset.signed_distance.to_f64().into_iter(), 0.1));
    assert!(sheet.summary.sign_doubt() > 0.4 && warns(&sheet, "the map has no solid"));
}
