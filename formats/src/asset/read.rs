//! HDF5 bytes into a [`Tree`]. The one file that knows the crate `hdf5-reader`.
//!
//! Nothing in the file is trusted: memory is bounded by the size of the file, and the tree's checksums are
//! compared before it is returned.

use super::error::{AssetError, printable};
use super::filters::{fletcher32, inflate, unshuffle};
use super::rounded::Rounded;
use super::tree::{Array, Attributes, Dataset, MAX_ERROR, STEP, Tree, Value};
use hdf5_reader::error::Error as Hdf5Error;
use hdf5_reader::filters::{self, FilterRegistry};
use hdf5_reader::{Attribute, Datatype, Hdf5File, OpenOptions, dataset};
use std::panic::resume_unwind;
use std::thread;

/// A chunk that our writer makes has at most 2^16 elements of 8 bytes.
const MAX_CHUNK_BYTES: usize = 1 << 20;
/// All datasets together, decoded, may be this many times as long as the file, and some more. Rows of equal values,
/// as floors and walls have, are compressed over a thousandfold.
const MAX_EXPANSION: usize = 4096;
const ALWAYS_ALLOWED_BYTES: usize = 1 << 24;
const MAX_OBJECT_HEADER_BYTES: usize = 1 << 20;
const ZSTD_FILTER: u16 = 32015;
/// A dataset that decodes to more is worth a thread of its own: where all processors are busy, one starts late.
const LARGE_BYTES: usize = 1 << 21;

/// Reads the groups named (the root first) and the datasets that `datasets` names, which sees the root's attributes
/// before anything else is read. All must be there; the checksums are compared.
///
/// # Errors
/// Bytes that aren't HDF5, objects that are missing or of another type, a checksum that doesn't match.
pub(super) fn read_tree<'a>(
    bytes: Vec<u8>,
    groups: &[&str],
    datasets: impl Fn(&Attributes) -> Result<Vec<&'a str>, AssetError>,
) -> Result<Tree, AssetError> {
    let mut budget = bytes.len().saturating_mul(MAX_EXPANSION).saturating_add(ALWAYS_ALLOWED_BYTES);
    let file = Hdf5File::from_vec_with_options(bytes, options(budget)).map_err(container)?;
    let mut tree = Tree::default();
    let mut listed = Vec::new();
    for &path in groups {
        let group = match path {
            "/" => file.root_group(),
            _ => file.group(path),
        };
        let attributes = group.and_then(|g| g.attributes()).map_err(|error| object_error(path, error))?;
        if path == "/" {
            // A foreign or newer file may have attributes of other types: which it is comes first.
            let readable = attributes.iter().filter_map(|a| Some((a.name.clone(), value(a).ok()?)));
            listed = datasets(&readable.collect())?;
        }
        let attributes = values(path, &attributes)?;
        tree.groups.insert(path.to_owned(), attributes);
    }
    let mut opened = Vec::new();
    for path in listed {
        let dataset = file.dataset(path).map_err(|error| object_error(path, error))?;
        check_size(path, &dataset, &mut budget)?;
        opened.push((path, dataset));
    }
    let read = read_datasets(&opened).into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut damaged = None;
    for ((path, _), (dataset, sound)) in opened.iter().zip(read) {
        if !sound && damaged.is_none() {
            damaged = Some(*path);
        }
        tree.datasets.insert((*path).to_owned(), dataset);
    }
    let damaged = if tree.has_sound_attributes() { damaged } else { Some("/") };
    damaged.map_or(Ok(tree), |path| Err(AssetError::Checksum(path.to_owned())))
}

fn options(budget: usize) -> OpenOptions {
    OpenOptions::default()
        .with_filter_registry(filter_registry())
        .with_max_chunk_bytes(MAX_CHUNK_BYTES)
        .with_max_read_bytes(budget)
        .with_max_object_header_bytes(MAX_OBJECT_HEADER_BYTES)
        // Each chunk is read once: copies for a second time would only take time.
        .with_chunk_cache_bytes(0)
}

/// The filters of `SPEC.md`, section 11, and no others. None returns more than a chunk may hold.
fn filter_registry() -> FilterRegistry {
    let mut registry = FilterRegistry::new();
    for id in [filters::FILTER_SZIP, filters::FILTER_NBIT, filters::FILTER_SCALEOFFSET] {
        let refuse =
            move |_: &_, _: &[u8], _: usize| Err(Hdf5Error::UnsupportedFilter(format!("filter id {id}")));
        registry.register(id, Box::new(refuse));
    }
    registry.register(
        ZSTD_FILTER,
        Box::new(|_, data, _| {
            zstd::bulk::decompress(data, MAX_CHUNK_BYTES)
                .map_err(|error| Hdf5Error::FilterError(format!("zstd: {error}")))
        }),
    );
    registry.register(
        filters::FILTER_DEFLATE,
        Box::new(|_, data, _| {
            let damaged = || Hdf5Error::FilterError("zlib: the chunk is damaged".into());
            inflate(data, MAX_CHUNK_BYTES).ok_or_else(damaged)
        }),
    );
    registry.register(
        filters::FILTER_SHUFFLE,
        Box::new(|_, data, element_size| {
            let partial = || Hdf5Error::FilterError("shuffle: not a whole number of elements".into());
            unshuffle(data, element_size).ok_or_else(partial)
        }),
    );
    registry.register(filters::FILTER_FLETCHER32, Box::new(|_, data, _| without_checksum(data)));
    registry
}

fn without_checksum(data: &[u8]) -> Result<Vec<u8>, Hdf5Error> {
    let Some((payload, stored)) = data.split_last_chunk() else {
        return Err(Hdf5Error::FilterError("data too short for Fletcher-32 checksum".into()));
    };
    let (expected, actual) = (u32::from_le_bytes(*stored), fletcher32(payload));
    match expected == actual {
        true => Ok(payload.to_vec()),
        false => Err(Hdf5Error::ChecksumMismatch { expected, actual }),
    }
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

fn check_size(path: &str, dataset: &dataset::Dataset, budget: &mut usize) -> Result<(), AssetError> {
    let too_large = || AssetError::invalid(path, "claims more data than a file of this size can hold");
    *budget = decoded_bytes(dataset).and_then(|bytes| budget.checked_sub(bytes)).ok_or_else(too_large)?;
    Ok(())
}

fn decoded_bytes(dataset: &dataset::Dataset) -> Option<usize> {
    let element_size = match dataset.dtype() {
        Datatype::FloatingPoint { size: 8, .. } => 8,
        Datatype::FixedPoint { size: 2, .. } => 2,
        _ => 4,
    };
    let axes = dataset.shape().iter();
    axes.map(|&n| usize::try_from(n).ok()).try_fold(element_size, |product: usize, n| product.checked_mul(n?))
}

type ReadDataset = Result<(Dataset, bool), AssetError>;

/// Reads each dataset, and tells whether its checksum matches. If they are large, the last, which is one of two
/// fields of equal length, is read on a second thread.
fn read_datasets(opened: &[(&str, dataset::Dataset)]) -> Vec<ReadDataset> {
    let read = |(path, dataset): &(&str, dataset::Dataset)| {
        let dataset = read_dataset(path, dataset)?;
        let sound = dataset.is_sound();
        Ok((dataset, sound))
    };
    let Some((last, others)) = opened.split_last() else { return Vec::new() };
    thread::scope(|scope| {
        let large = decoded_bytes(&last.1).is_none_or(|bytes| bytes >= LARGE_BYTES);
        let spawn = || thread::Builder::new().spawn_scoped(scope, || read(last)).ok();
        let second = if large { spawn() } else { None };
        let mut out: Vec<ReadDataset> = others.iter().map(read).collect();
        out.push(match second {
            Some(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
            None => read(last),
        });
        out
    })
}

fn read_dataset(path: &str, dataset: &dataset::Dataset) -> Result<Dataset, AssetError> {
    let failed = |error: Hdf5Error| AssetError::Container(printable(&format!("{path}: {error}")));
    let attributes = values(path, &dataset.attributes())?;
    let array = match dataset.dtype() {
        Datatype::FloatingPoint { size: 4, .. } => Array::F32(elements(dataset).map_err(failed)?),
        Datatype::FloatingPoint { size: 8, .. } => Array::F64(elements(dataset).map_err(failed)?),
        Datatype::FixedPoint { size: 4, signed: false, .. } => Array::U32(elements(dataset).map_err(failed)?),
        Datatype::FixedPoint { size: 2, signed: true, .. } => Array::Rounded(Rounded {
            step: real(path, &attributes, STEP)?,
            max_error: real(path, &attributes, MAX_ERROR)?,
            multiples: elements(dataset).map_err(failed)?,
        }),
        _ => return Err(AssetError::invalid(path, "is neither f32, f64, i16 nor u32")),
    };
    let shape = dataset.shape().iter().map(|&n| n as usize).collect();
    Ok(Dataset { array, shape, attributes })
}

fn real(path: &str, attributes: &Attributes, name: &str) -> Result<f64, AssetError> {
    let full_name = || format!("{path}@{name}");
    match attributes.get(name) {
        Some(Value::Real(v)) if v.len() == 1 => Ok(v[0]),
        Some(_) => Err(AssetError::invalid(full_name(), "isn't a real number")),
        None => Err(AssetError::Missing(full_name())),
    }
}

fn elements<T: hdf5_reader::H5Type>(dataset: &dataset::Dataset) -> Result<Vec<T>, Hdf5Error> {
    Ok(dataset.read_array::<T>()?.into_raw_vec_and_offset().0)
}
