//! A [`Tree`] into HDF5 bytes. The one file that knows the crate `rust-hdf5`.
//!
//! The chunks are filtered here and handed over ready, so that the bytes depend on `zstd` and `flate2` only.
//! Text attributes are fixed-length UTF-8 with a trailing NUL: libhdf5's C API can't read that crate's
//! variable-length ones.

use super::error::AssetError;
use super::filters;
use super::read::read_tree;
use super::schema::asset_from_tree;
use super::tree::{Array, Attributes, Dataset, Tree, Value};
use rayon::prelude::*;
use rust_hdf5::{DatatypeMessage, Filter, FilterPipeline, H5Dataset, H5File, H5Group, H5Type};
use std::io::Read;
use std::path::Path;

/// How the datasets are compressed; both filters keep every bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// Zstandard (HDF5 filter 32015), level 1 to 22.
    Zstd(i32),
    /// gzip (HDF5 filter 1), level 1 to 9: for readers without plugins.
    Gzip(u32),
}

impl Default for Compression {
    /// Higher levels take far longer for little: `BENCHMARKS.md`.
    fn default() -> Self {
        Compression::Zstd(3)
    }
}

/// Elements of a chunk along its first axis times the other axes.
const CHUNK_ELEMENTS: usize = 1 << 16;

/// Writes to a scratch file and reads that back.
pub(super) fn encode(tree: &Tree, compression: Compression) -> Result<Vec<u8>, AssetError> {
    let bytes = to_bytes(tree, compression)?;
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

/// That crate writes files only: one in memory, where the system has such, else one in the temporary folder.
fn to_bytes(tree: &Tree, compression: Compression) -> Result<Vec<u8>, AssetError> {
    #[cfg(target_os = "linux")]
    if let Some((content, path)) = file_in_memory() {
        let file = H5File::create(path).map_err(asset_error)?;
        return written(file, content, tree, compression);
    }
    by_scratch_file(tree, compression, &std::env::temp_dir())
}

/// An empty file that no folder has, and the path by which it can be opened again.
#[cfg(target_os = "linux")]
fn file_in_memory() -> Option<(std::fs::File, std::path::PathBuf)> {
    use std::os::fd::AsRawFd;
    let file = rustix::fs::memfd_create("volmap", rustix::fs::MemfdFlags::CLOEXEC).ok()?;
    let file = std::fs::File::from(file);
    let path = std::path::PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()));
    path.exists().then_some((file, path))
}

/// The scratch file needn't outlast a power cut, nor leave the system's cache. It loses its name as soon as it is open, so
/// that killed programs leave nothing. (On Windows open files keep their names.)
fn by_scratch_file(tree: &Tree, compression: Compression, folder: &Path) -> Result<Vec<u8>, AssetError> {
    let in_folder = |error| match error {
        AssetError::Io(error) => AssetError::Io(std::io::Error::new(
            error.kind(),
            format!(
                "the asset passes through a file in the temporary folder {}, which has no room for it or can't be \
                 written to: {error}; make room there, or name another folder by TMPDIR",
                folder.display()
            ),
        )),
        other => other,
    };
    let write = || {
        let scratch = tempfile::Builder::new().prefix("volmap-").suffix(".h5").tempfile_in(folder)?;
        let file = H5File::create(scratch.path()).map_err(asset_error)?;
        let (content, name) = scratch.into_parts();
        #[cfg(unix)]
        name.close()?;
        let bytes = written(file, content, tree, compression);
        #[cfg(not(unix))]
        drop(name);
        bytes
    };
    write().map_err(in_folder)
}

/// Writes, and reads all of it by `content`, the same file.
fn written(
    file: H5File,
    mut content: std::fs::File,
    tree: &Tree,
    compression: Compression,
) -> Result<Vec<u8>, AssetError> {
    if let Err(error) = write_objects(&file, tree, compression) {
        // It would try again to finish the file when it is dropped, and print that this fails.
        std::mem::forget(file);
        return Err(asset_error(error));
    }
    file.close_no_sync().map_err(asset_error)?;
    let mut bytes = Vec::new();
    content.read_to_end(&mut bytes)?;
    Ok(bytes)
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

fn write_objects(file: &H5File, tree: &Tree, compression: Compression) -> rust_hdf5::Result<()> {
    for (path, attributes) in &tree.groups {
        let group = match path.trim_start_matches('/') {
            "" => file.root_group(),
            name => file.create_group(name)?,
        };
        write_attributes(attributes, &Target::Group(&group))?;
    }
    for (path, dataset) in &tree.datasets {
        let created = match &dataset.array {
            Array::F32(_) => write_dataset::<f32>(file, path, dataset, compression)?,
            Array::F64(_) => write_dataset::<f64>(file, path, dataset, compression)?,
            Array::Rounded(_) => write_dataset::<i16>(file, path, dataset, compression)?,
            Array::U32(_) => write_dataset::<u32>(file, path, dataset, compression)?,
        };
        write_attributes(&dataset.attributes, &Target::Dataset(&created))?;
    }
    Ok(())
}

fn write_dataset<T: H5Type>(
    file: &H5File,
    path: &str,
    dataset: &Dataset,
    compression: Compression,
) -> rust_hdf5::Result<H5Dataset> {
    let row: usize = dataset.shape[1..].iter().product();
    let rows = dataset.shape[0];
    let element_size = dataset.array.element_size();
    let chunk_rows = (CHUNK_ELEMENTS / row).min(rows);
    let mut chunk_shape = dataset.shape.clone();
    chunk_shape[0] = chunk_rows;
    let builder = file.new_dataset::<T>().shape(&dataset.shape);
    // libhdf5's tools stumble over an index of no chunks.
    if rows == 0 {
        return builder.create(path.trim_start_matches('/'));
    }
    let created = builder
        .chunk(&chunk_shape)
        .filter_pipeline(pipeline(element_size, compression))
        .create(path.trim_start_matches('/'))?;
    let chunk_elements = chunk_rows * row;
    let chunks = (0..dataset.array.len().div_ceil(chunk_elements)).into_par_iter().map(|index| {
        let mut bytes = dataset.array.le_bytes(index * chunk_elements, chunk_elements);
        // HDF5 stores the last chunk whole.
        bytes.resize(chunk_elements * element_size, 0);
        filtered(&bytes, element_size, compression)
    });
    for (index, chunk) in chunks.collect::<std::io::Result<Vec<_>>>()?.iter().enumerate() {
        created.write_chunk_raw(index, chunk, 0)?;
    }
    Ok(created)
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
        Compression::Gzip(level) => filters::deflate(&shuffled, level)?,
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
    fn a_file_in_memory_and_one_in_a_folder_are_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let compression = Compression::Gzip(6);
        let scratch = by_scratch_file(&tree(), compression, folder.path()).unwrap();
        assert_eq!(to_bytes(&tree(), compression).unwrap(), scratch);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing stays");
    }

    #[test]
    fn a_temporary_folder_without_room_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing");
        let error = by_scratch_file(&tree(), Compression::default(), &missing).unwrap_err().to_string();
        let says = format!("through a file in the temporary folder {}", missing.display());
        assert!(error.contains(&says) && error.contains("TMPDIR"), "{error}");
    }
}
