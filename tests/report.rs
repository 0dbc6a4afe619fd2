//! The report of `volmap report` against errors that are known.

use std::path::Path;
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{Input, MeshSource};
use volmap_bake::plan::{GridChoice, MapSettings, Precision};
use volmap_bake::watch::Watch;
use volmap_formats::asset::{Array, Asset};
use volmap_formats::mesh::{CleanReport, Placement, TriangleMesh};
use volmap_report::report::findings::Findings;
use volmap_report::report::model::{Model, Solid};
use volmap_report::report::reference::Reference;
use volmap_report::report::samples::band_points;
use volmap_report::report::shape::ClosedForm;
use volmap_report::report::thin::{spread, widths};
use volmap_report::report::volume_error::{ErrorPart, Measuring, measure};
use volmap_report::report::{Report, ReportSettings, report};
use volmap_runtime::DVec3;
use volmap_tests::{SPHERE, asset_of, compute};

/// Boxes, each two triangles a side.
fn boxes(corners: &[[[f64; 3]; 2]]) -> Input {
    let mut mesh = TriangleMesh { vertices: Vec::new(), triangles: Vec::new() };
    for [low, high] in corners {
        let first = mesh.vertices.len() as u32;
        let pick = |bit: usize, axis: usize| if bit >> axis & 1 == 0 { low[axis] } else { high[axis] };
        mesh.vertices.extend((0..8).map(|bit| [0, 1, 2].map(|axis| pick(bit, axis))));
        for [a, b, c, d] in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            mesh.triangles.extend([[a, b, c], [a, c, d]].map(|t: [u32; 3]| t.map(|v| v + first)));
        }
    }
    let source = MeshSource { file: "boxes.obj".into(), format: "OBJ".into(), blake3: "0".repeat(64) };
    let cleaning = CleanReport::default();
    Input {
        mesh,
        source,
        cleaning,
        placement: Placement::default(),
        weld_tolerance: 0.0,
        coordinate_step: None,
        shape: None,
        placed_shape: None,
    }
}

fn baked(input: &Input, precision: Precision) -> Asset {
    baked_in(input, precision, None)
}

fn baked_in(input: &Input, precision: Precision, domain: Option<[[f64; 3]; 2]>) -> Asset {
    let map = MapSettings {
        support_radius: Some(0.1),
        grid: GridChoice::CellSize(0.07),
        precision,
        domain,
        ..MapSettings::default()
    };
    let settings = BakeSettings { map, ..BakeSettings::default() };
    bake(input.clone(), &settings, &Watch::default()).unwrap().asset
}

fn quick() -> ReportSettings {
    ReportSettings { points: 300, mesh_points: 60, pixels: 0, ..ReportSettings::default() }
}

fn of(asset: &Asset, mesh: Option<Input>, settings: &ReportSettings) -> Report {
    report(asset, mesh, settings, &Watch::default()).unwrap()
}

#[test]
fn parts_add_up_to_the_whole_error_at_every_point() {
    let input = boxes(&[[[0.0; 3], [0.4, 0.3, 0.5]]]);
    for precision in [Precision::F64, Precision::F32, Precision::Rounded(1e-3)] {
        let asset = baked(&input, precision);
        let (model, solid) = (Model::new(&asset).unwrap(), Solid::new(&asset, input.clone()).unwrap());
        let points = band_points(model.map.grid(), &asset.band_cells, 60, 3);
        let measuring = Measuring {
            model: &model,
            solid: Some(&solid),
            shape: None,
            mesh_points: points.len(),
            gl100_mesh_points: 0,
        };
        let mut storage = 0.0f64;
        let mut known = 0;
        for sample in measure(&measuring, &points, &Watch::default()).unwrap() {
            let Some(parts) = sample.parts else { continue };
            let sum: f64 = ErrorPart::ALL.iter().filter_map(|part| part.of(&parts)).sum();
            let whole = sample.against(Reference::FineMesh).unwrap().error();
            assert!((sum - whole).abs() < 1e-12 * model.ball, "{sum}, {whole} at {}", sample.point);
            storage = storage.max(parts.storage.abs() / model.ball);
            known += 1;
        }
        assert!(known > 40, "{known}");
        // Nothing but rounding of what is stored.
        let (least, most) = match precision {
            Precision::F64 => (0.0, 1e-12),
            Precision::F32 => (1e-9, 1e-5),
            Precision::Rounded(_) => (1e-5, 1e-2),
        };
        assert!((least..most).contains(&storage), "{precision:?}: {storage}");
    }
}

/// The bake knew what lies beyond a side that cuts the solid, the asset doesn't: such points have no parts, the others
/// have the right ones.
#[test]
fn a_domain_that_cuts_the_solid_leaves_its_border_without_parts() {
    let input = boxes(&[[[0.0; 3], [0.8, 0.3, 0.5]]]);
    let asset = baked_in(&input, Precision::F64, Some([[-0.3, -0.3, -0.3], [0.5, 0.7, 0.9]]));
    let findings = of(&asset, Some(input), &quick()).findings;
    let storage = findings.parts.iter().find(|p| p.part == ErrorPart::Storage).unwrap();
    assert!(storage.fraction.max < 1e-12, "{storage:?}");
    assert!((10..50).contains(&storage.fraction.count), "{storage:?}");
}

#[test]
fn a_volume_that_is_wrong_by_a_known_part_is_found_and_fails() {
    let input = boxes(&[[[0.0; 3], [0.6, 0.6, 0.6]]]);
    let mut asset = baked(&input, Precision::F64);
    let honest = of(&asset, Some(input.clone()), &quick()).findings;
    let part = |findings: &Findings, part: ErrorPart| {
        findings.parts.iter().find(|p| p.part == part).unwrap().fraction.max
    };
    assert!(part(&honest, ErrorPart::Storage) < 1e-12);
    // 5 % of the full ball everywhere: the partition of unity carries it through.
    let wrong = 0.05 * honest.asset.ball_volume;
    let Array::F64(volume) = &mut asset.volume else { panic!() };
    volume.iter_mut().for_each(|v| *v += wrong);
    for (limit, passed) in [(0.02, false), (0.2, true)] {
        let settings = ReportSettings { max_error: Some(limit), ..quick() };
        let findings = of(&asset, Some(input.clone()), &settings).findings;
        assert_eq!(findings.verdict.passed, Some(passed));
        let max = findings.verdict.max_error;
        assert!((max - 0.05).abs() < honest.verdict.max_error + 1e-9, "{max}");
        assert!((part(&findings, ErrorPart::Storage) - 0.05).abs() < 1e-9);
        assert!(
            (part(&findings, ErrorPart::Quadrature) - part(&honest, ErrorPart::Quadrature)).abs() < 1e-12
        );
    }
}

#[test]
fn a_closed_form_agrees_with_the_converged_rule_and_shows_the_grid() {
    let settings = MapSettings { support_radius: Some(0.2), ..MapSettings::default() };
    let shape: ClosedForm = "sphere:0,0,0,0.5".parse().unwrap();
    let mut before = f64::INFINITY;
    for resolution in [8, 16, 32] {
        let (plan, maps) = compute(&SPHERE, resolution, &settings);
        let asset = asset_of(&plan, &settings, maps);
        let findings = of(&asset, None, &ReportSettings { shape: Some(shape), ..quick() }).findings;
        assert_eq!(findings.verdict.reference, Reference::Shape);
        let max = findings.verdict.max_error;
        // In the end 0.15 % of the rule are left.
        assert!(max < 0.5 * before, "{resolution}: {max} after {before}");
        before = max;
    }
    assert!(before < 1.5e-3, "{before}");
}

#[test]
fn walls_and_gaps_are_as_wide_as_they_were_made() {
    // A plate of 0.02, 0.05 away from a block of 0.3.
    let input = boxes(&[[[0.0; 3], [1.0, 0.02, 1.0]], [[0.0, 0.07, 0.0], [1.0, 0.37, 1.0]]]);
    let asset = baked(&input, Precision::F32);
    let solid = Solid::new(&asset, input.clone()).unwrap();
    let corner = |v: u32| DVec3::from(input.mesh.vertices[v as usize]);
    let corners: Vec<[DVec3; 3]> = input.mesh.triangles.iter().map(|t| t.map(corner)).collect();
    let numbers: Vec<u32> = (0..corners.len() as u32).collect();
    let points: Vec<(DVec3, u32)> = spread(&corners, &numbers).into_iter().step_by(7).collect();
    let mut counts = [0; 3];
    for (width, (point, _)) in widths(&solid, &points, 0.2, &Watch::default()).unwrap().iter().zip(&points) {
        let margin = |x: f64| (0.1..0.9).contains(&x);
        if !(margin(point.x) && margin(point.z)) {
            continue;
        }
        let is =
            |found: Option<f64>, expected: f64| found.is_some_and(|w| (w - expected).abs() < 2e-3 * expected);
        match point.y {
            0.0 => assert!(is(width.wall, 0.02) && width.gap.is_none(), "{width:?}"),
            0.02 => assert!(is(width.wall, 0.02) && is(width.gap, 0.05), "{width:?}"),
            0.07 => assert!(width.wall.is_none() && is(width.gap, 0.05), "{width:?}"),
            _ => assert!(width.wall.is_none() && width.gap.is_none(), "{width:?}"),
        }
        counts[[0.0, 0.02, 0.07].iter().position(|y| *y == point.y).unwrap_or(0)] += 1;
    }
    assert!(counts.iter().all(|n| *n > 50), "{counts:?}");
    let findings = of(&asset, Some(input), &quick()).findings.thin.unwrap();
    let part = |name: &str| findings.kinds.iter().find(|k| k.description.contains(name)).unwrap().part;
    // Two sides of the plate, one of the block, of 2 + 2 and 4 * 0.02 + 4 * 0.3; close to their edges the ball meets
    // another side first.
    assert!((part("wall thinner than a cell") - 2.0 / 5.28).abs() < 0.05, "{findings:?}");
    assert!((part("gap narrower than a cell") - 1.0 / 5.28).abs() < 0.05, "{findings:?}");
}

#[test]
fn figures_and_pictures_do_not_depend_on_threads() {
    let input = boxes(&[[[0.0; 3], [0.4, 0.3, 0.5]]]);
    let asset = baked(&input, Precision::F32);
    let settings = ReportSettings { pixels: 24, ..quick() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| of(&asset, Some(input.clone()), &settings));
        let pictures: Vec<Vec<u8>> = found.pictures().into_iter().map(|picture| picture.png).collect();
        (serde_json::to_string(&found.findings).unwrap(), pictures)
    };
    let one = on(1);
    assert_eq!(one.1.len(), 5);
    assert!(one == on(3));
    assert!(
        one.0
            != serde_json::to_string(
                &of(&asset, Some(input), &ReportSettings { seed: 2, ..settings }).findings
            )
            .unwrap()
    );
}

/// After a change of the findings: `volmap report --schema > baker/report.schema.json`.
#[test]
fn the_published_schema_is_that_of_the_findings() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../baker/report.schema.json");
    let published: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(published, Findings::schema());
}

/// Two boxes that overlap: the map has no wall inside, the reference neither, and winding numbers agree.
#[test]
fn overlapping_parts_are_measured_against_their_union() {
    let one = boxes(&[[[0.0; 3], [2.0, 1.0, 1.0]]]);
    let two = boxes(&[[[0.0; 3], [1.2, 1.0, 1.0]], [[0.8, 0.0, 0.0], [2.0, 1.0, 1.0]]]);
    let found = of(&baked(&two, Precision::F64), Some(two.clone()), &quick()).findings;
    let check = found.reference_check.unwrap();
    assert!(check.points > 250 && check.contradictions == 0, "{check:?}");
    let single = of(&baked(&one, Precision::F64), Some(one.clone()), &quick()).findings;
    assert!((found.verdict.max_error - single.verdict.max_error).abs() < 1e-9);
    // The map of one box is the union's: no error beyond that of its own cells.
    let across = of(&baked(&one, Precision::F64), Some(two), &quick()).findings;
    assert!((across.verdict.max_error - single.verdict.max_error).abs() < 1e-9);
}
