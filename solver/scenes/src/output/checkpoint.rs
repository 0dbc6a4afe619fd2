//! Checkpoints: all that a run needs to go on with the same bytes, in a file that is checked before it is used.
//!
//! ```text
//! "volmapCP"  version u32  scene 32 bytes  { name length u32, name, kind u8, data length u64, data }*  0 u32
//! BLAKE3 of all before, 32 bytes
//! ```
//! Numbers are little-endian. A damaged, cut or foreign file, or one of another scene, is an error, never other
//! numbers.

use super::io_error;
use crate::error::Error;
use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use volmap_formats::asset::NewFile;
use volmap_runtime::DVec3;

const MAGIC: [u8; 8] = *b"volmapCP";
const VERSION: u32 = 1;
const HASH: usize = 32;
/// Bytes before the first entry.
const START: usize = 8 + 4 + HASH;
/// Longest name, bytes.
const MAX_NAME: usize = 1 << 10;

/// What an entry holds; the number is that in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Kind {
    Bytes = 0,
    F32 = 1,
    F64 = 2,
    U32 = 3,
    U64 = 4,
}

/// Writes a checkpoint. The file appears under its name when it is finished, whole.
pub struct CheckpointWriter {
    path: PathBuf,
    out: BufWriter<NewFile>,
    hasher: blake3::Hasher,
}

impl CheckpointWriter {
    /// Begins a checkpoint of the scene of this hash.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn create(path: &Path, scene: [u8; HASH]) -> Result<CheckpointWriter, Error> {
        let file = NewFile::create(path).map_err(io_error(path))?;
        let (path, out) = (path.to_owned(), BufWriter::with_capacity(1 << 20, file));
        let mut writer = CheckpointWriter { path, out, hasher: blake3::Hasher::new() };
        writer.write(&MAGIC)?;
        writer.write(&VERSION.to_le_bytes())?;
        writer.write(&scene)?;
        Ok(writer)
    }

    /// Adds bytes. Names are not empty, at most 1,024 bytes long, and unique.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn put(&mut self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        self.begin(name, Kind::Bytes, bytes.len())?;
        self.write(bytes)
    }

    /// Adds numbers.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn put_f32(&mut self, name: &str, numbers: &[f32]) -> Result<(), Error> {
        self.put_words(name, Kind::F32, numbers, f32::to_le_bytes)
    }

    /// Adds vectors, as numbers.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn put_f32x3(&mut self, name: &str, vectors: &[[f32; 3]]) -> Result<(), Error> {
        self.put_f32(name, vectors.as_flattened())
    }

    /// Adds numbers; a single one is a list of one.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn put_f64(&mut self, name: &str, numbers: &[f64]) -> Result<(), Error> {
        self.put_words(name, Kind::F64, numbers, f64::to_le_bytes)
    }

    /// Adds points, as numbers.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn put_points(&mut self, name: &str, points: &[DVec3]) -> Result<(), Error> {
        self.begin(name, Kind::F64, 24 * points.len())?;
        points.chunks(CHUNK).try_for_each(|chunk| {
            self.write(
                &chunk.iter().flat_map(|p| p.to_array()).flat_map(f64::to_le_bytes).collect::<Vec<u8>>(),
            )
        })
    }

    /// Adds numbers.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn put_u32(&mut self, name: &str, numbers: &[u32]) -> Result<(), Error> {
        self.put_words(name, Kind::U32, numbers, u32::to_le_bytes)
    }

    /// Adds numbers; a single one is a list of one.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn put_u64(&mut self, name: &str, numbers: &[u64]) -> Result<(), Error> {
        self.put_words(name, Kind::U64, numbers, u64::to_le_bytes)
    }

    /// Publishes the file durably, in place of an older checkpoint.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn finish(mut self) -> Result<(), Error> {
        self.write(&0u32.to_le_bytes())?;
        let hash = *self.hasher.finalize().as_bytes();
        self.write(&hash)?;
        let path = self.path;
        let file = self.out.into_inner().map_err(|error| io_error(&path)(error.into_error()))?;
        file.publish().map_err(io_error(&path))
    }

    fn begin(&mut self, name: &str, kind: Kind, length: usize) -> Result<(), Error> {
        if name.is_empty() || name.len() > MAX_NAME {
            return Err(refuse(&self.path, format!("an entry can't be named \"{name}\"")));
        }
        self.write(&(name.len() as u32).to_le_bytes())?;
        self.write(name.as_bytes())?;
        self.write(&[kind as u8])?;
        self.write(&(length as u64).to_le_bytes())
    }

    fn put_words<T: Copy, const N: usize>(
        &mut self,
        name: &str,
        kind: Kind,
        numbers: &[T],
        bytes_of: fn(T) -> [u8; N],
    ) -> Result<(), Error> {
        self.begin(name, kind, N * numbers.len())?;
        numbers.chunks(CHUNK).try_for_each(|chunk| {
            self.write(&chunk.iter().flat_map(|&number| bytes_of(number)).collect::<Vec<u8>>())
        })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.hasher.update(bytes);
        self.out.write_all(bytes).map_err(io_error(&self.path))
    }
}

/// Numbers that are turned into bytes at a time.
const CHUNK: usize = 1 << 15;

fn refuse(path: &Path, reason: impl Into<String>) -> Error {
    Error::Checkpoint { path: path.to_owned(), reason: reason.into() }
}

/// A checkpoint that was read and found undamaged.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    entries: Entries,
}

impl Checkpoint {
    /// Reads a checkpoint of the scene of this hash.
    ///
    /// # Errors
    /// A file that can't be read, is damaged or newer, or belongs to another scene.
    pub fn open(path: &Path, scene: [u8; HASH]) -> Result<Checkpoint, Error> {
        let bytes = std::fs::read(path).map_err(io_error(path))?;
        let entries = parse(&bytes, scene).map_err(|reason| refuse(path, reason))?;
        Ok(Checkpoint { path: path.to_owned(), entries })
    }

    /// The bytes of an entry.
    ///
    /// # Errors
    /// No such entry, or one of another kind; the same holds for the others.
    pub fn get(&self, name: &str) -> Result<&[u8], Error> {
        self.entry(name, Kind::Bytes)
    }

    /// Numbers.
    ///
    /// # Errors
    /// See [`Checkpoint::get`].
    pub fn get_f32(&self, name: &str) -> Result<Vec<f32>, Error> {
        self.words(name, Kind::F32, f32::from_le_bytes)
    }

    /// Vectors.
    ///
    /// # Errors
    /// See [`Checkpoint::get`]; or numbers that aren't three for each vector.
    pub fn get_f32x3(&self, name: &str) -> Result<Vec<[f32; 3]>, Error> {
        Ok(self.threes(name, &self.get_f32(name)?)?.to_vec())
    }

    /// Numbers.
    ///
    /// # Errors
    /// See [`Checkpoint::get`].
    pub fn get_f64(&self, name: &str) -> Result<Vec<f64>, Error> {
        self.words(name, Kind::F64, f64::from_le_bytes)
    }

    /// Points.
    ///
    /// # Errors
    /// See [`Checkpoint::get`]; or numbers that aren't three for each point.
    pub fn get_points(&self, name: &str) -> Result<Vec<DVec3>, Error> {
        Ok(self.threes(name, &self.get_f64(name)?)?.iter().map(|&p| p.into()).collect())
    }

    /// Numbers.
    ///
    /// # Errors
    /// See [`Checkpoint::get`].
    pub fn get_u32(&self, name: &str) -> Result<Vec<u32>, Error> {
        self.words(name, Kind::U32, u32::from_le_bytes)
    }

    /// Numbers.
    ///
    /// # Errors
    /// See [`Checkpoint::get`].
    pub fn get_u64(&self, name: &str) -> Result<Vec<u64>, Error> {
        self.words(name, Kind::U64, u64::from_le_bytes)
    }

    /// The error for content that is undamaged, but can't be used: lists of different lengths, for example.
    pub fn refuse(&self, reason: impl Into<String>) -> Error {
        refuse(&self.path, reason)
    }

    fn entry(&self, name: &str, wanted: Kind) -> Result<&[u8], Error> {
        match self.entries.get(name) {
            Some(entry) if entry.kind == wanted => Ok(&entry.bytes),
            Some(Entry { kind, .. }) => {
                Err(self.refuse(format!("\"{name}\" holds {kind:?}, not {wanted:?}")))
            }
            None => Err(self.refuse(format!("holds no \"{name}\": it is of another version of the program"))),
        }
    }

    fn words<T, const N: usize>(
        &self,
        name: &str,
        kind: Kind,
        of: fn([u8; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        match self.entry(name, kind)?.as_chunks::<N>() {
            (words, []) => Ok(words.iter().map(|&word| of(word)).collect()),
            _ => Err(self.refuse(format!("\"{name}\" ends within a number"))),
        }
    }

    fn threes<'a, T>(&self, name: &str, numbers: &'a [T]) -> Result<&'a [[T; 3]], Error> {
        match numbers.as_chunks::<3>() {
            (threes, []) => Ok(threes),
            _ => Err(self.refuse(format!("\"{name}\" ends within a vector"))),
        }
    }
}

/// What stands under a name.
#[derive(Debug)]
struct Entry {
    kind: Kind,
    bytes: Vec<u8>,
}

type Entries = BTreeMap<String, Entry>;

fn parse(bytes: &[u8], scene: [u8; HASH]) -> Result<Entries, String> {
    const DAMAGED: &str = "the checkpoint is damaged; begin again";
    if !bytes.starts_with(&MAGIC) {
        return Err("not a checkpoint of volmap".into());
    }
    let version = bytes.get(8..12).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if let Some(newer @ VERSION..) = version.filter(|&v| v > VERSION) {
        return Err(format!("the checkpoint has version {newer}, newer than this program's {VERSION}"));
    }
    let (content, hash) = bytes.split_last_chunk::<HASH>().ok_or(DAMAGED)?;
    if version != Some(VERSION) || content.len() < START || blake3::hash(content).as_bytes() != hash {
        return Err(DAMAGED.into());
    }
    if content[12..START] != scene {
        return Err(
            "the checkpoint is of another scene: undo the changes to the scene, or begin again".into()
        );
    }
    read_entries(&content[START..]).ok_or(DAMAGED.into())
}

/// The entries of content whose hash is right. It fails for files that were forged.
fn read_entries(mut rest: &[u8]) -> Option<Entries> {
    let mut entries = BTreeMap::new();
    loop {
        let name_length = u32::from_le_bytes(rest.split_off(..4)?.try_into().ok()?) as usize;
        if name_length == 0 {
            return rest.is_empty().then_some(entries);
        }
        if name_length > MAX_NAME {
            return None;
        }
        let name = std::str::from_utf8(rest.split_off(..name_length)?).ok()?;
        let kind = match rest.split_off_first()? {
            0 => Kind::Bytes,
            1 => Kind::F32,
            2 => Kind::F64,
            3 => Kind::U32,
            4 => Kind::U64,
            _ => return None,
        };
        let length = u64::from_le_bytes(rest.split_off(..8)?.try_into().ok()?);
        let data = rest.split_off(..usize::try_from(length).ok()?)?;
        if entries.insert(name.to_owned(), Entry { kind, bytes: data.to_vec() }).is_some() {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: [u8; 32] = [7; 32];

    fn write(path: &Path) {
        let mut writer = CheckpointWriter::create(path, SCENE).unwrap();
        writer.put("bytes", b"any").unwrap();
        writer.put_f32("f32", &[1.5, f32::NAN, -0.0]).unwrap();
        writer.put_f32x3("velocities", &[[1.0, 2.0, 3.0]]).unwrap();
        writer.put_points("points", &[DVec3::new(0.1, 0.2, 0.3), DVec3::MAX]).unwrap();
        writer.put_u32("ids", &[u32::MAX]).unwrap();
        writer.put_u64("step", &[u64::MAX]).unwrap();
        writer.put_f64("none", &[]).unwrap();
        writer.finish().unwrap();
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint");
        write(&path);
        let point = Checkpoint::open(&path, SCENE).unwrap();
        assert_eq!(point.get("bytes").unwrap(), b"any");
        let bits: Vec<u32> = point.get_f32("f32").unwrap().iter().map(|x| x.to_bits()).collect();
        assert_eq!(bits, [1.5f32, f32::NAN, -0.0].map(f32::to_bits));
        assert_eq!(point.get_f32x3("velocities").unwrap(), [[1.0, 2.0, 3.0]]);
        assert_eq!(point.get_points("points").unwrap(), [DVec3::new(0.1, 0.2, 0.3), DVec3::MAX]);
        assert_eq!(point.get_u32("ids").unwrap(), [u32::MAX]);
        assert_eq!(point.get_u64("step").unwrap(), [u64::MAX]);
        assert!(point.get_f64("none").unwrap().is_empty());
        for error in [
            point.get_u32("step").unwrap_err(),
            point.get("missing").unwrap_err(),
            point.get_f32x3("bytes").unwrap_err(),
        ] {
            assert!(matches!(error, Error::Checkpoint { .. }), "{error}");
        }
        let mut writer = CheckpointWriter::create(&path, SCENE).unwrap();
        assert!(writer.put("", b"").is_err());
        drop(writer);
        assert!(Checkpoint::open(&path, SCENE).is_ok(), "the old one stays until the new one is whole");
    }

    #[test]
    fn another_scene_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint");
        write(&path);
        let error = Checkpoint::open(&path, [8; 32]).unwrap_err().to_string();
        assert!(error.contains("another scene") && error.contains("checkpoint:"), "{error}");
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[8] = 2;
        let error = parse(&bytes, SCENE).unwrap_err();
        assert!(error.contains("version 2, newer"), "{error}");
        assert!(parse(b"something else", SCENE).unwrap_err().contains("not a checkpoint"));
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint");
        write(&path);
        let bytes = std::fs::read(&path).unwrap();
        assert!(parse(&bytes, SCENE).is_ok());
        for length in 0..bytes.len() {
            assert!(parse(&bytes[..length], SCENE).is_err(), "{length} bytes");
        }
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(parse(&damaged, SCENE).is_err(), "bit {bit}");
        }
        assert!(parse(&[&bytes[..], &[0]].concat(), SCENE).is_err(), "a byte more");
    }

    /// Files made to break the reader have a hash that is right.
    #[test]
    fn entries_are_not_trusted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint");
        write(&path);
        let bytes = std::fs::read(&path).unwrap();
        let content = &bytes[START..bytes.len() - HASH];
        for length in 0..content.len() {
            assert!(read_entries(&content[..length]).is_none(), "{length} bytes");
        }
        for at in 0..content.len() {
            for value in [0, 1, 0x7f, 0xff] {
                let mut damaged = content.to_vec();
                damaged[at] = value;
                // May be other entries, but no panic and no memory beyond the file's size.
                if let Some(entries) = read_entries(&damaged) {
                    assert!(entries.values().map(|entry| entry.bytes.len()).sum::<usize>() <= content.len());
                }
            }
        }
        let twice = [&content[..content.len() - 4], content].concat();
        assert!(read_entries(&twice).is_none(), "names are unique");
    }
}
