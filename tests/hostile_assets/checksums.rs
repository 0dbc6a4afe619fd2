//! Makes the checksums of a damaged HDF5 file right again, so that the damage reaches what is behind them.
//! HDF5 File Format Specification, version 3: metadata end in Jenkins' lookup3, filtered chunks in Fletcher-32.

use hdf5_reader::checksum::{fletcher32, jenkins_lookup3};
use std::ops::Range;

/// Metadata with a checksum at the end: superblock, object headers, chunk indexes, B-trees, heaps.
const SIGNATURES: [&[u8]; 14] = [
    b"\x89HDF\r\n\x1a\n",
    b"OHDR",
    b"OCHK",
    b"FAHD",
    b"FADB",
    b"EAHD",
    b"EAIB",
    b"EASB",
    b"EADB",
    b"BTHD",
    b"BTIN",
    b"BTLF",
    b"FRHP",
    b"FHIB",
];
/// How chunks begin: Zstandard's magic number, zlib's header for the levels 1 to 9.
const CHUNK_STARTS: [&[u8]; 5] = [b"\x28\xb5\x2f\xfd", b"\x78\x01", b"\x78\x5e", b"\x78\x9c", b"\x78\xda"];
/// Longer than any metadata of our files.
const MAX_METADATA: usize = 1024;

/// Where the checksums of an undamaged file stand; each right behind the bytes that it covers.
pub struct Checksums {
    metadata: Vec<Range<usize>>,
    chunks: Vec<Chunk>,
}

/// A filtered chunk without its checksum, and where the file tells its address and size.
#[derive(Debug)]
struct Chunk {
    bytes: Range<usize>,
    address_at: usize,
    size_at: Range<usize>,
}

impl Checksums {
    /// Finds them by trying every length: independent of what the file says of itself. What has none, or isn't
    /// pointed to, is left out.
    pub fn find(file: &[u8]) -> Checksums {
        let metadata = signatures(file).into_iter().filter_map(|start| {
            let mut ends = start + 8..(start + MAX_METADATA).min(file.len().saturating_sub(3));
            let end = ends.find(|&end| word(file, end) == jenkins_lookup3(&file[start..end]))?;
            Some(start..end)
        });
        let starts = CHUNK_STARTS.iter().flat_map(|magic| positions(file, magic));
        let chunks = starts.filter_map(|start| chunk(file, start));
        Checksums { metadata: metadata.collect(), chunks: chunks.collect() }
    }

    /// Checksums of metadata and of chunks.
    pub fn counts(&self) -> [usize; 2] {
        [self.metadata.len(), self.chunks.len()]
    }

    /// Where the chunks lie.
    pub fn chunks(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.chunks.iter().map(|chunk| chunk.bytes.clone())
    }

    /// Where the metadata lie.
    pub fn metadata(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.metadata.iter().cloned()
    }

    /// Writes the checksums anew: of the chunks where they were and where the file now says that they are, then of
    /// the metadata where they were and of object headers where they now say that they end.
    pub fn renew(&self, file: &mut [u8]) {
        for chunk in &self.chunks {
            renew(file, chunk.bytes.clone(), fletcher32);
        }
        for chunk in &self.chunks {
            if let Some(bytes) = chunk.bytes_now(file) {
                renew(file, bytes, fletcher32);
            }
        }
        for bytes in &self.metadata {
            renew(file, bytes.clone(), jenkins_lookup3);
        }
        for start in positions(file, b"OHDR") {
            if let Some(end) = header_end(file, start) {
                renew(file, start..end, jenkins_lookup3);
            }
        }
    }
}

impl Chunk {
    fn bytes_now(&self, file: &[u8]) -> Option<Range<usize>> {
        let start = number(file, self.address_at..self.address_at + 8)?;
        let size = number(file, self.size_at.clone())?;
        Some(start..start.checked_add(size)?.checked_sub(4)?)
    }
}

/// Where metadata that should have a checksum begin.
pub fn signatures(file: &[u8]) -> Vec<usize> {
    SIGNATURES.iter().flat_map(|signature| positions(file, signature)).collect()
}

fn renew(file: &mut [u8], bytes: Range<usize>, checksum: fn(&[u8]) -> u32) {
    let at = bytes.end;
    if let Some(covered) = file.get(bytes) {
        let checksum = checksum(covered).to_le_bytes();
        if let Some(stored) = file.get_mut(at..at.saturating_add(4)) {
            stored.copy_from_slice(&checksum);
        }
    }
}

fn chunk(file: &[u8], start: usize) -> Option<Chunk> {
    let bytes = start..start + fletcher_length(&file[start..])?;
    let size = bytes.len() + 4;
    // "Data Layout Message", single chunk: size (8 bytes), filter mask (4), address.
    // "Fixed Array Data Block Element": address, size (as wide as it needs), filter mask.
    let place = |at: usize| {
        let before = at.checked_sub(12).map(|size_at| size_at..size_at + 8);
        let behind = [4, 3, 2].map(|width| Some(at + 8..at + 8 + width));
        let mut places = [before].into_iter().chain(behind).flatten();
        let size_at = places.find(|size_at| number(file, size_at.clone()) == Some(size))?;
        Some(Chunk { bytes: bytes.clone(), address_at: at, size_at })
    };
    positions(file, &(start as u64).to_le_bytes()).into_iter().find_map(place)
}

/// Number of bytes in front of their own Fletcher-32. Running sums, as a chunk can be long.
fn fletcher_length(bytes: &[u8]) -> Option<usize> {
    let (mut sum1, mut sum2) = (0u32, 0u32);
    for end in 1..bytes.len().saturating_sub(3) {
        let last = u32::from(bytes[end - 1]);
        let odd = end % 2 == 1;
        if !odd {
            sum1 = (sum1 + last) % 65535;
            sum2 = (sum2 + sum1) % 65535;
        }
        let now = match odd {
            true => ((sum1 + (last << 8)) % 65535, (sum2 + sum1 + (last << 8)) % 65535),
            false => (sum1, sum2),
        };
        if odd {
            sum1 = (sum1 + (last << 8)) % 65535;
        }
        let stored = word(bytes, end);
        let same = |sum: u32, stored: u32| sum == stored % 65535;
        let likely = same(now.0, stored & 0xFFFF) && same(now.1, stored >> 16);
        if likely && end > 8 && fletcher32(&bytes[..end]) == stored {
            return Some(end);
        }
    }
    None
}

/// End of the messages of an object header, version 2, that begins here.
fn header_end(file: &[u8], start: usize) -> Option<usize> {
    let flags = *file.get(start + 5)?;
    let times = if flags & 0x20 != 0 { 16 } else { 0 };
    let limits = if flags & 0x10 != 0 { 4 } else { 0 };
    let size_at = start + 6 + times + limits;
    let width = 1 << (flags & 3);
    (size_at + width).checked_add(number(file, size_at..size_at + width)?)
}

fn positions(file: &[u8], pattern: &[u8]) -> Vec<usize> {
    let windows = file.windows(pattern.len()).enumerate();
    windows.filter(|(_, window)| *window == pattern).map(|(at, _)| at).collect()
}

fn word(file: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]])
}

fn number(file: &[u8], at: Range<usize>) -> Option<usize> {
    let mut bytes = [0; 8];
    let stored = file.get(at)?;
    bytes[..stored.len()].copy_from_slice(stored);
    usize::try_from(u64::from_le_bytes(bytes)).ok()
}
