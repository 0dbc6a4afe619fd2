//! The filters that a chunk passes on its way to disk: shuffle, compression, Fletcher-32.
//! HDF5 File Format Specification, version 3, "Data Storage - Filter Pipeline Message".

use std::io::Write;

/// Groups the bytes of the elements by significance: all first bytes, then all second ones.
pub fn shuffle(bytes: &[u8], element_size: usize) -> Vec<u8> {
    let count = bytes.len() / element_size;
    let mut out = Vec::with_capacity(bytes.len());
    for byte in 0..element_size {
        out.extend((0..count).map(|element| bytes[element * element_size + byte]));
    }
    out
}

/// Zstandard, registered HDF5 filter 32015.
pub fn zstd(bytes: &[u8], level: i32) -> std::io::Result<Vec<u8>> {
    zstd::bulk::compress(bytes, level)
}

/// zlib, HDF5 filter 1.
pub fn deflate(bytes: &[u8], level: u32) -> std::io::Result<Vec<u8>> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::new(level));
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// HDF5's Fletcher-32: sums of big-endian 16-bit words modulo 65535, an odd last byte as a high byte.
pub fn fletcher32(bytes: &[u8]) -> u32 {
    let (mut sum1, mut sum2) = (0u64, 0u64);
    // 4096 words can't overflow 64 bits between reductions.
    for block in bytes.chunks(8192) {
        for pair in block.chunks(2) {
            let low = pair.get(1).copied().unwrap_or(0);
            sum1 += u64::from(u16::from_be_bytes([pair[0], low]));
            sum2 += sum1;
        }
        sum1 %= 65535;
        sum2 %= 65535;
    }
    ((sum2 as u32) << 16) | sum1 as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fletcher32_is_the_readers() {
        let bytes: Vec<u8> = (0..20_001u32).map(|i| (i * i % 251) as u8).collect();
        for len in [0, 1, 2, 3, 8191, 8192, 8193, 20_001] {
            let expected = hdf5_reader::checksum::fletcher32(&bytes[..len]);
            // 0 and 65535 are the same sum; libhdf5 reduces as the reader does.
            assert_eq!(fletcher32(&bytes[..len]), expected, "{len} bytes");
        }
    }

    #[test]
    fn shuffle_groups_bytes() {
        assert_eq!(shuffle(&[1, 2, 3, 4, 5, 6], 2), [1, 3, 5, 2, 4, 6]);
    }
}
