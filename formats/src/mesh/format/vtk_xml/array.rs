//! The values of one data array.
//!
//! Binary data start with a header: the number of bytes, or, if compressed, the number of blocks,
//! the size of a block, the size of the last block if it is a partial one (else 0), and the
//! compressed size of each block.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::read::ZlibDecoder;
use lzma_rust2::XzReader;

use crate::mesh::binary::{Endian, Scalar};
use crate::mesh::budget::Budget;
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::{any_number, not_a_number, words};

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Where an array's values are.
pub enum Source<'a> {
    Ascii(&'a [u8]),
    /// Base64 text.
    Inline(&'a [u8]),
    /// The appended section from the array's offset on; `None` if the offset isn't in it.
    Appended(Option<&'a [u8]>),
}

/// How a file's arrays are written.
pub struct Decoder {
    endian: Endian,
    header: Scalar,
    compressor: Option<Compressor>,
    appended_raw: bool,
}

/// What a block is compressed by.
#[derive(Clone, Copy)]
enum Compressor {
    Zlib,
    /// Raw blocks, without a frame.
    Lz4,
    /// An xz stream a block.
    Lzma,
}

impl Compressor {
    /// Appends the `size` bytes that `block` holds. False: it doesn't hold so many, or is damaged.
    fn unpack(self, block: &[u8], size: usize, out: &mut Vec<u8>) -> bool {
        let before = out.len();
        // One more than there should be tells that there are more.
        let limit = size as u64 + 1;
        let read = match self {
            Compressor::Zlib => ZlibDecoder::new(block).take(limit).read_to_end(out).is_ok(),
            Compressor::Lzma => {
                XzReader::new_mem_limit(block, false, LZMA_KIB).take(limit).read_to_end(out).is_ok()
            }
            Compressor::Lz4 => {
                out.resize(before + size, 0);
                lz4_flex::block::decompress_into(block, &mut out[before..]).is_ok_and(|found| found == size)
            }
        };
        read && out.len() - before == size
    }
}

/// The most memory that LZMA may take, in KiB: VTK's presets up to 6 take 9 MiB.
const LZMA_KIB: u32 = 48 << 10;

/// What is wrong with an array.
pub enum Problem {
    Malformed(String),
    Unsupported(String, &'static str),
    Other(MeshError),
}

impl Problem {
    pub fn into_error(self, raw: &RawMesh, place: String) -> MeshError {
        match self {
            Problem::Malformed(problem) => raw.bad(place, problem),
            Problem::Unsupported(what, cure) => MeshError::unsupported(raw.format, what, cure),
            Problem::Other(error) => error,
        }
    }
}

fn bad(problem: impl Into<String>) -> Problem {
    Problem::Malformed(problem.into())
}

fn cut() -> Problem {
    bad("the data end early; the file was cut or is damaged: export it again")
}

impl Decoder {
    pub fn new(
        byte_order: &str,
        header_type: &str,
        compressor: &str,
        appended: Option<&[u8]>,
    ) -> Result<Decoder, Problem> {
        let compressor = match compressor {
            "" => None,
            "vtkZLibDataCompressor" => Some(Compressor::Zlib),
            "vtkLZ4DataCompressor" => Some(Compressor::Lz4),
            "vtkLZMADataCompressor" => Some(Compressor::Lzma),
            other => {
                return Err(Problem::Unsupported(
                    format!("compression by {other}"),
                    "save the file with zlib compression or none (in ParaView: CompressorType)",
                ));
            }
        };
        Ok(Decoder {
            endian: match byte_order {
                "BigEndian" => Endian::Big,
                "LittleEndian" | "" => Endian::Little,
                other => return Err(bad(format!("`{other}` is not a byte order"))),
            },
            header: match header_type {
                "UInt64" => Scalar::U64,
                "UInt32" | "" => Scalar::U32,
                other => return Err(bad(format!("`{other}` is not a header type"))),
            },
            compressor,
            appended_raw: appended.is_some_and(|data| !is_base64(data)),
        })
    }

    pub fn decode(&self, source: &Source, kind: &str, budget: &mut Budget) -> Result<Vec<f64>, Problem> {
        let kind = scalar(kind)?;
        let bytes = match source {
            Source::Ascii(text) => return ascii(text),
            Source::Inline(text) => self.unpack(&mut Stream::base64(text), budget)?,
            Source::Appended(None) => return Err(bad("the offset is not in the appended data")),
            Source::Appended(Some(data)) if self.appended_raw => {
                self.unpack(&mut Stream::raw(data), budget)?
            }
            Source::Appended(Some(data)) => self.unpack(&mut Stream::base64(data), budget)?,
        };
        let count = bytes.len() / kind.size();
        budget.take(count, 8, "the file").map_err(Problem::Other)?;
        Ok(bytes.chunks_exact(kind.size()).map(|item| kind.read(item, self.endian)).collect())
    }

    fn unpack<'a>(&self, stream: &mut Stream<'a>, budget: &mut Budget) -> Result<Cow<'a, [u8]>, Problem> {
        let word = self.header.size();
        let Some(compressor) = self.compressor else {
            let size = self.sizes(stream, 1)?[0];
            return stream.take(size);
        };
        let head = self.sizes(stream, 3)?;
        let (blocks, block, last) = (head[0], head[1], head[2]);
        if blocks.saturating_mul(word) > stream.left() {
            return Err(cut());
        }
        let packed = self.sizes(stream, blocks)?;
        // The header is a base64 text of its own.
        stream.next_text();
        let mut out = Vec::new();
        for (k, &size) in packed.iter().enumerate() {
            let full = if k + 1 == blocks && last > 0 { last } else { block };
            let bytes = stream.take(size)?;
            budget.take(full, 1, "the file").map_err(Problem::Other)?;
            if !compressor.unpack(&bytes, full, &mut out) {
                return Err(bad("a compressed block is damaged: export the file again"));
            }
        }
        Ok(Cow::Owned(out))
    }

    fn sizes(&self, stream: &mut Stream, count: usize) -> Result<Vec<usize>, Problem> {
        let size = self.header.size();
        let bytes = stream.take(count.checked_mul(size).ok_or_else(cut)?)?;
        Ok(bytes.chunks_exact(size).map(|item| self.header.read(item, self.endian) as usize).collect())
    }
}

/// Raw appended data start with a small number in 4 or 8 bytes, so there is a 0 among the first 8.
fn is_base64(data: &[u8]) -> bool {
    data.iter().take(8).all(|b| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'/' | b'='))
}

/// Bytes that are read from the front, raw or from base64.
struct Stream<'a> {
    bytes: &'a [u8],
    base64: bool,
    /// Decoded, not taken.
    pending: Vec<u8>,
}

impl<'a> Stream<'a> {
    fn raw(bytes: &'a [u8]) -> Stream<'a> {
        Stream { bytes, base64: false, pending: Vec::new() }
    }

    fn base64(bytes: &'a [u8]) -> Stream<'a> {
        Stream { bytes: bytes.trim_ascii_start(), base64: true, pending: Vec::new() }
    }

    fn left(&self) -> usize {
        self.bytes.len() + self.pending.len()
    }

    /// Drops the rest of a base64 group.
    fn next_text(&mut self) {
        self.pending.clear();
    }

    fn take(&mut self, count: usize) -> Result<Cow<'a, [u8]>, Problem> {
        if count > self.left() {
            return Err(cut());
        }
        if !self.base64 {
            let (now, rest) = self.bytes.split_at(count);
            self.bytes = rest;
            return Ok(Cow::Borrowed(now));
        }
        let mut out = std::mem::take(&mut self.pending);
        while out.len() < count {
            self.decode_some(count - out.len(), &mut out)?;
        }
        self.pending = out.split_off(count);
        Ok(Cow::Owned(out))
    }

    /// Decodes groups of four characters until `wanted` bytes are there, at most up to a padding.
    fn decode_some(&mut self, wanted: usize, out: &mut Vec<u8>) -> Result<(), Problem> {
        let mut group: Vec<u8> = Vec::new();
        let mut used = 0;
        for &byte in self.bytes {
            if byte == b'<' {
                break;
            }
            used += 1;
            if byte.is_ascii_whitespace() {
                continue;
            }
            group.push(byte);
            let whole = group.len().is_multiple_of(4);
            if whole && (byte == b'=' || group.len() / 4 * 3 >= wanted) {
                break;
            }
        }
        if group.is_empty() {
            return Err(cut());
        }
        self.bytes = &self.bytes[used..];
        BASE64
            .decode_vec(&group, out)
            .map_err(|error| bad(format!("invalid base64: {error}; export the file again")))
    }
}

fn ascii(text: &[u8]) -> Result<Vec<f64>, Problem> {
    let number = |word| any_number(word).ok_or_else(|| bad(not_a_number(word, "data array")));
    words(text).map(number).collect()
}

fn scalar(name: &str) -> Result<Scalar, Problem> {
    Ok(match name {
        "Int8" => Scalar::I8,
        "UInt8" => Scalar::U8,
        "Int16" => Scalar::I16,
        "UInt16" => Scalar::U16,
        "Int32" => Scalar::I32,
        "UInt32" => Scalar::U32,
        "Int64" => Scalar::I64,
        "UInt64" => Scalar::U64,
        "Float32" => Scalar::F32,
        "Float64" => Scalar::F64,
        _ => return Err(bad(format!("`{name}` is not a number type"))),
    })
}
