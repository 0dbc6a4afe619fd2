//! Attributes of an asset's bake, read back. Errors are the name of the attribute that no bake writes like this.

use volmap_formats::asset::{Attributes, Value};

/// Several numbers; none if the asset doesn't say.
pub(crate) fn reals<const N: usize>(
    bake: &Attributes,
    name: &'static str,
) -> Result<Option<[f64; N]>, &'static str> {
    match bake.get(name) {
        None => Ok(None),
        Some(Value::Real(list)) => list.as_slice().try_into().map(Some).map_err(|_| name),
        Some(_) => Err(name),
    }
}

/// One number.
pub(crate) fn real(bake: &Attributes, name: &'static str) -> Result<Option<f64>, &'static str> {
    reals(bake, name).map(|found| found.map(|[x]| x))
}

/// A text.
pub(crate) fn text<'a>(bake: &'a Attributes, name: &'static str) -> Result<Option<&'a str>, &'static str> {
    match bake.get(name) {
        None => Ok(None),
        Some(Value::Text(text)) => Ok(Some(text)),
        Some(_) => Err(name),
    }
}

/// True or false.
pub(crate) fn flag(bake: &Attributes, name: &'static str) -> Result<Option<bool>, &'static str> {
    match bake.get(name) {
        None => Ok(None),
        Some(Value::Integer(list)) if list.as_slice() == [0] => Ok(Some(false)),
        Some(Value::Integer(list)) if list.as_slice() == [1] => Ok(Some(true)),
        Some(_) => Err(name),
    }
}
