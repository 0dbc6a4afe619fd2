//! The map's content without the file: what is left to check when an attacker computes every checksum.
#![no_main]

use libfuzzer_sys::fuzz_target;
use volmap_formats::asset::{
    Array, Asset, Attributes, CellRun, Dimension, Exterior, GridSpec, LevelCells, QuadratureSpec,
};
use volmap_runtime::layout::Levels;
use volmap_runtime::{DVec3, Grid, VolumeMap};

/// Numbers from the fuzzer's bytes, zeros at the end.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    fn integer(&mut self) -> u32 {
        // Mostly small.
        match self.byte() {
            255 => u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()]),
            small => u32::from(small) % 12,
        }
    }

    fn real(&mut self) -> f64 {
        match self.byte() {
            255 => f64::from_bits(u64::from_le_bytes([0; 8].map(|_: u8| self.byte()))),
            small => f64::from(small) / 16.0,
        }
    }

    fn reals(&mut self) -> [f64; 3] {
        [self.real(), self.real(), self.real()]
    }

    fn runs(&mut self) -> Vec<CellRun> {
        let count = self.byte() % 16;
        let run =
            |_| CellRun { i: self.integer(), j: self.integer(), k: self.integer(), len: self.integer() };
        (0..count).map(run).collect()
    }

    fn array(&mut self, count: usize) -> Array {
        match self.byte() % 8 {
            0 => Array::U32(vec![0; count]),
            1 => Array::F32(vec![self.real() as f32; count + 1]),
            2 => Array::F64(vec![self.real(); count]),
            _ => Array::F32(vec![self.real() as f32; count]),
        }
    }
}

/// Makes fields and weights of an adaptive map that fit its cells.
fn fit_levels(asset: &mut Asset, numbers: &mut Numbers) {
    // Told as wrong: all lists are in order otherwise.
    if asset.check().is_err() {
        return;
    }
    let first = LevelCells { band: asset.band_cells.clone(), solid: asset.solid_cells.clone() };
    let cells: Vec<LevelCells> = std::iter::once(first).chain(asset.finer.iter().cloned()).collect();
    let runs = || cells.iter().flat_map(|level| level.band.iter().chain(&level.solid));
    if runs().map(|run| u64::from(run.len)).sum::<u64>() > 1 << 12 {
        return;
    }
    let Ok(levels) = Levels::new(Grid::from(asset.grid), &cells) else { return };
    asset.signed_distance = numbers.array(levels.free_count());
    asset.volume = numbers.array(levels.free_count());
    let weights = levels.free_corner_count() + usize::from(numbers.byte() == 1);
    asset.plane_weight = (numbers.byte() % 2 == 0).then(|| vec![u32::from(numbers.byte() % 3); weights]);
}

/// A count that fits the runs, as the fuzzer would hardly guess it: read from the refusal.
fn expected_count(asset: &Asset) -> Option<usize> {
    let message = VolumeMap::from_asset(asset).err()?.to_string();
    let (_, rest) = message.split_once("values for ")?;
    let count = rest.split(' ').next()?.parse().ok()?;
    (count < 1 << 16).then_some(count)
}

fuzz_target!(|bytes: &[u8]| {
    let mut numbers = Numbers(bytes);
    let mut asset = Asset {
        dimension: if numbers.byte() % 2 == 0 { Dimension::Three } else { Dimension::Two },
        grid: GridSpec {
            origin: numbers.reals(),
            cell_size: numbers.reals(),
            resolution: [numbers.integer(), numbers.integer(), numbers.integer()],
        },
        support_radius: numbers.real(),
        exterior: if numbers.byte() % 2 == 0 { Exterior::Fluid } else { Exterior::Solid },
        quadrature: QuadratureSpec { name: "gl4".into(), degree: 4, points: 19, ball_volume: numbers.real() },
        band_cells: numbers.runs(),
        solid_cells: numbers.runs(),
        finer: (0..numbers.byte() % 4)
            .map(|_| LevelCells { band: numbers.runs(), solid: numbers.runs() })
            .collect(),
        signed_distance: Array::F32(Vec::new()),
        volume: Array::F32(Vec::new()),
        density: None,
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    };
    if !asset.finer.is_empty() {
        fit_levels(&mut asset, &mut numbers);
    } else if let Some(count) = expected_count(&asset) {
        asset.signed_distance = numbers.array(count);
        asset.volume = numbers.array(count);
    }
    if let Ok(map) = VolumeMap::from_asset(&asset) {
        let (low, high) = (map.grid().origin, map.grid().max_corner());
        for _ in 0..64 {
            let t = DVec3::from(numbers.reals());
            std::hint::black_box((map.sample(low + (high - low) * t), map.inside(t)));
        }
    }
});
