//! A file's content as plain data: groups with attributes, datasets with arrays, and their checksums.
//! `write` and `read` translate it to and from HDF5, `schema` gives it meaning.

use super::rounded::Rounded;
use std::collections::BTreeMap;

/// An attribute's value; arrays of one element are scalars in the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Unsigned integers (u64); truth values are 0 and 1.
    Integer(Vec<u64>),
    /// Real numbers (f64).
    Real(Vec<f64>),
    /// UTF-8 text.
    Text(String),
}

impl From<u64> for Value {
    fn from(value: u64) -> Value {
        Value::Integer(vec![value])
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Value {
        Value::Integer(vec![value.into()])
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Value {
        Value::Real(vec![value])
    }
}

impl From<[f64; 3]> for Value {
    fn from(value: [f64; 3]) -> Value {
        Value::Real(value.to_vec())
    }
}

impl From<[u32; 3]> for Value {
    fn from(value: [u32; 3]) -> Value {
        Value::Integer(value.map(u64::from).to_vec())
    }
}

impl From<&str> for Value {
    fn from(value: &str) -> Value {
        Value::Text(value.to_owned())
    }
}

impl From<String> for Value {
    fn from(value: String) -> Value {
        Value::Text(value)
    }
}

/// Attributes by name, sorted.
pub type Attributes = BTreeMap<String, Value>;

/// The numbers of a dataset.
#[derive(Clone, Debug, PartialEq)]
pub enum Array {
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
    /// 16-bit multiples of a step.
    Rounded(Rounded),
    /// Indices and counts.
    U32(Vec<u32>),
}

impl Array {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Array::F32(v) => v.len(),
            Array::F64(v) => v.len(),
            Array::Rounded(v) => v.multiples.len(),
            Array::U32(v) => v.len(),
        }
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The elements in double precision.
    pub fn to_f64(&self) -> Vec<f64> {
        match self {
            Array::F32(v) => v.iter().map(|&x| x.into()).collect(),
            Array::F64(v) => v.clone(),
            Array::Rounded(v) => v.values().collect(),
            Array::U32(v) => v.iter().map(|&x| x.into()).collect(),
        }
    }

    /// Whether no element is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        // Without an early end within a block, so that the compiler makes vector code of it.
        const BLOCK: usize = 1024;
        match self {
            Array::F32(v) => v.chunks(BLOCK).all(|part| part.iter().fold(true, |all, x| all & x.is_finite())),
            Array::F64(v) => v.chunks(BLOCK).all(|part| part.iter().fold(true, |all, x| all & x.is_finite())),
            Array::Rounded(v) => (v.step * f64::from(i16::MIN)).is_finite(),
            Array::U32(_) => true,
        }
    }

    /// Bytes of an element.
    pub fn element_size(&self) -> usize {
        match self {
            Array::F64(_) => 8,
            Array::F32(_) | Array::U32(_) => 4,
            Array::Rounded(_) => 2,
        }
    }

    /// The elements `first ..`, at most `count`, as little-endian bytes: as they stand in the file before any filter.
    #[cfg(feature = "write")]
    pub(super) fn le_bytes(&self, first: usize, count: usize) -> Vec<u8> {
        let part = first..self.len().min(first + count);
        let mut bytes = vec![0; part.len() * self.element_size()];
        match self {
            Array::F32(v) => to_le_bytes(&v[part], f32::to_le_bytes, &mut bytes),
            Array::F64(v) => to_le_bytes(&v[part], f64::to_le_bytes, &mut bytes),
            Array::Rounded(v) => to_le_bytes(&v.multiples[part], i16::to_le_bytes, &mut bytes),
            Array::U32(v) => to_le_bytes(&v[part], u32::to_le_bytes, &mut bytes),
        }
        bytes
    }

    fn hash(&self, hasher: &mut blake3::Hasher) {
        match self {
            Array::F32(v) => hash_elements(hasher, v, f32::to_le_bytes),
            Array::F64(v) => hash_elements(hasher, v, f64::to_le_bytes),
            Array::Rounded(v) => hash_elements(hasher, &v.multiples, i16::to_le_bytes),
            Array::U32(v) => hash_elements(hasher, v, u32::to_le_bytes),
        }
    }

    /// Type of the elements in the file: `f32`, `f64`, `i16` or `u32`.
    pub fn type_name(&self) -> &'static str {
        match self {
            Array::F32(_) => "f32",
            Array::F64(_) => "f64",
            Array::Rounded(_) => "i16",
            Array::U32(_) => "u32",
        }
    }
}

/// An array with its shape and attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct Dataset {
    /// The elements, last axis fastest.
    pub array: Array,
    /// Extent of each axis.
    pub shape: Vec<usize>,
    /// Units, description.
    pub attributes: Attributes,
}

impl Dataset {
    /// BLAKE3 of type, shape and elements, as 64 hexadecimal digits (`SPEC.md`, "Checksums").
    pub fn checksum(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.array.type_name().as_bytes());
        for &extent in &self.shape {
            hasher.update(&(extent as u64).to_le_bytes());
        }
        self.array.hash(&mut hasher);
        hasher.finalize().to_hex().to_string()
    }

    /// Whether its checksum matches.
    pub(crate) fn is_sound(&self) -> bool {
        states(&self.attributes, self.checksum())
    }
}

/// A file's content; paths are absolute (`/`, `/grid`, `/fields/volume`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// Attributes by group.
    pub groups: BTreeMap<String, Attributes>,
    /// Datasets by path.
    pub datasets: BTreeMap<String, Dataset>,
}

/// Attribute of a dataset that holds its own checksum, and of the root that holds that of all attributes.
pub(crate) const CHECKSUM: &str = "blake3";
/// Attributes of a dataset of [`Array::Rounded`]. The name of the first is that of the CF conventions of netCDF,
/// whose readers apply it by themselves.
pub(crate) const STEP: &str = "scale_factor";
pub(crate) const MAX_ERROR: &str = "max_error";

impl Tree {
    /// BLAKE3 of all attributes of all groups and datasets but the root's own `blake3`, as 64 hexadecimal
    /// digits. As every dataset has its checksum in an attribute, this covers the whole content.
    pub fn checksum(&self) -> String {
        let mut objects: BTreeMap<&str, &Attributes> = BTreeMap::new();
        objects.extend(self.groups.iter().map(|(p, a)| (p.as_str(), a)));
        objects.extend(self.datasets.iter().map(|(p, d)| (p.as_str(), &d.attributes)));
        let mut hasher = blake3::Hasher::new();
        for (path, attributes) in objects {
            for (name, value) in attributes {
                if path == "/" && name == CHECKSUM {
                    continue;
                }
                hash_text(&mut hasher, path);
                hash_text(&mut hasher, name);
                hash_value(&mut hasher, value);
            }
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Sets the checksum of every dataset, then the root's.
    #[cfg(feature = "write")]
    pub(crate) fn seal(&mut self) {
        for dataset in self.datasets.values_mut() {
            let checksum = dataset.checksum();
            dataset.attributes.insert(CHECKSUM.into(), checksum.into());
        }
        let checksum = self.checksum();
        let root = self.groups.entry("/".into()).or_default();
        root.insert(CHECKSUM.into(), checksum.into());
    }

    /// Whether the root's checksum matches: every dataset's must be in an attribute already.
    pub(crate) fn has_sound_attributes(&self) -> bool {
        self.groups.get("/").is_some_and(|root| states(root, self.checksum()))
    }
}

fn states(attributes: &Attributes, checksum: String) -> bool {
    attributes.get(CHECKSUM) == Some(&Value::Text(checksum))
}

fn to_le_bytes<T: Copy, const N: usize>(elements: &[T], bytes_of: fn(T) -> [u8; N], out: &mut [u8]) {
    for (out, &element) in out.as_chunks_mut::<N>().0.iter_mut().zip(elements) {
        *out = bytes_of(element);
    }
}

fn hash_elements<T: Copy, const N: usize>(
    hasher: &mut blake3::Hasher,
    all: &[T],
    bytes_of: fn(T) -> [u8; N],
) {
    let mut bytes = vec![0; 1 << 16];
    for part in all.chunks(bytes.len() / N) {
        let bytes = &mut bytes[..part.len() * N];
        to_le_bytes(part, bytes_of, bytes);
        hasher.update(bytes);
    }
}

fn hash_text(hasher: &mut blake3::Hasher, text: &str) {
    hasher.update(&(text.len() as u64).to_le_bytes());
    hasher.update(text.as_bytes());
}

fn hash_value(hasher: &mut blake3::Hasher, value: &Value) {
    match value {
        Value::Integer(v) => {
            hasher.update(b"u");
            hasher.update(&(v.len() as u64).to_le_bytes());
            v.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
        }
        Value::Real(v) => {
            hasher.update(b"f");
            hasher.update(&(v.len() as u64).to_le_bytes());
            v.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
        }
        Value::Text(text) => {
            hasher.update(b"s");
            hash_text(hasher, text);
        }
    }
}
