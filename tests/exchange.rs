//! Maps for other programs and from them: round trips to the bit, the peer's own interpolation, surfaces that close.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{InputSettings, load};
use volmap_bake::iso_surface::lattice::LatticeChoice;
use volmap_bake::iso_surface::{IsoSurface, iso_surface};
use volmap_bake::plan::{GridChoice, MapSettings, Precision};
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::Watch;
use volmap_formats::asset::{Array, Asset, Exterior};
use volmap_formats::export::cdm::{DiscreteGrid, REMOVED, UNSAMPLED, from_bytes, to_bytes};
use volmap_formats::export::vti::Numbers;
use volmap_formats::mesh::Placement;
use volmap_report::export::discregrid::discregrid;
use volmap_report::export::hexahedra::hexahedra;
use volmap_report::export::image::image;
use volmap_report::export::{ExportField, ExportSettings};
use volmap_report::import::{Import, ImportSettings, from_grid, import};
use volmap_runtime::{DVec3, Sample, VolumeMap};
use volmap_tests::{Random, SPHERE, Solid, TORUS, asset_of, compute};

const R: f64 = 0.1;
const IMPORT: ImportSettings = ImportSettings { support_radius: R, exterior: None };

fn peer(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("peer").join(name)
}

fn settings() -> MapSettings {
    MapSettings {
        support_radius: Some(R),
        rule: Rule::Ball(4),
        precision: Precision::F64,
        ..MapSettings::default()
    }
}

fn baked(mesh: &str, map: MapSettings) -> Asset {
    let placement = Placement { scale: [0.5, 0.5, 0.75], ..Placement::default() };
    let input = load(&peer(mesh), &InputSettings { placement, ..InputSettings::default() }).unwrap();
    bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Watch::default()).unwrap().asset
}

fn computed(solid: &Solid, resolution: u32, r: f64) -> Asset {
    let settings = MapSettings { support_radius: Some(r), ..settings() };
    let (plan, maps) = compute(solid, resolution, &settings);
    asset_of(&plan, &settings, maps)
}

fn bits(field: &Array) -> Vec<u64> {
    match field {
        Array::F64(v) => v.iter().map(|x| x.to_bits()).collect(),
        Array::F32(v) => v.iter().map(|&x| f64::from(x).to_bits()).collect(),
        other => panic!("{}", other.type_name()),
    }
}

fn through_a_file(asset: &Asset, settings: &ImportSettings) -> Import {
    let grid = from_bytes(&to_bytes(&discregrid(asset, true, &Watch::default()).unwrap())).unwrap();
    from_grid(&grid, settings).unwrap()
}

#[test]
fn maps_come_back_to_the_bit() {
    let uneven = GridChoice::Resolution([17, 9, 23]);
    let cut = Some([[-0.2, -0.5, -0.9], [0.9, 0.3, 0.9]]);
    let cases = [
        ("torus.obj", settings()),
        ("torus.obj", MapSettings { invert: true, grid: uneven, ..settings() }),
        (
            "sphere.obj",
            MapSettings { thickness: 0.03, grid: uneven, precision: Precision::F32, ..settings() },
        ),
        ("sphere.obj", MapSettings { thickness: -0.05, invert: true, ..settings() }),
        ("torus.obj", MapSettings { domain: cut, ..settings() }),
    ];
    for (mesh, map) in cases {
        let name = format!("{mesh} {map:?}");
        let asset = baked(mesh, map);
        let back = through_a_file(&asset, &ImportSettings { exterior: Some(asset.exterior), ..IMPORT }).asset;
        assert_eq!((back.grid, back.exterior), (asset.grid, asset.exterior), "{name}");
        assert_eq!(bits(&back.signed_distance), bits(&asset.signed_distance), "{name}");
        assert_eq!(bits(&back.volume), bits(&asset.volume), "{name}");
        assert!((back.quadrature.ball_volume / asset.quadrature.ball_volume - 1.0).abs() < 1e-6, "{name}");
        let (map, other) = (VolumeMap::from_asset(&asset).unwrap(), VolumeMap::from_asset(&back).unwrap());
        let mut random = Random::from_state(5);
        for _ in 0..20_000 {
            let x = random.point(map.grid().origin - 0.1, map.grid().max_corner() + 0.1);
            let (sample, there) = (map.sample(x), other.sample(x));
            // A cell whose 32 nodes are all there comes back as stored, though it lies beyond 2 r.
            let beyond = |sample: Sample| sample.near().is_none_or(|b| b.distance.abs() > 2.0 * R);
            assert!(sample == there || beyond(sample) && beyond(there), "{name} {x}: {sample:?} {there:?}");
        }
    }
}

/// The peer's distance to a container is sign (d - T), with sign = -1 for `mapInvert`: ours with -T.
#[test]
fn a_containers_thickness_is_the_peers_with_the_other_sign() {
    let thickness = 0.03;
    let settings = || MapSettings { grid: GridChoice::CellSize(0.05), ..settings() };
    let bare = VolumeMap::from_asset(&baked("sphere.obj", settings())).unwrap();
    let asset = baked("sphere.obj", MapSettings { invert: true, thickness: -thickness, ..settings() });
    let ours = VolumeMap::from_asset(&asset).unwrap();
    let mut random = Random::from_state(7);
    let mut checked = 0;
    while checked < 500 {
        let x = random.point(bare.grid().origin, bare.grid().max_corner());
        let (Sample::Near(d), Sample::Near(own)) = (bare.sample(x), ours.sample(x)) else { continue };
        if d.distance.abs() < R {
            let peers = -(d.distance - thickness);
            assert!((own.distance - peers).abs() < 2e-3, "{x}: {} {peers}", own.distance);
            checked += 1;
        }
    }
    let notes = through_a_file(&asset, &ImportSettings { exterior: Some(Exterior::Solid), ..IMPORT }).notes;
    assert!(notes.len() == 1 && notes[0].contains("a `thickness` of -T"), "{notes:?}");
    let of_body = through_a_file(&baked("sphere.obj", settings()), &IMPORT);
    assert!(of_body.notes.is_empty(), "{:?}", of_body.notes);
}

#[test]
fn what_is_outside_is_told_by_the_border() {
    for invert in [false, true] {
        let asset = baked("torus.obj", MapSettings { invert, ..settings() });
        assert_eq!(through_a_file(&asset, &IMPORT).asset.exterior, asset.exterior);
    }
    let cut = Some([[-0.2, -0.5, -0.9], [0.9, 0.3, 0.9]]);
    let grid =
        discregrid(&baked("torus.obj", MapSettings { domain: cut, ..settings() }), true, &Watch::default())
            .unwrap();
    assert!(from_grid(&grid, &IMPORT).unwrap_err().contains("`exterior`"));
}

#[test]
fn fields_that_are_no_volume_are_refused() {
    let asset = baked("sphere.obj", settings());
    let grid = discregrid(&asset, true, &Watch::default()).unwrap();
    // A density map of SPlisHSPlasH is 1 and more deep in the solid: 239 balls of this support radius.
    let with = |change: &dyn Fn(f64) -> f64| {
        let mut grid = grid.clone();
        let stored = grid.fields[1].nodes.iter_mut().filter(|value| **value != UNSAMPLED);
        stored.for_each(|value| *value = change(*value));
        from_grid(&grid, &IMPORT)
    };
    let ball = asset.quadrature.ball_volume;
    let error = with(&|volume| volume / ball).unwrap_err();
    for part in
        ["up to 1, 239 times the full ball", "probably a density map or a tube map", "0.6204 m would fit"]
    {
        assert!(error.contains(part), "no `{part}` in {error}");
    }
    assert!(with(&|volume| volume / 100.0).unwrap_err().contains("0.01 times the full ball"));
    assert!(with(&|volume| -volume).unwrap_err().contains("a volume is not negative"));
    // Maps of versions before 2.19.
    let older = with(&|volume| 0.8 * volume).unwrap();
    assert!(older.warnings[0].contains("0.8 of the full ball"), "{:?}", older.warnings);
}

#[test]
fn deep_in_the_solid_the_distance_goes_on() {
    // Far more than the support radius lies beyond the band; distances there are known.
    for (solid, r) in [(SPHERE, 0.03), (TORUS, 0.02)] {
        let asset = computed(&solid, 40, r);
        let grid = discregrid(&asset, true, &Watch::default()).unwrap();
        let field = &grid.fields[0];
        let (mut worst, mut deepest, mut checked) = (0.0f64, 0.0f64, 0);
        for (cell, &stored) in field.cell_map.iter().enumerate().filter(|(_, stored)| **stored != REMOVED) {
            let n = grid.resolution.map(|n| n as usize);
            let at =
                DVec3::new((cell % n[0]) as f64, (cell / n[0] % n[1]) as f64, (cell / (n[0] * n[1])) as f64);
            let node = field.cells[stored as usize][0];
            let exact = (solid.phi)(DVec3::from(grid.min) + at * DVec3::from(grid.cell_size));
            let value = field.nodes[node as usize];
            if grid.fields[1].nodes[node as usize] == UNSAMPLED {
                worst = worst.max((value - exact).abs() / DVec3::from(grid.cell_size).max_element());
                deepest = deepest.min(exact);
                checked += 1;
            }
        }
        println!("{}: {checked} corners, down to {deepest:.3} m, worst {worst:.1e} of a cell", solid.name);
        assert!(checked > 100 && deepest < -7.0 * r, "{checked} {deepest}");
        // Neighbours know the surface at points about a cell apart, and may pass on one that is not the closest.
        assert!(worst < 0.25, "{}: {worst}", solid.name);
    }
}

#[test]
fn the_peers_map_is_interpolated_as_the_peer_does() {
    let import = import(&peer("torus_map.cdm"), &IMPORT).unwrap();
    assert!(import.warnings.is_empty(), "{:?}", import.warnings);
    assert_eq!(import.asset.exterior, Exterior::Fluid);
    let map = VolumeMap::from_asset(&import.asset).unwrap();
    let table = std::fs::read_to_string(peer("torus_map.csv")).unwrap();
    let mut count = 0;
    for line in table.lines().skip(1) {
        let [x, y, z, distance, volume] =
            <[f64; 5]>::try_from(line.split(',').map(|t| t.parse().unwrap()).collect::<Vec<_>>()).unwrap();
        let values = map.values(DVec3::new(x, y, z));
        assert!((values.distance - distance).abs() < 2e-15, "{line}: {values:?}");
        assert!((values.volume - volume).abs() < 1e-17, "{line}: {values:?}");
        count += 1;
    }
    assert_eq!(count, 120);
}

/// The sphere's map after a change, imported.
fn refusal(change: &dyn Fn(&mut DiscreteGrid)) -> String {
    let mut grid = discregrid(&computed(&SPHERE, 16, R), true, &Watch::default()).unwrap();
    change(&mut grid);
    from_grid(&grid, &IMPORT).unwrap_err()
}

#[test]
fn maps_that_make_no_sense_are_refused() {
    let near = |grid: &DiscreteGrid| grid.fields[0].nodes.iter().position(|d| d.abs() < 0.5 * R).unwrap();
    let node = |grid: &DiscreteGrid| near(grid) as u32;
    let cases = [
        ("without a volume", refusal(&|grid| grid.fields.truncate(1))),
        (
            "no volume in cells",
            refusal(&|grid| {
                let node = near(grid);
                grid.fields[1].nodes[node] = UNSAMPLED;
            }),
        ),
        (
            "between fluid and solid",
            refusal(&|grid| {
                let node = near(grid);
                grid.fields[0].nodes[node] = UNSAMPLED;
            }),
        ),
        (
            "disagree",
            refusal(&|grid| {
                let node = node(grid);
                grid.fields[0].nodes.push(0.25 * R);
                let other = grid.fields[0].nodes.len() as u32 - 1;
                let cell = grid.fields[0].cells.iter_mut().find(|cell| cell.contains(&node)).unwrap();
                cell.iter_mut().filter(|n| **n == node).for_each(|n| *n = other);
            }),
        ),
        (
            "no cell",
            refusal(&|grid| grid.fields[1].nodes.fill(UNSAMPLED)).replace("no volume in cells", "no cell"),
        ),
    ];
    for (part, text) in cases {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn cells_that_the_peer_left_out_are_what_lies_beside_them() {
    let asset = computed(&SPHERE, 24, 0.05);
    assert!(!asset.solid_cells.is_empty());
    let mut grid = discregrid(&asset, true, &Watch::default()).unwrap();
    let unsampled: Vec<bool> = grid.fields[1].nodes.iter().map(|v| *v == UNSAMPLED).collect();
    for field in &mut grid.fields {
        for stored in field.cell_map.iter_mut().filter(|stored| **stored != REMOVED) {
            if field.cells[*stored as usize].iter().any(|&node| unsampled[node as usize]) {
                *stored = REMOVED;
            }
        }
    }
    let back = from_grid(&grid, &ImportSettings { support_radius: 0.05, ..IMPORT }).unwrap().asset;
    assert_eq!((back.band_cells, back.solid_cells), (asset.band_cells, asset.solid_cells));
}

#[test]
fn another_radius_or_factor_is_told() {
    let mut grid = discregrid(&computed(&SPHERE, 16, R), true, &Watch::default()).unwrap();
    grid.fields[1].nodes.iter_mut().filter(|v| **v != UNSAMPLED).for_each(|v| *v *= 0.8);
    let warnings = from_grid(&grid, &IMPORT).unwrap().warnings;
    assert!(warnings[0].contains("the volume is 0.8 of the full ball"), "{warnings:?}");
}

/// Damaged maps of each of two; `fuzz` has the same with coverage.
const DAMAGED: usize = if cfg!(feature = "long") { 300_000 } else { 1_500 };

/// Numbers that break programs, as a file would have them.
fn nasty(random: &mut Random) -> [u8; 8] {
    let wholes = [0, 1, 2, 7, u64::from(u32::MAX), 1 << 32, 1 << 40, i64::MAX as u64, u64::MAX, u64::MAX - 1];
    let reals = [-0.0, 1e-300, 1e300, -1e300, f64::MAX, f64::INFINITY, f64::NAN, f64::MIN_POSITIVE];
    match random.below(2) {
        0 => wholes[random.below(wholes.len())].to_le_bytes(),
        _ => reals[random.below(reals.len())].to_le_bytes(),
    }
}

fn damaged(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut damaged = bytes.to_vec();
    // A third in the header, where little changes much.
    let reach = if random.below(3) == 0 { 140 } else { bytes.len() };
    for _ in 0..1 + random.below(3) {
        if random.below(2) == 0 {
            damaged[random.below(reach)] ^= 1 << random.below(8);
        } else {
            let (word, at) = (nasty(random), random.below(reach.min(bytes.len() - 8) / 4) * 4);
            damaged[at..at + 8].copy_from_slice(&word);
        }
    }
    if random.below(5) == 0 {
        damaged.truncate(random.below(bytes.len()));
    }
    damaged
}

#[test]
fn damaged_maps_are_refused_or_sound() {
    let small = to_bytes(&discregrid(&computed(&SPHERE, 2, R), true, &Watch::default()).unwrap());
    let torus = std::fs::read(peer("torus_map.cdm")).unwrap();
    for (seed, bytes) in [(11, small), (12, torus)] {
        let mut random = Random::from_state(seed);
        let (mut sound, mut refused) = (0, 0);
        for round in 0..DAMAGED {
            let exterior = (round % 2 == 0).then_some(Exterior::Solid);
            let settings = ImportSettings { exterior, ..IMPORT };
            let Some(import) = from_bytes(&damaged(&bytes, &mut random))
                .ok()
                .and_then(|grid| from_grid(&grid, &settings).ok())
            else {
                refused += 1;
                continue;
            };
            sound += 1;
            // What an asset can't hold is refused there; nothing panics.
            if let Ok(map) = VolumeMap::from_asset(&import.asset) {
                let (low, high) = (map.grid().origin, map.grid().max_corner());
                for _ in 0..8 {
                    std::hint::black_box(map.sample(random.point(low, high)));
                }
            }
        }
        assert!(sound > DAMAGED / 30 && refused > DAMAGED / 6, "{sound} {refused}");
    }
}

/// The product of cubics through the values at thirds of a line, at 0 to 3.
fn lagrange(f: f64) -> [f64; 4] {
    std::array::from_fn(|i| {
        let others = (0..4).filter(|&j| j != i).map(|j| j as f64);
        others.map(|j| (f - j) / (i as f64 - j)).product()
    })
}

#[test]
fn cubic_hexahedra_are_the_map() {
    let asset = computed(&TORUS, 12, R);
    let map = VolumeMap::from_asset(&asset).unwrap();
    let grid = hexahedra(&asset, &Watch::default()).unwrap();
    let mut random = Random::from_state(3);
    for _ in 0..2000 {
        let cell = &grid.cells[random.below(grid.cells.len())];
        let (low, high) =
            (DVec3::from(grid.points[cell[0] as usize]), DVec3::from(grid.points[cell[63] as usize]));
        let f = DVec3::new(random.unit(), random.unit(), random.unit());
        let axes = (3.0 * f).to_array().map(lagrange);
        let weight = |p: usize| axes[0][p % 4] * axes[1][p / 4 % 4] * axes[2][p / 16];
        let mean = |data: &[f64]| (0..64).map(|p| weight(p) * data[cell[p] as usize]).sum::<f64>();
        let values = map.values(low + f * (high - low));
        assert!((mean(&grid.point_data[0].1) - values.distance).abs() < 1e-14);
        assert!((mean(&grid.point_data[1].1) - values.volume).abs() < 1e-16);
    }
}

#[test]
fn images_hold_the_values_everywhere() {
    let asset = computed(&SPHERE, 24, 0.05);
    let map = VolumeMap::from_asset(&asset).unwrap();
    let steps = LatticeChoice::Resolution([31, 20, 27]);
    let image =
        image(&asset, &ExportSettings { lattice: Some(steps), ..Default::default() }, &Watch::default())
            .unwrap();
    assert_eq!(image.points, [32, 21, 28]);
    let [(_, Numbers::F64(distance)), (_, Numbers::F64(volume)), (_, Numbers::U8(region))] =
        &image.arrays[..]
    else {
        panic!("f64 was computed")
    };
    let mut regions = [0; 3];
    for index in 0..32 * 21 * 28 {
        let at = DVec3::new((index % 32) as f64, (index / 32 % 21) as f64, (index / (32 * 21)) as f64);
        let exact = SPHERE.phi;
        let exact = exact(DVec3::from(image.origin) + at * DVec3::from(image.spacing)).clamp(-0.1, 0.1);
        assert!((distance[index] - exact).abs() < 1e-4, "{} {exact}", distance[index]);
        regions[region[index] as usize] += 1;
        match region[index] {
            0 => assert_eq!((distance[index], volume[index]), (0.1, 0.0)),
            2 => assert_eq!((distance[index], volume[index]), (-0.1, map.quadrature().ball_volume)),
            // Interpolated, so a little beyond its bounds.
            _ => assert!((-0.1..1.1).contains(&(volume[index] / map.quadrature().ball_volume))),
        }
    }
    assert!(regions.iter().all(|n| *n > 100), "{regions:?}");
    let one = ExportSettings { field: Some(ExportField::Volume), ..Default::default() };
    let names = volmap_report::export::image::image(&asset, &one, &Watch::default())
        .unwrap()
        .arrays
        .into_iter()
        .map(|(name, _)| name);
    assert_eq!(names.collect::<Vec<_>>(), ["volume", "region"]);
}

/// Edges that don't run once each way, and the volume.
fn surface(
    asset: &Asset,
    iso: f64,
    lattice: Option<LatticeChoice>,
) -> Result<IsoSurface, volmap_bake::Error> {
    iso_surface(&VolumeMap::from_asset(asset)?, iso, lattice, &Watch::default())
}

fn open_edges_and_volume(surface: &IsoSurface) -> (usize, f64) {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let mut volume = 0.0;
    for t in &surface.triangles {
        let [a, b, c] = t.map(|v| DVec3::from(surface.vertices[v as usize]));
        volume += a.dot(b.cross(c)) / 6.0;
        for n in 0..3 {
            *edges.entry((t[n], t[(n + 1) % 3])).or_default() += 1;
        }
    }
    (edges.iter().filter(|((a, b), n)| **n != 1 || edges.get(&(*b, *a)) != Some(&1)).count(), volume)
}

#[test]
fn surfaces_close_and_lie_on_the_map() {
    let ball = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    let ring = 2.0 * std::f64::consts::PI.powi(2) * 0.5 * 0.25 * 0.25;
    for (solid, iso, exact) in [
        (SPHERE, 0.0, ball(0.5)),
        (SPHERE, 0.07, ball(0.57)),
        (SPHERE, -0.15, ball(0.35)),
        (TORUS, 0.0, ring),
    ] {
        let asset = computed(&solid, 20, R);
        let found = surface(&asset, iso, None).unwrap();
        let (open, volume) = open_edges_and_volume(&found);
        assert_eq!((open, found.is_cut), (0, false), "{} {iso}", solid.name);
        assert!((volume / exact - 1.0).abs() < 4e-3, "{} {iso}: {volume} {exact}", solid.name);
        let map = VolumeMap::from_asset(&asset).unwrap();
        for vertex in &found.vertices {
            let distance = map.values(DVec3::from(*vertex)).distance;
            assert!((distance - iso).abs() < 1e-7, "{} {iso}: {distance}", solid.name);
        }
    }
}

#[test]
fn surfaces_in_the_lattice_close_too() {
    // The box's faces lie in the cells' faces; the lattice of 7 steps lies across the cells.
    for (cell_size, lattice) in
        [(0.05, None), (0.05, Some(LatticeChoice::Resolution([40, 50, 60]))), (0.07, None)]
    {
        for invert in [false, true] {
            let map = MapSettings { grid: GridChoice::CellSize(cell_size), invert, ..settings() };
            let asset = baked("UnitBox.obj", map);
            let found = surface(&asset, 0.0, lattice).unwrap();
            let (open, volume) = open_edges_and_volume(&found);
            assert_eq!((open, found.is_cut), (0, false), "{cell_size} {lattice:?}");
            let sign = if invert { -1.0 } else { 1.0 };
            assert!((sign * volume - 0.5 * 0.5 * 0.75).abs() < 2e-3, "{cell_size} {lattice:?}: {volume}");
        }
    }
    let cut = Some([[-0.2, -0.5, -0.9], [0.9, 0.3, 0.9]]);
    let asset = baked("torus.obj", MapSettings { domain: cut, ..settings() });
    assert!(surface(&asset, 0.0, None).unwrap().is_cut);
}
