//! A [`Tree`] into HDF5 bytes. The one file that knows the crate `rust-hdf5`.
//!
//! The chunks are filtered here and handed over ready, so that the bytes depend on `zlib-rs` and `zstd` only.
//! Text attributes are fixed-length UTF-8 with a trailing NUL: libhdf5's C API can't read that crate's
//! variable-length ones.

use super::error::AssetError;
use super::filters;
use super::read::read_tree;
use super::schema::asset_from_tree;
use super::tree::{Array, Attributes, Dataset, Tree, Value};
use rayon::prelude::*;
use rust_hdf5::{DatatypeMessage, Filter, FilterPipeline, H5Dataset, H5File, H5Group, H5Type};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// How the datasets are compressed; both filters keep every bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// gzip (HDF5 filter 1), level 1 to 9: every HDF5 library reads it.
    Gzip(u32),
    /// Zstandard (HDF5 filter 32015), level 1 to 22: quicker to write and to read, for readers with its plugin.
    Zstd(i32),
}

impl Default for Compression {
    /// Higher levels take far longer for little: `BENCHMARKS.md`.
    fn default() -> Self {
        Compression::Gzip(2)
    }
}

/// Elements of a chunk along its first axis times the other axes.
const CHUNK_ELEMENTS: usize = 1 << 16;

/// Writes to a scratch file and reads that back.
pub(super) fn encode(tree: &Tree, compression: Compression) -> Result<Vec<u8>, AssetError> {
    let bytes = to_bytes(tree, compression, &std::env::temp_dir())?;
    let groups: Vec<&str> = tree.groups.keys().map(String::as_str).collect();
    let datasets: Vec<&str> = tree.datasets.keys().map(String::as_str).collect();
    let back = read_tree(bytes.clone(), &groups, |_| Ok(datasets.clone()))?;
    let same = back == *tree;
    // Nothing is written that would be refused when read; NaN, which equals nothing, is told here.
    asset_from_tree(back)?;
    if !same {
        return Err(AssetError::Container("what was written doesn't read back".into()));
    }
    Ok(bytes)
}

/// The filtered chunks of each dataset, by its path.
type Chunks<'a> = BTreeMap<&'a str, Vec<Vec<u8>>>;

/// That crate writes files only. The scratch file needn't outlast a power cut, nor leave the system's cache. It loses
/// its name as soon as it is open, so that killed programs leave nothing. (On Windows open files keep their names.)
fn to_bytes(tree: &Tree, compression: Compression, folder: &Path) -> Result<Vec<u8>, AssetError> {
    let chunks = all_chunks(tree, compression)?;
    let write = || {
        let scratch = tempfile::Builder::new().prefix("volmap-").suffix(".h5").tempfile_in(folder)?;
        reserve(scratch.as_file(), room(tree, &chunks))?;
        let file = H5File::create(scratch.path()).map_err(asset_error)?;
        let (mut content, name) = scratch.into_parts();
        #[cfg(unix)]
        name.close()?;
        if let Err(error) = write_objects(&file, tree, &chunks, compression) {
            // Dropped, it would try again to finish the file, and print that this fails.
            std::mem::forget(file);
            return Err(asset_error(error));
        }
        file.close_no_sync().map_err(asset_error)?;
        let mut bytes = Vec::new();
        content.read_to_end(&mut bytes)?;
        #[cfg(not(unix))]
        drop(name);
        Ok(bytes)
    };
    write().map_err(|error| in_temporary_folder(error, folder))
}

/// What the system says of a scratch file, with the folder, what it is for, and the cure.
fn in_temporary_folder(error: AssetError, folder: &Path) -> AssetError {
    let AssetError::Io(error) = error else { return error };
    let text = format!(
        "the asset passes through a file in the temporary folder {}, which can't be written: {error}; make room there, \
         or name another folder by TMPDIR",
        folder.display()
    );
    AssetError::Io(std::io::Error::new(error.kind(), text))
}

/// Bytes that the file has at most: the chunks, and what HDF5 needs beside them.
fn room(tree: &Tree, chunks: &Chunks) -> u64 {
    const FOR_STRUCTURE: usize = 1 << 18;
    const FOR_CHUNK: usize = 64;
    let objects = tree.groups.values().chain(tree.datasets.values().map(|dataset| &dataset.attributes));
    let value = |value: &Value| match value {
        Value::Integer(list) => 8 * list.len(),
        Value::Real(list) => 8 * list.len(),
        Value::Text(text) => text.len(),
    };
    let attributes: usize = objects.flat_map(BTreeMap::values).map(value).sum();
    let stored: usize = chunks.values().flatten().map(|chunk| chunk.len() + FOR_CHUNK).sum();
    (FOR_STRUCTURE + 2 * attributes + stored) as u64
}

/// Takes the room for a file before it is written, where the system can: afterwards that crate would print what failed.
#[cfg(target_os = "linux")]
fn reserve(file: &File, bytes: u64) -> std::io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    let reserved = fallocate(file, FallocateFlags::KEEP_SIZE, 0, bytes).map_err(std::io::Error::from);
    // Some file systems know no such thing.
    reserved.or_else(|error| match error.kind() {
        StorageFull | QuotaExceeded | FileTooLarge => Err(error),
        _ => Ok(()),
    })
}

#[cfg(not(target_os = "linux"))]
fn reserve(_: &File, _: u64) -> std::io::Result<()> {
    Ok(())
}

fn asset_error(error: rust_hdf5::Hdf5Error) -> AssetError {
    if let rust_hdf5::Hdf5Error::Io(error) = error {
        return AssetError::Io(error);
    }
    let text = error.to_string();
    system_error(&text).map_or(AssetError::Container(text), AssetError::Io)
}

/// The crate keeps the system's errors to itself, but for their text.
fn system_error(text: &str) -> Option<std::io::Error> {
    let (_, code) = text.rsplit_once("(os error ")?;
    Some(std::io::Error::from_raw_os_error(code.split_once(')')?.0.parse().ok()?))
}

fn write_objects(
    file: &H5File,
    tree: &Tree,
    chunks: &Chunks,
    compression: Compression,
) -> rust_hdf5::Result<()> {
    for (path, attributes) in &tree.groups {
        let group = match path.trim_start_matches('/') {
            "" => file.root_group(),
            name => file.create_group(name)?,
        };
        write_attributes(attributes, &Target::Group(&group))?;
    }
    for (path, dataset) in &tree.datasets {
        let chunks = &chunks[path.as_str()];
        let created = match &dataset.array {
            Array::F32(_) => write_dataset::<f32>(file, path, dataset, chunks, compression)?,
            Array::F64(_) => write_dataset::<f64>(file, path, dataset, chunks, compression)?,
            Array::Rounded(_) => write_dataset::<i16>(file, path, dataset, chunks, compression)?,
            Array::U32(_) => write_dataset::<u32>(file, path, dataset, chunks, compression)?,
        };
        write_attributes(&dataset.attributes, &Target::Dataset(&created))?;
    }
    Ok(())
}

fn write_dataset<T: H5Type>(
    file: &H5File,
    path: &str,
    dataset: &Dataset,
    chunks: &[Vec<u8>],
    compression: Compression,
) -> rust_hdf5::Result<H5Dataset> {
    let mut chunk_shape = dataset.shape.clone();
    chunk_shape[0] = chunk_rows(dataset);
    let builder = file.new_dataset::<T>().shape(&dataset.shape);
    // libhdf5's tools stumble over an index of no chunks.
    if chunks.is_empty() {
        return builder.create(path.trim_start_matches('/'));
    }
    let created = builder
        .chunk(&chunk_shape)
        .filter_pipeline(pipeline(dataset.array.element_size(), compression))
        .create(path.trim_start_matches('/'))?;
    for (index, chunk) in chunks.iter().enumerate() {
        created.write_chunk_raw(index, chunk, 0)?;
    }
    Ok(created)
}

/// Elements along the first axis for one along the others.
fn row(dataset: &Dataset) -> usize {
    dataset.shape[1..].iter().product()
}

fn chunk_rows(dataset: &Dataset) -> usize {
    (CHUNK_ELEMENTS / row(dataset)).min(dataset.shape[0])
}

fn all_chunks(tree: &Tree, compression: Compression) -> std::io::Result<Chunks<'_>> {
    let datasets: Vec<_> = tree.datasets.iter().collect();
    let filtered =
        datasets.into_par_iter().map(|(path, dataset)| Ok((path.as_str(), chunks(dataset, compression)?)));
    filtered.collect()
}

/// The filtered chunks of a dataset; none if it has no rows.
fn chunks(dataset: &Dataset, compression: Compression) -> std::io::Result<Vec<Vec<u8>>> {
    if dataset.shape[0] == 0 {
        return Ok(Vec::new());
    }
    let element_size = dataset.array.element_size();
    let chunk_elements = chunk_rows(dataset) * row(dataset);
    let chunks = (0..dataset.array.len().div_ceil(chunk_elements)).into_par_iter().map(|index| {
        let mut bytes = dataset.array.le_bytes(index * chunk_elements, chunk_elements);
        // HDF5 stores the last chunk whole.
        bytes.resize(chunk_elements * element_size, 0);
        filtered(&bytes, element_size, compression)
    });
    chunks.collect()
}

fn pipeline(element_size: usize, compression: Compression) -> FilterPipeline {
    let filter = |id, values: Vec<u32>| Filter { id, flags: 0, cd_values: values };
    let compressor = match compression {
        Compression::Zstd(level) => filter(32015, vec![level as u32]),
        Compression::Gzip(level) => filter(1, vec![level]),
    };
    FilterPipeline { filters: vec![filter(2, vec![element_size as u32]), compressor, filter(3, vec![])] }
}

fn filtered(chunk: &[u8], element_size: usize, compression: Compression) -> std::io::Result<Vec<u8>> {
    let shuffled = filters::shuffle(chunk, element_size);
    let mut out = match compression {
        Compression::Zstd(level) => filters::zstd(&shuffled, level)?,
        Compression::Gzip(level) => filters::deflate(&shuffled, level, element_size)?,
    };
    out.extend(filters::fletcher32(&out).to_le_bytes());
    Ok(out)
}

enum Target<'a> {
    Group(&'a H5Group),
    Dataset(&'a H5Dataset),
}

fn write_attributes(attributes: &Attributes, target: &Target) -> rust_hdf5::Result<()> {
    for (name, value) in attributes {
        match value {
            Value::Integer(v) => write_numbers(target, name, v)?,
            Value::Real(v) => write_numbers(target, name, v)?,
            Value::Text(text) => {
                let mut bytes = text.as_bytes().to_vec();
                bytes.push(0);
                let datatype = DatatypeMessage::fixed_string_utf8(bytes.len() as u32);
                match target {
                    Target::Group(group) => group.set_attr_typed(name, datatype, bytes)?,
                    Target::Dataset(dataset) => dataset.set_attr_typed(name, datatype, bytes)?,
                }
            }
        }
    }
    Ok(())
}

fn write_numbers<T: H5Type>(target: &Target, name: &str, values: &[T]) -> rust_hdf5::Result<()> {
    match (target, values) {
        (Target::Group(group), [value]) => group.set_attr_numeric(name, value),
        (Target::Group(group), _) => group.set_attr_array_numeric(name, values),
        (Target::Dataset(dataset), [value]) => {
            dataset.new_attr::<T>().shape(()).create(name)?.write_numeric(value)
        }
        (Target::Dataset(dataset), _) => {
            let attribute = dataset.new_attr::<T>().shape([values.len()]).create(name)?;
            attribute.write_array(values)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree() -> Tree {
        let root = Attributes::from([("name".to_owned(), Value::Text("a tree".into()))]);
        let array = Array::F32((0..3000).map(|i| i as f32).collect());
        let dataset = Dataset { shape: vec![1000, 3], array, attributes: Attributes::new() };
        Tree { groups: [(String::new(), root)].into(), datasets: [("/values".to_owned(), dataset)].into() }
    }

    #[test]
    fn a_temporary_folder_without_room_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing");
        let error = to_bytes(&tree(), Compression::default(), &missing).unwrap_err().to_string();
        let says = format!("passes through a file in the temporary folder {}", missing.display());
        assert!(error.contains(&says) && error.contains("TMPDIR"), "{error}");
    }

    #[test]
    fn there_is_room_for_all_that_is_written_and_more_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (tree, compression) = (tree(), Compression::Gzip(6));
        let bytes = to_bytes(&tree, compression, folder.path()).unwrap();
        let chunks = all_chunks(&tree, compression).unwrap();
        assert!(bytes.len() as u64 <= room(&tree, &chunks) && bytes.len() > chunks["/values"][0].len());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing stays");
        let file = tempfile::tempfile_in(folder.path()).unwrap();
        assert!(reserve(&file, 1 << 20).is_ok() && file.metadata().unwrap().len() == 0);
        #[cfg(target_os = "linux")]
        assert!(reserve(&file, 1 << 62).is_err());
    }
}
