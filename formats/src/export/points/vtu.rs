//! Particles as VTK's XML UnstructuredGrid (`.vtu`), one vertex cell each; appended data, compressed by zlib in
//! blocks, as base64: splashsurf reads no raw bytes. *VTK File Formats*, Kitware.

use super::{Points, Positions, Values};
use crate::export::{ExportError, publish_to};
use base64::Engine;
use base64::prelude::BASE64_STANDARD as BASE64;
use flate2::{Compression, write::ZlibEncoder};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// VTK_VERTEX.
const VERTEX: u8 = 1;
/// Bytes of a block, which is compressed by itself.
const BLOCK: usize = 1 << 18;
/// Numbers like these shrink little, so the fastest level.
const LEVEL: u32 = 1;

/// Writes particles.
///
/// # Errors
/// Lists of different lengths, more than 2^32 - 1 points, or a file that can't be written.
pub fn write(path: &Path, points: &Points) -> Result<(), ExportError> {
    let bytes = points.check(u32::MAX as usize).and_then(|()| to_bytes(points));
    publish_to(path, &bytes.map_err(|error| ExportError::Io(error).in_file(path))?)
}

fn to_bytes(points: &Points) -> std::io::Result<Vec<u8>> {
    let count = points.positions.len();
    let mut file = Parts {
        header: "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
             byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n\
             <UnstructuredGrid>\n"
            .to_owned(),
        data: String::new(),
    };
    file.facts(&points.facts)?;
    _ = writeln!(file.header, "<Piece NumberOfPoints=\"{count}\" NumberOfCells=\"{count}\">");
    file.header += "<PointData>\n";
    for &(name, values) in &points.arrays {
        file.values(name, values)?;
    }
    file.header += "</PointData>\n<Points>\n";
    let kind = if matches!(points.positions, Positions::F32(_)) { "Float32" } else { "Float64" };
    let mut places = Vec::with_capacity(count * points.positions.bytes());
    (0..count).for_each(|point| points.positions.add(point, &mut places));
    file.array(Array { kind, name: "Points", components: 3, tuples: None }, &places)?;
    file.header += "</Points>\n<Cells>\n";
    let numbers =
        |first: u32| (0..count as u32).flat_map(move |n| (n + first).to_le_bytes()).collect::<Vec<u8>>();
    let list = |kind, name| Array { kind, name, components: 1, tuples: None };
    file.array(list("UInt32", "connectivity"), &numbers(0))?;
    file.array(list("UInt32", "offsets"), &numbers(1))?;
    file.array(list("UInt8", "types"), &vec![VERTEX; count])?;
    file.header += "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"base64\">\n_";
    let mut bytes = file.header.into_bytes();
    bytes.extend(file.data.into_bytes());
    bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
    Ok(bytes)
}

/// The text and what is appended to it.
struct Parts {
    header: String,
    data: String,
}

/// An array, as its element describes it.
struct Array<'a> {
    kind: &'static str,
    name: &'a str,
    components: usize,
    /// Where neither points nor cells tell it.
    tuples: Option<usize>,
}

impl Parts {
    fn facts(&mut self, facts: &[(&str, Vec<f64>)]) -> std::io::Result<()> {
        if facts.is_empty() {
            return Ok(());
        }
        self.header += "<FieldData>\n";
        for (name, numbers) in facts {
            let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
            let array = Array { kind: "Float64", name, components: 1, tuples: Some(numbers.len()) };
            self.array(array, &bytes)?;
        }
        self.header += "</FieldData>\n";
        Ok(())
    }

    fn values(&mut self, name: &str, values: Values) -> std::io::Result<()> {
        let kind = if matches!(values, Values::U32(_)) { "UInt32" } else { "Float32" };
        let words = (0..values.count()).flat_map(|point| values.words(point));
        let array = Array { kind, name, components: values.components(), tuples: None };
        self.array(array, &words.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
    }

    fn array(&mut self, array: Array, bytes: &[u8]) -> std::io::Result<()> {
        let Array { kind, name, components, tuples } = array;
        let tuples = tuples.map(|n| format!(" NumberOfTuples=\"{n}\"")).unwrap_or_default();
        let offset = self.data.len();
        _ = writeln!(
            self.header,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"{tuples} \
             format=\"appended\" offset=\"{offset}\"/>"
        );
        let blocks: Vec<Vec<u8>> = bytes.par_chunks(BLOCK).map(deflate).collect::<std::io::Result<_>>()?;
        // Blocks, bytes of a whole one, bytes of the last one if it isn't whole; then the compressed bytes of each.
        let sizes = [blocks.len(), BLOCK, bytes.len() % BLOCK];
        let lengths = sizes.into_iter().chain(blocks.iter().map(Vec::len));
        let head: Vec<u8> = lengths.flat_map(|length| (length as u64).to_le_bytes()).collect();
        self.data += &BASE64.encode(head);
        self.data += &BASE64.encode(blocks.concat());
        Ok(())
    }
}

fn deflate(block: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    encoder.write_all(block)?;
    encoder.finish()
}

#[cfg(test)]
mod tests {
    use super::super::tests::with_sample;
    use super::*;

    /// The numbers before the blocks of the array of this name, and what follows them, in base64.
    fn array<'a>(file: &'a str, name: &str) -> (Vec<u64>, &'a str) {
        let at = file.split_once(&format!("Name=\"{name}\"")).unwrap().1.split_once("offset=\"").unwrap().1;
        let offset: usize = at.split_once('"').unwrap().0.parse().unwrap();
        let data = &file.split_once("base64\">\n_").unwrap().1[offset..];
        // Four letters are three bytes; the first number tells how many there are.
        let first = BASE64.decode(&data[..12]).unwrap();
        let blocks = u64::from_le_bytes(first[..8].try_into().unwrap()) as usize;
        let (head, rest) = data.split_at((8 * (3 + blocks)).div_ceil(3) * 4);
        let head = BASE64.decode(head).unwrap();
        (head.as_chunks().0.iter().map(|&n| u64::from_le_bytes(n)).collect(), rest)
    }

    #[test]
    fn arrays_begin_where_the_header_says() {
        let file = String::from_utf8(with_sample(to_bytes).unwrap()).unwrap();
        let (numbers, rest) = array(&file, "density");
        assert_eq!(numbers[..3], [1, BLOCK as u64, 200]);
        let block = BASE64.decode(&rest[..(numbers[3] as usize).div_ceil(3) * 4]).unwrap();
        let mut back = Vec::new();
        std::io::Read::read_to_end(&mut flate2::read::ZlibDecoder::new(&block[..]), &mut back).unwrap();
        assert_eq!(f32::from_le_bytes(back[4..8].try_into().unwrap()), 1.0 + 1e-4);
    }

    #[test]
    fn whole_blocks_leave_no_part() {
        let density = vec![1.0f32; 2 * BLOCK / 4];
        let positions = vec![[0.0; 3]; density.len()];
        let points = Points {
            positions: Positions::F32(&positions),
            arrays: vec![("density", Values::F32(&density))],
            ..Points::default()
        };
        let file = String::from_utf8(to_bytes(&points).unwrap()).unwrap();
        assert_eq!(array(&file, "density").0[..3], [2, BLOCK as u64, 0]);
        assert!(to_bytes(&Points::default()).is_ok());
    }
}
