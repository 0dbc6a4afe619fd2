//! A file's content as plain data: groups with attributes, datasets with arrays, and their checksums.
//! `write` and `read` translate it to and from HDF5, `schema` gives it meaning.

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
    /// Indices and counts.
    U32(Vec<u32>),
}

impl Array {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Array::F32(v) => v.len(),
            Array::F64(v) => v.len(),
            Array::U32(v) => v.len(),
        }
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether no element is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        match self {
            Array::F32(v) => v.iter().all(|x| x.is_finite()),
            Array::F64(v) => v.iter().all(|x| x.is_finite()),
            Array::U32(_) => true,
        }
    }

    /// Bytes of an element.
    pub fn element_size(&self) -> usize {
        match self {
            Array::F64(_) => 8,
            Array::F32(_) | Array::U32(_) => 4,
        }
    }

    /// The elements as little-endian bytes, as they stand in the file before any filter.
    pub fn to_le_bytes(&self) -> Vec<u8> {
        match self {
            Array::F32(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Array::F64(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Array::U32(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        }
    }

    fn type_name(&self) -> &'static str {
        match self {
            Array::F32(_) => "f32",
            Array::F64(_) => "f64",
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
        hasher.update(&self.array.to_le_bytes());
        hasher.finalize().to_hex().to_string()
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

    /// Path of the first object whose checksum doesn't match, root first.
    pub(crate) fn first_damage(&self) -> Option<String> {
        let stated =
            |attributes: &Attributes, actual: String| attributes.get(CHECKSUM) == Some(&Value::Text(actual));
        let root = self.groups.get("/");
        if !root.is_some_and(|root| stated(root, self.checksum())) {
            return Some("/".into());
        }
        let mut datasets = self.datasets.iter();
        datasets.find(|(_, d)| !stated(&d.attributes, d.checksum())).map(|(path, _)| path.clone())
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
