//! Damage to a file, from a seed.

use super::checksums::Checksums;
use std::ops::Range;
use volmap_tests::Random;

/// What a mutation did, for messages and counts.
pub const NAMES: [&str; 12] = [
    "bits flipped",
    "bytes changed",
    "range random",
    "range zero",
    "range 0xff",
    "ranges swapped",
    "range copied",
    "range inserted",
    "range removed",
    "cut",
    "garbage behind",
    "integer extreme",
];

/// Where damage goes: half of it anywhere, half into the metadata, which are a small part of the file.
pub struct Target<'a> {
    file: &'a [u8],
    metadata: Vec<Range<usize>>,
}

impl Target<'_> {
    /// The file and the metadata that its checksums cover.
    pub fn new<'a>(file: &'a [u8], checksums: &Checksums) -> Target<'a> {
        Target { file, metadata: checksums.metadata().collect() }
    }

    fn place(&self, random: &mut Random) -> usize {
        if random.below(2) == 0 {
            return random.below(self.file.len());
        }
        let part = &self.metadata[random.below(self.metadata.len())];
        part.start + random.below(part.len())
    }

    fn range(&self, random: &mut Random) -> Range<usize> {
        let start = self.place(random);
        let longest = [4, 16, 64, 512][random.below(4)];
        let length = 1 + random.below(longest);
        start..(start + length).min(self.file.len())
    }

    /// A damaged copy, and the place of what happened in [`NAMES`].
    pub fn mutate(&self, random: &mut Random) -> (Vec<u8>, usize) {
        let mut out = self.file.to_vec();
        let kind = random.below(NAMES.len());
        match kind {
            0 => (0..=random.below(4)).for_each(|_| out[self.place(random)] ^= 1 << random.below(8)),
            1 => (0..=random.below(4)).for_each(|_| out[self.place(random)] = random.bits() as u8),
            2 => out[self.range(random)].fill_with(|| random.bits() as u8),
            3 => out[self.range(random)].fill(0),
            4 => out[self.range(random)].fill(0xFF),
            5 => swap(&mut out, self.range(random), self.range(random)),
            6 => {
                let (from, to) = (self.range(random), self.place(random));
                let length = from.len().min(out.len() - to);
                out.copy_within(from.start..from.start + length, to);
            }
            7 => {
                let (part, at) = (self.file[self.range(random)].to_vec(), self.place(random));
                out.splice(at..at, part);
            }
            8 => drop(out.drain(self.range(random))),
            9 => cut(&mut out, random),
            10 => out.extend((0..1 + random.below(256)).map(|_| random.bits() as u8)),
            _ => extreme_integer(&mut out, self.place(random), random),
        }
        (out, kind)
    }
}

fn swap(out: &mut [u8], a: Range<usize>, b: Range<usize>) {
    let length = a.len().min(b.len());
    for n in 0..length {
        out.swap(a.start + n, b.start + n);
    }
}

/// Half of the time the superblock (version 3, 8-byte addresses: "end of file" at 28) agrees.
fn cut(out: &mut Vec<u8>, random: &mut Random) {
    out.truncate(random.below(out.len()));
    let length = out.len() as u64;
    if length >= 48 && random.below(2) == 0 {
        out[28..36].copy_from_slice(&length.to_le_bytes());
    }
}

fn extreme_integer(out: &mut [u8], at: usize, random: &mut Random) {
    let width = [1, 2, 4, 8][random.below(4)].min(out.len() - at);
    let mut stored = [0; 8];
    stored[..width].copy_from_slice(&out[at..at + width]);
    let old = u64::from_le_bytes(stored);
    let values = [
        0,
        1,
        u64::MAX,
        u64::MAX - 1,
        u64::MAX >> 1,
        0x8000_0000,
        0x7FFF_FFFF,
        old.wrapping_add(1),
        old.wrapping_sub(1),
        old.wrapping_mul(2),
        out.len() as u64,
        random.bits() >> random.below(64),
    ];
    let value = values[random.below(values.len())].to_le_bytes();
    out[at..at + width].copy_from_slice(&value[..width]);
}
