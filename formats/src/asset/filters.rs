//! The filters that a chunk passes on its way to disk and back: shuffle, compression, Fletcher-32.
//! HDF5 File Format Specification, version 3, "Data Storage - Filter Pipeline Message".
//!
//! Shuffle and Fletcher-32 are ours for reading, too: the plain loops of the HDF5 crate would take most of the time
//! of opening an asset. Here they are written so that the compiler makes vector code of them. zlib is called by itself:
//! that crate's way to it takes three times as long.

#[cfg(feature = "write")]
use rayon::prelude::*;
#[cfg(feature = "write")]
use std::cell::RefCell;

/// Groups the bytes of the elements by significance: all first bytes, then all second ones.
#[cfg(feature = "write")]
pub fn shuffle(bytes: &[u8], element_size: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    for byte in 0..element_size {
        out.extend(bytes.chunks_exact(element_size).map(|element| element[byte]));
    }
    out
}

/// Elements that are put together at a time, so that the steps between stay in the fastest memory.
const BLOCK: usize = 256;

/// Undoes [`shuffle`]; `None` if `bytes` isn't a whole number of elements of 2, 4 or 8 bytes.
pub fn unshuffle(bytes: &[u8], element_size: usize) -> Option<Vec<u8>> {
    if ![2, 4, 8].contains(&element_size) || !bytes.len().is_multiple_of(element_size) {
        return None;
    }
    let count = bytes.len() / element_size;
    let mut out = vec![0; bytes.len()];
    for (block, out) in out.chunks_mut(BLOCK * element_size).enumerate() {
        let (first, length) = (block * BLOCK, out.len() / element_size);
        let part = |byte: usize| &bytes[byte * count + first..][..length];
        match element_size {
            2 => interleave_1(part(0), part(1), out),
            4 => interleave_4([part(0), part(1), part(2), part(3)], out),
            _ => {
                let (mut low, mut high) = ([0; 4 * BLOCK], [0; 4 * BLOCK]);
                interleave_4([part(0), part(1), part(2), part(3)], &mut low[..4 * length]);
                interleave_4([part(4), part(5), part(6), part(7)], &mut high[..4 * length]);
                let pairs = low.as_chunks::<4>().0.iter().zip(high.as_chunks::<4>().0);
                for (out, (&a, &b)) in out.as_chunks_mut::<8>().0.iter_mut().zip(pairs) {
                    *out = (u64::from(u32::from_le_bytes(a)) | u64::from(u32::from_le_bytes(b)) << 32)
                        .to_le_bytes();
                }
            }
        }
    }
    Some(out)
}

fn interleave_1(low: &[u8], high: &[u8], out: &mut [u8]) {
    for (out, (&a, &b)) in out.as_chunks_mut::<2>().0.iter_mut().zip(low.iter().zip(high)) {
        *out = [a, b];
    }
}

fn interleave_4(parts: [&[u8]; 4], out: &mut [u8]) {
    let (mut low, mut high) = ([0; 2 * BLOCK], [0; 2 * BLOCK]);
    interleave_1(parts[0], parts[1], &mut low);
    interleave_1(parts[2], parts[3], &mut high);
    let pairs = low.as_chunks::<2>().0.iter().zip(high.as_chunks::<2>().0);
    for (out, (&a, &b)) in out.as_chunks_mut::<4>().0.iter_mut().zip(pairs) {
        *out = (u32::from(u16::from_le_bytes(a)) | u32::from(u16::from_le_bytes(b)) << 16).to_le_bytes();
    }
}

/// Zstandard, registered HDF5 filter 32015.
#[cfg(feature = "write")]
pub fn zstd(bytes: &[u8], level: i32) -> std::io::Result<Vec<u8>> {
    zstd::bulk::compress(bytes, level)
}

/// zlib (RFC 1950), HDF5 filter 1, level 1 to 9, of bytes that [`shuffle`] grouped. The low bytes of real numbers are
/// noise: groups that nothing can make smaller are stored as they are, which takes no time to write and to read.
#[cfg(feature = "write")]
pub fn deflate(bytes: &[u8], level: u32, element_size: usize) -> std::io::Result<Vec<u8>> {
    // A window of 32 KiB, "fast", and what makes the two bytes a multiple of 31.
    let mut out = vec![0x78, 0x5E];
    let packed = |group: &[u8]| {
        let mut packed = Vec::new();
        match is_noise(group) {
            true => store(group, &mut packed),
            false => compress(group, level, &mut packed)?,
        }
        Ok(packed)
    };
    let groups: Vec<&[u8]> = bytes.chunks((bytes.len() / element_size).max(1)).collect();
    let packed: std::io::Result<Vec<Vec<u8>>> = groups.into_par_iter().map(packed).collect();
    packed?.iter().for_each(|group| out.extend(group));
    // The last block, an empty one (RFC 1951, section 3.2.6), and the checksum.
    out.extend([3, 0]);
    out.extend(zlib_rs::adler32::adler32(1, bytes).to_be_bytes());
    Ok(out)
}

/// Whether bytes are as good as equally frequent, and follow each other without runs: a tenth more of equal pairs than
/// then is less than 1 % to gain.
#[cfg(feature = "write")]
fn is_noise(bytes: &[u8]) -> bool {
    let n = bytes.len() as u64;
    n >= 4096 && 128 * runs(bytes) < n && {
        let mut counts = [0u64; 256];
        bytes.iter().for_each(|&byte| counts[usize::from(byte)] += 1);
        let pairs: u64 = counts.iter().map(|count| count * count).sum();
        10 * 256 * pairs < 11 * n * n
    }
}

/// How many bytes are equal to the one before; counted in bytes as long as these can't overflow, so that the compiler
/// makes vector code of it.
#[cfg(feature = "write")]
fn runs(bytes: &[u8]) -> u64 {
    let before = bytes.chunks(255);
    let after = bytes.get(1..).unwrap_or_default().chunks(255);
    let count = |(a, b): (&[u8], &[u8])| -> u8 { a.iter().zip(b).map(|(a, b)| u8::from(a == b)).sum() };
    before.zip(after).map(|pair| u64::from(count(pair))).sum()
}

/// Stored blocks (RFC 1951, section 3.2.4).
#[cfg(feature = "write")]
fn store(bytes: &[u8], out: &mut Vec<u8>) {
    for block in bytes.chunks(u16::MAX.into()) {
        let length = block.len() as u16;
        out.push(0);
        out.extend(length.to_le_bytes());
        out.extend((!length).to_le_bytes());
        out.extend(block);
    }
}

/// Compressed blocks that end at a whole byte and are not the last.
#[cfg(feature = "write")]
fn compress(bytes: &[u8], level: u32, out: &mut Vec<u8>) -> std::io::Result<()> {
    const FLUSH: usize = 16;
    ENCODER.with_borrow_mut(|(kept, room)| {
        // A new one clears more memory than compressing a group takes.
        let encoder = match kept {
            Some((same, encoder)) if *same == level => {
                encoder.reset();
                encoder
            }
            _ => &mut kept.insert((level, zlib_rs::Deflate::new(level as i32, false, 15))).1,
        };
        room.resize(room.len().max(zlib_rs::compress_bound(bytes.len()) + FLUSH), 0);
        let result = encoder.compress(bytes, room, zlib_rs::DeflateFlush::SyncFlush);
        if result.is_err() || encoder.total_in() != bytes.len() as u64 {
            return Err(std::io::Error::other("zlib: the compressor failed"));
        }
        out.extend(&room[..encoder.total_out() as usize]);
        Ok(())
    })
}

/// A compressor and its level.
#[cfg(feature = "write")]
type LastEncoder = Option<(u32, zlib_rs::Deflate)>;

#[cfg(feature = "write")]
thread_local! {
    /// A thread's compressor, and the room that it writes to.
    static ENCODER: RefCell<(LastEncoder, Vec<u8>)> = const { RefCell::new((None, Vec::new())) };
}

/// Undoes [`deflate`], as any zlib stream; `None` if it is damaged, or holds more than `most` bytes.
pub fn inflate(bytes: &[u8], most: usize) -> Option<Vec<u8>> {
    let mut decoder = zlib_rs::Inflate::new(true, 15);
    let mut out = Vec::new();
    loop {
        let start = decoder.total_out() as usize;
        // Twice as much as the stream, then as much again; one byte more than may be tells what holds more.
        out.resize((start + start.max(2 * bytes.len().max(4096))).min(most + 1), 0);
        let input = &bytes[decoder.total_in() as usize..];
        match decoder.decompress(input, &mut out[start..], zlib_rs::InflateFlush::NoFlush).ok()? {
            zlib_rs::Status::StreamEnd => break,
            _ if decoder.total_out() as usize == out.len() && out.len() <= most => {}
            _ => return None,
        }
    }
    out.truncate(decoder.total_out() as usize);
    (out.len() <= most).then_some(out)
}

/// Words that are summed side by side, and steps that can't overflow 32 bits: 65,535 (1 + ... + 256) < 2^32.
const LANES: usize = 8;
const STEPS: usize = 256;

/// HDF5's Fletcher-32: sums of big-endian 16-bit words modulo 65535, an odd last byte as a high byte. The second sum
/// counts a word as often as there are words from it to the end; lane by lane that is, of `n` words,
/// n - i = LANES (steps left) - lane.
pub fn fletcher32(bytes: &[u8]) -> u32 {
    let (words, odd) = bytes.as_chunks::<2>();
    let (rows, tail) = words.as_chunks::<LANES>();
    let (mut sum1, mut sum2) = (0u64, 0u64);
    for rows in rows.chunks(STEPS) {
        let (mut once, mut often) = ([0u32; LANES], [0u32; LANES]);
        for row in rows {
            for lane in 0..LANES {
                once[lane] += u32::from(u16::from_be_bytes(row[lane]));
            }
            for lane in 0..LANES {
                often[lane] += once[lane];
            }
        }
        sum2 += (rows.len() * LANES) as u64 * sum1;
        for lane in 0..LANES {
            sum1 += u64::from(once[lane]);
            sum2 += LANES as u64 * u64::from(often[lane]) - lane as u64 * u64::from(once[lane]);
        }
        (sum1, sum2) = (residue(sum1), residue(sum2));
    }
    let odd = odd.iter().map(|&last| u64::from(last) << 8);
    for word in tail.iter().map(|&word| u64::from(u16::from_be_bytes(word))).chain(odd) {
        sum1 += word;
        sum2 += sum1;
    }
    ((residue(sum2) as u32) << 16) | residue(sum1) as u32
}

/// Modulo 65535; as libhdf5 adds the high half to the low one, only 0 itself becomes 0.
fn residue(sum: u64) -> u64 {
    if sum == 0 { 0 } else { (sum - 1) % 65535 + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fletcher32_is_the_hdf5_crates() {
        let bytes: Vec<u8> = (0..20_001u32).map(|i| (i * i % 251) as u8).collect();
        for len in [0, 1, 2, 3, 15, 16, 17, 4095, 4096, 4097, 8191, 8192, 8193, 20_001] {
            let expected = hdf5_reader::checksum::fletcher32(&bytes[..len]);
            assert_eq!(fletcher32(&bytes[..len]), expected, "{len} bytes");
        }
    }

    #[test]
    fn fletcher32_of_extremes_is_the_hdf5_crates() {
        // Sums that are multiples of 65535 are 65535, not 0.
        for bytes in [vec![0xFF; 20_000], vec![0; 20_000], vec![0xFF, 0xFF], vec![0xFF, 0xFE, 0, 1]] {
            assert_eq!(fletcher32(&bytes), hdf5_reader::checksum::fletcher32(&bytes));
        }
    }

    /// Streams of any length, and of another program's; what is damaged, cut or too long is refused.
    #[test]
    fn inflate_is_the_hdf5_crates() {
        let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 13) as u8;
        for len in [0, 1, 5000, 65_536, 300_000] {
            for bytes in [
                vec![7; len as usize],
                (0..len).map(noise).collect(),
                (0..len).map(|i| (i / 99) as u8).collect(),
            ] {
                let packed = deflate(&bytes, 1, 8).unwrap();
                assert_eq!(hdf5_reader::filters::deflate::decompress(&packed).unwrap(), bytes);
                assert_eq!(inflate(&packed, bytes.len()).as_ref(), Some(&bytes), "{len}");
                assert_eq!(inflate(&packed, 1 << 20).as_ref(), Some(&bytes));
                assert_eq!(inflate(&packed[..packed.len() - 1], 1 << 20), None);
                assert_eq!(inflate(&packed, bytes.len().saturating_sub(1)).is_none(), len > 0);
                let mut damaged = packed.clone();
                *damaged.last_mut().unwrap() ^= 1;
                assert_eq!(inflate(&damaged, 1 << 20), None);
            }
        }
        assert_eq!(inflate(b"", 100), None);
    }

    #[test]
    fn runs_are_counted() {
        for len in [0, 1, 2, 254, 255, 256, 257, 510, 511, 1000] {
            let bytes: Vec<u8> = (0..len).map(|i| (i / 3 * i % 7) as u8).collect();
            let expected = bytes.windows(2).filter(|pair| pair[0] == pair[1]).count();
            assert_eq!(runs(&bytes), expected as u64, "{len}");
        }
        assert_eq!(runs(&[9; 2000]), 1999);
    }

    #[test]
    fn unshuffle_is_the_hdf5_crates() {
        let bytes: Vec<u8> = (0..8 * 1000u32).map(|i| (i * i % 251) as u8).collect();
        for size in [2, 4, 8] {
            for count in [0, 1, 255, 256, 257, 1000] {
                let bytes = &bytes[..size * count];
                let expected = hdf5_reader::filters::shuffle::unshuffle(bytes, size);
                assert_eq!(unshuffle(bytes, size).unwrap(), expected, "{count} elements of {size} bytes");
                assert_eq!(unshuffle(&bytes[..bytes.len().saturating_sub(1)], size).is_none(), count > 0);
            }
        }
        assert!(unshuffle(&[1, 2, 3], 3).is_none());
    }

    #[cfg(feature = "write")]
    #[test]
    fn what_is_deflated_is_zlib_for_others_and_noise_is_stored() {
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 56) as u8
        };
        for count in [0, 1, 2, 100, 5000, 65_535, 65_536, 70_000] {
            // The low byte is noise, the high one runs.
            let low: Vec<u8> = (0..count).map(|_| noise()).collect();
            let bytes: Vec<u8> = low.into_iter().chain((0..count).map(|k| (k / 300) as u8)).collect();
            for level in [1, 2, 6, 9] {
                let packed = deflate(&bytes, level, 2).unwrap();
                let limit = bytes.len().max(1);
                let back = hdf5_reader::filters::deflate::decompress_with_limit(&packed, limit).unwrap();
                assert!(back == bytes, "{count} elements, level {level}");
                let stored = count + 10 * (count / 65_535 + 1);
                assert!(
                    count < 4096 || packed.len() < stored + count / 20,
                    "{count}: {} bytes",
                    packed.len()
                );
            }
        }
    }

    #[cfg(feature = "write")]
    #[test]
    fn shuffle_groups_bytes() {
        assert_eq!(shuffle(&[1, 2, 3, 4, 5, 6], 2), [1, 3, 5, 2, 4, 6]);
    }
}
