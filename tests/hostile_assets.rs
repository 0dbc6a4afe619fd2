//! Damaged assets: each is refused with a clear error or opens unchanged, in bounded time and memory, whether or
//! not the HDF5 checksums have been made right again. A binary of its own, because memory is counted for the
//! whole process.

#[path = "../runtime/tests/analytic/mod.rs"]
mod analytic;
#[path = "hostile_assets/checksums.rs"]
mod checksums;
#[path = "hostile_assets/mutate.rs"]
mod mutate;

use checksums::{Checksums, signatures};
use mutate::{NAMES, Target};
use peak_alloc::PeakAlloc;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};
use volmap_bake::area_map::disc::DiscRule;
use volmap_bake::area_map::{self, AreaDensity, AreaSettings};
use volmap_bake::density_map::DensitySettings;
use volmap_bake::plan::{GridChoice, MapSettings, Precision};
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::Watch;
use volmap_formats::asset::{
    self, Array, Asset, AssetError, CellRun, Compression, DensityField, LevelCells, Rounded,
};
use volmap_runtime::{DVec2, DVec3, Error, MapDensity, Sample, VolumeMap};
use volmap_tests::{Random, SPHERE, asset_of, compute};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Tests that count memory run one at a time.
static ALONE: Mutex<()> = Mutex::new(());

const MIB: usize = 1 << 20;
/// Of which a dataset that claims 2^24 numbers, in a file that may, takes 128: as bytes and as numbers.
const MAX_MEMORY: usize = 144 * MIB;
const MAX_TIME: Duration = Duration::from_secs(5);
/// Mutations in all; all assets but the large one share them, the large one gets a tenth of them on top.
const CASES: usize = if cfg!(feature = "long") { 300_000 } else { 12_000 };

/// An undamaged file and what it says.
struct Original {
    name: &'static str,
    file: Vec<u8>,
    checksums: Checksums,
    asset: Asset,
    samples: Vec<Answer>,
}

impl Original {
    fn metadata(&self) -> impl Iterator<Item = usize> {
        self.checksums.metadata().flatten()
    }
}

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// A sphere at N^3 cells with as many attributes as real assets have: enough for HDF5's dense storage of them.
fn sphere(resolution: u32, settings: &MapSettings) -> Asset {
    let settings =
        MapSettings { support_radius: Some(0.05), rule: Rule::GaussLegendre(4), ..settings.clone() };
    let (plan, maps) = compute(&SPHERE, resolution, &settings);
    let mut asset = asset_of(&plan, &settings, maps);
    asset.bake = (0..12).map(|k| (format!("option_{k}"), (f64::from(k) * 0.1).into())).collect();
    asset.bake.insert("command".into(), "bake sphere.obj --rule gl4".into());
    asset.source.insert("file".into(), "sphere.obj".into());
    asset.source.insert("triangles".into(), 1280u64.into());
    asset.source.insert("box_min".into(), [-0.5; 3].into());
    asset.diagnosis.insert("closed".into(), true.into());
    asset
}

fn single(array: &Array) -> Array {
    match array {
        Array::F64(v) => Array::F32(v.iter().map(|&x| x as f32).collect()),
        other => other.clone(),
    }
}

fn in_single_precision(mut asset: Asset) -> Asset {
    asset.signed_distance = single(&asset.signed_distance);
    asset.volume = single(&asset.volume);
    if let Some(density) = &mut asset.density {
        density.values = single(&density.values);
    }
    asset
}

fn in_16_bits(mut asset: Asset) -> Asset {
    let rounded = |array: &Array, unit: f64| match array {
        Array::F64(v) => Array::Rounded(Rounded::new(v, unit, 1e-3).unwrap()),
        other => panic!("{other:?}"),
    };
    asset.signed_distance = rounded(&asset.signed_distance, asset.support_radius);
    asset.volume = rounded(&asset.volume, asset.quadrature.ball_volume);
    asset
}

fn file_of(asset: &Asset, compression: Compression) -> Result<Vec<u8>, AssetError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("asset.h5");
    asset::write(&path, asset, compression)?;
    Ok(std::fs::read(&path).unwrap())
}

fn original(name: &'static str, asset: Asset, compression: Compression) -> Original {
    let file = file_of(&asset, compression).unwrap();
    let samples = samples(&VolumeMap::from_bytes(file.clone()).unwrap());
    assert_eq!(asset::from_bytes(file.clone()).unwrap(), asset, "{name}");
    Original { name, checksums: Checksums::find(&file), file, asset, samples }
}

/// A disc in two dimensions, with a density.
fn disc() -> Asset {
    let density = AreaDensity { rule: DiscRule::Disc(6), ..AreaDensity::default() };
    let settings = AreaSettings {
        support_radius: Some(0.1),
        grid: GridChoice::CellSize(0.1),
        rule: DiscRule::Disc(6),
        density: Some(density),
        precision: Precision::F64,
        ..AreaSettings::default()
    };
    area_map::bake(
        [DVec2::splat(-0.3), DVec2::splat(0.3)],
        &|x: DVec2| x.length() - 0.3,
        &settings,
        &Watch::default(),
    )
    .unwrap()
}

fn originals() -> [Original; 8] {
    let outside = MapSettings::default();
    let container = MapSettings { invert: true, ..MapSettings::default() };
    let dense = MapSettings { density: Some(DensitySettings::default()), ..MapSettings::default() };
    [
        original("disc", in_single_precision(disc()), Compression::Zstd(3)),
        original("zstd f32", in_single_precision(sphere(8, &outside)), Compression::Zstd(9)),
        original("gzip f64", sphere(6, &outside), Compression::Gzip(6)),
        original("inverted", in_single_precision(sphere(7, &container)), Compression::Zstd(1)),
        original("zstd i16", in_16_bits(sphere(8, &outside)), Compression::Zstd(5)),
        // Two chunks a field, so with chunk indexes.
        original("large", in_single_precision(sphere(32, &outside)), Compression::Zstd(3)),
        original("density", in_single_precision(sphere(6, &dense)), Compression::Zstd(3)),
        original("adaptive", analytic::in_steps(&analytic::adaptive_ball(3)), Compression::Zstd(9)),
    ]
}

/// All that a map says of a point.
type Answer = (Sample, Option<MapDensity>);

/// 64 fixed points in and around the domain.
fn samples(map: &VolumeMap) -> Vec<Answer> {
    let mut random = Random::from_state(64);
    let (low, high) = (map.grid().origin, map.grid().max_corner());
    // In two dimensions the cells are endless along z.
    let high = high.min(DVec3::splat(1e3));
    let margin = DVec3::splat(0.1);
    let points = (0..64).map(|_| random.point(low - margin, high + margin));
    points.map(|x| (map.sample(x), map.density(x))).collect()
}

/// The kind of an error; its message must tell something.
fn kind(error: &Error) -> &'static str {
    let message = error.to_string();
    // Nothing from the file that a terminal would obey.
    assert!(message.len() > 20 && message.len() < 1000 && !message.contains(char::is_control), "{message:?}");
    match error {
        Error::Asset(AssetError::InFile { error, .. }) if matches!(**error, AssetError::Invalid { .. }) => {
            "refused by the writer"
        }
        Error::Inconsistent { .. } => "content: inconsistent",
        Error::Asset(AssetError::Container(m)) if m.contains("checksum") => "HDF5: checksum",
        Error::Asset(AssetError::Container(m)) if m.contains("limit") => "HDF5: limit",
        Error::Asset(AssetError::Container(m)) if m.contains("zstd") || m.contains("compression") => {
            "HDF5: decompression"
        }
        Error::Asset(AssetError::Container(_) | AssetError::NotHdf5) => "HDF5: structure",
        Error::Asset(AssetError::NotAnAsset) => "not an asset",
        Error::Asset(AssetError::Version { .. }) => "newer version",
        Error::Asset(AssetError::Missing(_)) => "missing object",
        Error::Asset(AssetError::Invalid { .. }) => "invalid value",
        Error::Asset(AssetError::Checksum(path)) if path == "/" => "BLAKE3 of attributes",
        Error::Asset(AssetError::Checksum(_)) => "BLAKE3 of a dataset",
        other => panic!("bytes in memory don't give {other:?}"),
    }
}

/// How many files ended how, and the most memory that one took.
#[derive(Default)]
struct Tally {
    kinds: BTreeMap<&'static str, usize>,
    failures: Vec<String>,
    memory: usize,
    time: Duration,
}

impl Tally {
    fn open(&mut self, original: &Original, bytes: Vec<u8>, case: impl Fn() -> String) {
        let before = MEMORY.current_usage();
        MEMORY.reset_peak_usage();
        let start = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| outcome(original, bytes)));
        self.time = self.time.max(start.elapsed());
        let memory = MEMORY.peak_usage().saturating_sub(before);
        self.memory = self.memory.max(memory);
        let kind = outcome.unwrap_or("PANIC OR BAD MESSAGE");
        *self.kinds.entry(kind).or_default() += 1;
        let bad = kind.chars().all(|c| c.is_uppercase() || c == ' ');
        if bad || memory > MAX_MEMORY || start.elapsed() > MAX_TIME {
            let spent = format!("{} bytes, {:?}", memory, start.elapsed());
            self.failures.push(format!("{}, {}: {kind}, {spent}", original.name, case()));
        }
    }

    fn count(&self, kind: &str) -> usize {
        self.kinds.get(kind).copied().unwrap_or(0)
    }

    fn report(&self, what: &str) {
        let total: usize = self.kinds.values().sum();
        println!("{what}: {total} files, at most {} KiB and {:?} each", self.memory / 1024, self.time);
        self.kinds.iter().for_each(|(kind, count)| println!("  {count:7}  {kind}"));
        let shown: Vec<&str> = self.failures.iter().take(20).map(String::as_str).collect();
        assert!(shown.is_empty(), "{} bad cases:\n{}", self.failures.len(), shown.join("\n"));
    }
}

fn outcome(original: &Original, bytes: Vec<u8>) -> &'static str {
    match VolumeMap::from_bytes(bytes.clone()) {
        Err(error) => kind(&error),
        Ok(map) => match asset::from_bytes(bytes) {
            Ok(asset) if asset == original.asset && samples(&map) == original.samples => "unchanged",
            _ => "OTHER NUMBERS",
        },
    }
}

/// Every case has a seed of its own, so that one can be run alone.
fn seed(case: usize) -> Random {
    let mut random = Random::from_state(0x5EED_0000 + case as u64);
    (0..4).for_each(|_| _ = random.bits());
    random
}

#[test]
fn checksums_made_anew_are_the_old_ones() {
    let _alone = alone();
    for original in originals() {
        let [metadata, chunks] = original.checksums.counts();
        assert_eq!(metadata, signatures(&original.file).len(), "{}", original.name);
        let expected = match original.name {
            "large" => 6,
            "density" | "adaptive" => 5,
            _ => 4,
        };
        assert_eq!(chunks, expected, "{}", original.name);
        let mut renewed = original.file.clone();
        for part in original.checksums.metadata().chain(original.checksums.chunks()) {
            renewed[part.end..part.end + 4].fill(0xA5);
        }
        assert_ne!(renewed, original.file);
        original.checksums.renew(&mut renewed);
        assert!(renewed == original.file, "{}: other bytes", original.name);
    }
}

#[test]
fn damaged_assets_are_refused_or_unchanged() {
    let _alone = alone();
    let (mut plain, mut renewed) = (Tally::default(), Tally::default());
    for original in originals() {
        let target = Target::new(&original.file, &original.checksums);
        let cases = if original.name == "large" { CASES / 10 } else { CASES / 5 };
        for case in 0..cases {
            let (mut bytes, what) = target.mutate(&mut seed(case));
            let described = || format!("seed {case}, {}", NAMES[what]);
            if case % 2 == 0 {
                plain.open(&original, bytes, described);
            } else {
                original.checksums.renew(&mut bytes);
                renewed.open(&original, bytes, || described() + ", checksums renewed");
            }
        }
    }
    plain.report("mutated");
    renewed.report("mutated, HDF5 checksums renewed");
    // The mutations reach every layer, and our own checksums hold where HDF5's are made right.
    assert!(plain.count("HDF5: checksum") > plain.kinds.values().sum::<usize>() / 4);
    for kind in [
        "HDF5: structure",
        "HDF5: decompression",
        "missing object",
        "invalid value",
        "BLAKE3 of attributes",
        "BLAKE3 of a dataset",
        "unchanged",
    ] {
        assert!(renewed.count(kind) >= 10, "{kind}: {}", renewed.count(kind));
    }
}

#[test]
fn every_byte_of_the_metadata_counts_or_means_nothing() {
    let _alone = alone();
    let mut tally = Tally::default();
    let [_, _, _, single, rounded, _, dense, adaptive] = originals();
    let places = |original| Original::metadata(original).map(move |at| (original, at));
    for (original, at) in
        places(&single).chain(places(&rounded)).chain(places(&dense)).chain(places(&adaptive))
    {
        for change in [0x01, 0xFF] {
            let mut bytes = original.file.clone();
            bytes[at] ^= change;
            original.checksums.renew(&mut bytes);
            tally.open(original, bytes, || format!("byte {at} ^ {change:#x}, checksums renewed"));
        }
    }
    tally.report("metadata byte by byte, HDF5 checksums renewed");
}

#[test]
fn every_length_is_refused_or_unchanged() {
    let _alone = alone();
    let mut tally = Tally::default();
    let [_, _, original, ..] = originals();
    let lengths = (0..1024).chain((1024..original.file.len()).step_by(7));
    for length in lengths {
        let bytes = original.file[..length].to_vec();
        tally.open(&original, bytes, || format!("cut to {length}"));
    }
    tally.report("cut");
    assert_eq!(tally.count("unchanged"), 0);
}

#[test]
fn a_changed_attribute_gets_past_hdf5_and_not_past_blake3() {
    let [_, original, ..] = originals();
    let radius = 0.05f64.to_le_bytes();
    let at = original.file.windows(8).position(|window| window == radius).unwrap();
    let mut bytes = original.file.clone();
    bytes[at] ^= 1;
    let error = |bytes: &[u8]| kind(&VolumeMap::from_bytes(bytes.to_vec()).unwrap_err());
    assert_eq!(error(&bytes), "HDF5: checksum");
    original.checksums.renew(&mut bytes);
    assert_eq!(error(&bytes), "BLAKE3 of attributes");
}

type Change = (&'static str, fn(&mut Asset));

/// The array of a field of single precision.
fn numbers(array: &mut Array) -> &mut Vec<f32> {
    match array {
        Array::F32(v) => v,
        other => panic!("{other:?}"),
    }
}

fn rounded(array: &mut Array) -> &mut Rounded {
    match array {
        Array::Rounded(v) => v,
        other => panic!("{other:?}"),
    }
}

/// The same for fields of 16 bits.
const INCONSISTENT_IN_16_BITS: [Change; 9] = [
    ("step 0", |a| rounded(&mut a.volume).step = 0.0),
    ("step negative", |a| rounded(&mut a.volume).step = -1e-5),
    ("step NaN", |a| rounded(&mut a.signed_distance).step = f64::NAN),
    ("step whose products overflow", |a| rounded(&mut a.signed_distance).step = 1e305),
    ("bound NaN", |a| rounded(&mut a.signed_distance).max_error = f64::NAN),
    ("bound negative", |a| rounded(&mut a.volume).max_error = -1e-9),
    ("one distance less", |a| _ = rounded(&mut a.signed_distance).multiples.pop()),
    ("one volume more", |a| rounded(&mut a.volume).multiples.push(0)),
    ("mixed precision", |a| a.volume = Array::F32(vec![0.0; a.volume.len()])),
];

fn density(asset: &mut Asset) -> &mut DensityField {
    asset.density.as_mut().expect("a density")
}

/// The same for a density.
const INCONSISTENT_DENSITY: [Change; 7] = [
    ("one density less", |a| _ = numbers(&mut density(a).values).pop()),
    ("one density more", |a| numbers(&mut density(a).values).push(0.0)),
    ("no densities", |a| density(a).values = Array::F32(Vec::new())),
    ("density NaN", |a| numbers(&mut density(a).values)[3] = f32::NAN),
    ("mixed precision", |a| density(a).values = Array::F64(vec![0.0; a.volume.len()])),
    ("integers", |a| density(a).values = Array::U32(vec![0; a.volume.len()])),
    ("step 0", |a| {
        let multiples = vec![0; a.volume.len()];
        density(a).values = Array::Rounded(Rounded { multiples, step: 0.0, max_error: 1.0 });
    }),
];

/// Beside its values.
const INVALID_DENSITY: [Change; 4] = [
    ("length 0", |a| density(a).extension_length = 0.0),
    ("length NaN", |a| density(a).extension_length = f64::NAN),
    ("integral negative", |a| density(a).kernel_integral = -1.0),
    ("integral infinite", |a| density(a).kernel_integral = f64::INFINITY),
];

#[test]
fn invalid_numbers_of_a_density_are_refused() {
    let [.., dense, _] = originals();
    for (name, change) in INVALID_DENSITY {
        let mut asset = dense.asset.clone();
        change(&mut asset);
        let error = file_of(&asset, Compression::Zstd(1)).map(|_| ()).map_err(Error::from).expect_err(name);
        assert_eq!(kind(&error), "refused by the writer", "{name}: {error}");
    }
}

/// The same for cells of several levels.
const INCONSISTENT_LEVELS: [Change; 14] = [
    ("level 16", |a| a.finer.resize(16, a.finer[1].clone())),
    ("levels swapped", |a| a.finer.swap(0, 1)),
    ("level missing", |a| _ = a.finer.remove(0)),
    ("level twice", |a| a.finer.push(a.finer[1].clone())),
    ("finest level left out", |a| _ = a.finer.pop()),
    ("cell within a cell", |a| a.band_cells = vec![CellRun { i: 0, j: 0, k: 1, len: 4 }]),
    ("fine run past the row", |a| a.finer[1].band[0].len = 17),
    ("fine run whose end overflows", |a| a.finer[1].band[1].len = u32::MAX),
    ("fine run missing", |a| _ = a.finer[1].band.pop()),
    ("a weight less", |a| _ = a.plane_weight.as_mut().unwrap().pop()),
    ("no weights", |a| a.plane_weight = Some(vec![0])),
    ("weight 2", |a| a.plane_weight.as_mut().unwrap()[3] = 2),
    ("a million cells in a run", |a| {
        a.grid.resolution = [1 << 10, 6, 4];
        a.finer.resize(10, LevelCells::default());
        a.finer[9].band = (0..2_000).map(|j| CellRun { i: 0, j, k: 1 << 10, len: 1 << 19 }).collect();
    }),
    ("a million solid cells in a run", |a| {
        a.grid.resolution = [1 << 10, 6, 4];
        a.finer.resize(10, LevelCells::default());
        a.finer[9].solid = (0..2_000).map(|j| CellRun { i: 0, j, k: 1 << 10, len: 1 << 19 }).collect();
    }),
];

/// Lists that would name billions of cells are refused before any is made.
#[test]
fn levels_that_claim_more_than_they_hold_take_little_memory() {
    let _alone = alone();
    let [.., adaptive] = originals();
    for (name, change) in INCONSISTENT_LEVELS {
        let mut asset = adaptive.asset.clone();
        change(&mut asset);
        let before = MEMORY.current_usage();
        MEMORY.reset_peak_usage();
        assert!(VolumeMap::from_asset(&asset).is_err(), "{name}");
        let memory = (MEMORY.peak_usage() - before) / MIB;
        assert!(memory < 16, "{name}: {memory} MiB");
    }
}

/// What an attacker can write who computes every checksum.
const INCONSISTENT: [Change; 35] = [
    ("run past the row", |a| a.band_cells[0].len = a.grid.resolution[0] + 1),
    ("run whose end overflows", |a| a.band_cells[0].len = u32::MAX),
    ("run that starts at 2^32 - 1", |a| a.band_cells[0].i = u32::MAX),
    ("run of no cells", |a| a.band_cells[0].len = 0),
    ("run behind the last row", |a| a.band_cells.last_mut().unwrap().j = a.grid.resolution[1]),
    ("run behind the last layer", |a| a.band_cells.last_mut().unwrap().k = u32::MAX),
    ("runs swapped", |a| a.band_cells.swap(0, 1)),
    ("run twice", |a| a.band_cells.insert(1, a.band_cells[0])),
    ("run missing", |a| _ = a.band_cells.pop()),
    ("no runs", |a| a.band_cells.clear()),
    ("run longer", |a| a.band_cells.push(CellRun { i: 0, len: a.grid.resolution[0], ..last(a) })),
    ("solid over band", |a| a.solid_cells = a.band_cells.clone()),
    ("solid past the row", |a| a.solid_cells[0].i = a.grid.resolution[0]),
    ("solid of no cells", |a| a.solid_cells[0].len = 0),
    ("solid out of order", |a| a.solid_cells.reverse()),
    ("resolution 0", |a| a.grid.resolution = [8, 0, 8]),
    ("no cells at all", |a| {
        a.grid.resolution = [0; 3];
        a.band_cells.clear();
        a.solid_cells.clear();
        a.signed_distance = Array::F32(Vec::new());
        a.volume = Array::F32(Vec::new());
    }),
    ("resolution 2^32 - 1", |a| a.grid.resolution = [u32::MAX; 3]),
    ("resolution 2^32 - 1 along x", |a| a.grid.resolution[0] = u32::MAX),
    ("2^25 rows", |a| a.grid.resolution = [8, 1 << 13, 1 << 12]),
    ("one distance less", |a| _ = numbers(&mut a.signed_distance).pop()),
    ("one volume more", |a| numbers(&mut a.volume).push(0.0)),
    ("no fields", |a| a.volume = Array::F32(Vec::new())),
    ("mixed precision", |a| a.volume = Array::F64(vec![0.0; a.volume.len()])),
    ("integers", |a| a.volume = Array::U32(vec![0; a.volume.len()])),
    ("distance NaN", |a| numbers(&mut a.signed_distance)[7] = f32::NAN),
    ("volume infinite", |a| numbers(&mut a.volume)[0] = f32::INFINITY),
    ("origin NaN", |a| a.grid.origin[1] = f64::NAN),
    ("corner infinite", |a| a.grid.origin[1] = f64::NEG_INFINITY),
    ("domain infinite", |a| a.grid.cell_size[0] = f64::MAX),
    ("cell size 0", |a| a.grid.cell_size[2] = 0.0),
    ("cell size negative", |a| a.grid.cell_size[2] = -0.1),
    ("radius 0", |a| a.support_radius = 0.0),
    ("radius negative", |a| a.support_radius = -0.05),
    ("radius infinite", |a| a.support_radius = f64::INFINITY),
];

fn last(asset: &Asset) -> CellRun {
    *asset.band_cells.last().unwrap()
}

#[test]
fn content_that_contradicts_itself_is_refused() {
    let [_, single, _, _, rounded, _, dense, adaptive] = originals();
    let all = INCONSISTENT.iter().map(|change| (&single, change));
    let all = all.chain(INCONSISTENT_IN_16_BITS.iter().map(|change| (&rounded, change)));
    let all = all.chain(INCONSISTENT_DENSITY.iter().map(|change| (&dense, change)));
    for (original, (name, change)) in all.chain(INCONSISTENT_LEVELS.iter().map(|change| (&adaptive, change)))
    {
        let mut asset = original.asset.clone();
        change(&mut asset);
        let error = VolumeMap::from_asset(&asset).map(|map| samples(&map)).expect_err(name);
        let counts =
            ["one distance less", "one volume more", "no fields", "run missing", "run longer", "no runs"];
        let counts = kind(&error) == "content: inconsistent"
            && (counts.contains(name) || INCONSISTENT_LEVELS.iter().any(|(of_levels, _)| of_levels == name));
        assert!(counts || kind(&error) == "invalid value", "{name}: {error}");
        // The writer refuses what the reader would; the counts of nodes the loader must.
        let file = file_of(&asset, Compression::Zstd(1)).map_err(Error::from);
        let error = file.and_then(VolumeMap::from_bytes).map(|map| samples(&map)).expect_err(name);
        assert!(counts || kind(&error) == "refused by the writer", "{name}: {error}");
    }
}

#[test]
fn the_largest_grid_takes_little_memory() {
    let _alone = alone();
    let [_, original, ..] = originals();
    let mut asset = original.asset.clone();
    // Cells keep their place in the lattice; all rows beyond are free.
    asset.grid.resolution = [1 << 20, 1 << 12, 1 << 12];
    let file = file_of(&asset, Compression::Zstd(1)).unwrap();
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let map = VolumeMap::from_bytes(file).unwrap();
    let point = map.grid().origin + map.grid().cell_size * DVec3::new(1.5, 3.5, 3.5);
    let same = VolumeMap::from_asset(&original.asset).unwrap().sample(point);
    assert_eq!(map.sample(point), same);
    let memory = (MEMORY.peak_usage() - before) / MIB;
    println!("2^24 rows: {memory} MiB");
    assert!(memory < 600, "{memory} MiB");
}
