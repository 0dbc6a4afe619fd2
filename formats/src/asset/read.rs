//! HDF5 bytes into a [`Tree`]. The one file that knows the crate `hdf5-reader`.
//!
//! Nothing in the file is trusted: memory is bounded by the size of the file, and the tree's checksums are
//! compared before it is returned.

use super::error::{AssetError, printable};
use super::tree::{Array, Attributes, Dataset, Tree, Value};
use hdf5_reader::error::Error as Hdf5Error;
use hdf5_reader::filters::FilterRegistry;
use hdf5_reader::{Attribute, Datatype, Hdf5File, OpenOptions, dataset};

/// A chunk that our writer makes has at most 2^16 elements of 8 bytes.
const MAX_CHUNK_BYTES: usize = 1 << 20;
/// All datasets together, decoded, may be this many times as long as the file, and some more. Rows of equal values,
/// as floors and walls have, are compressed over a thousandfold.
const MAX_EXPANSION: usize = 4096;
const ALWAYS_ALLOWED_BYTES: usize = 1 << 24;
const MAX_OBJECT_HEADER_BYTES: usize = 1 << 20;
const ZSTD_FILTER: u16 = 32015;

/// Reads the groups (the root first) and datasets named, all of which must be there, and compares the
/// checksums. `check_root` sees the root's attributes before anything else is read.
///
/// # Errors
/// Bytes that aren't HDF5, objects that are missing or of another type, a checksum that doesn't match.
pub(super) fn read_tree(
    bytes: Vec<u8>,
    groups: &[&str],
    datasets: &[&str],
    check_root: impl Fn(&Attributes) -> Result<(), AssetError>,
) -> Result<Tree, AssetError> {
    let mut budget = bytes.len().saturating_mul(MAX_EXPANSION).saturating_add(ALWAYS_ALLOWED_BYTES);
    let file = Hdf5File::from_vec_with_options(bytes, options(budget)).map_err(container)?;
    let mut tree = Tree::default();
    for &path in groups {
        let group = match path {
            "/" => file.root_group(),
            _ => file.group(path),
        };
        let attributes = group.and_then(|g| g.attributes()).map_err(|error| object_error(path, error))?;
        if path == "/" {
            // A foreign or newer file may have attributes of other types: which it is comes first.
            let readable = attributes.iter().filter_map(|a| Some((a.name.clone(), value(a).ok()?)));
            check_root(&readable.collect())?;
        }
        let attributes = values(path, &attributes)?;
        tree.groups.insert(path.to_owned(), attributes);
    }
    for &path in datasets {
        let dataset = file.dataset(path).map_err(|error| object_error(path, error))?;
        tree.datasets.insert(path.to_owned(), read_dataset(path, &dataset, &mut budget)?);
    }
    match tree.first_damage() {
        Some(path) => Err(AssetError::Checksum(path)),
        None => Ok(tree),
    }
}

fn options(budget: usize) -> OpenOptions {
    let mut filters = FilterRegistry::new();
    let zstd = |_: &_, data: &[u8], _: usize| {
        zstd::bulk::decompress(data, MAX_CHUNK_BYTES)
            .map_err(|error| Hdf5Error::FilterError(format!("zstd: {error}")))
    };
    filters.register(ZSTD_FILTER, Box::new(zstd));
    OpenOptions::default()
        .with_filter_registry(filters)
        .with_max_chunk_bytes(MAX_CHUNK_BYTES)
        .with_max_read_bytes(budget)
        .with_max_object_header_bytes(MAX_OBJECT_HEADER_BYTES)
}

fn container(error: Hdf5Error) -> AssetError {
    match error {
        Hdf5Error::InvalidMagic => AssetError::NotHdf5,
        other => AssetError::Container(printable(&other.to_string())),
    }
}

fn object_error(path: &str, error: Hdf5Error) -> AssetError {
    match error {
        Hdf5Error::GroupNotFound(_) | Hdf5Error::DatasetNotFound(_) => AssetError::Missing(path.into()),
        other => AssetError::Container(printable(&format!("{path}: {other}"))),
    }
}

fn values(path: &str, attributes: &[Attribute]) -> Result<Attributes, AssetError> {
    let named = |attribute: &Attribute| {
        let value = value(attribute).map_err(|reason| {
            AssetError::invalid(format!("{path}@{}", printable(&attribute.name)), printable(&reason))
        })?;
        Ok((attribute.name.clone(), value))
    };
    attributes.iter().map(named).collect()
}

fn value(attribute: &Attribute) -> Result<Value, String> {
    let text = |error: Hdf5Error| format!("can't be read ({error})");
    match attribute.datatype {
        Datatype::FixedPoint { signed: false, size: 8, .. } => attribute.read_1d().map(Value::Integer),
        Datatype::FloatingPoint { size: 8, .. } => attribute.read_1d().map(Value::Real),
        Datatype::String { .. } => attribute.read_string().map(Value::Text),
        _ => return Err("is neither u64, f64 nor text".into()),
    }
    .map_err(text)
}

fn read_dataset(path: &str, dataset: &dataset::Dataset, budget: &mut usize) -> Result<Dataset, AssetError> {
    let too_large = || AssetError::invalid(path, "claims more data than a file of this size can hold");
    let shape: Vec<usize> = dataset.shape().iter().map(|&n| n as usize).collect();
    let count = shape.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
    let element_size = match dataset.dtype() {
        Datatype::FloatingPoint { size: 8, .. } => 8,
        _ => 4,
    };
    let bytes = count.and_then(|n| n.checked_mul(element_size)).ok_or_else(too_large)?;
    *budget = budget.checked_sub(bytes).ok_or_else(too_large)?;
    let failed = |error: Hdf5Error| AssetError::Container(printable(&format!("{path}: {error}")));
    let array = match dataset.dtype() {
        Datatype::FloatingPoint { size: 4, .. } => Array::F32(elements(dataset).map_err(failed)?),
        Datatype::FloatingPoint { size: 8, .. } => Array::F64(elements(dataset).map_err(failed)?),
        Datatype::FixedPoint { size: 4, signed: false, .. } => Array::U32(elements(dataset).map_err(failed)?),
        _ => return Err(AssetError::invalid(path, "is neither f32, f64 nor u32")),
    };
    let attributes = values(path, &dataset.attributes())?;
    Ok(Dataset { array, shape, attributes })
}

fn elements<T: hdf5_reader::H5Type>(dataset: &dataset::Dataset) -> Result<Vec<T>, Hdf5Error> {
    Ok(dataset.read_array::<T>()?.into_raw_vec_and_offset().0)
}
