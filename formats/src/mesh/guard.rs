//! The one place that contains panics: of libraries that parse untrusted bytes, or that simulate.
//!
//! The message of a contained panic goes into the error, not to stderr. The hook that does this is
//! installed once, passes every panic of other threads and other code on to the hook it found, and
//! is therefore invisible to them.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use super::error::MeshError;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs `reader`; a panic in it becomes [`MeshError::Panicked`].
pub(super) fn contain<T>(
    format: &'static str,
    reader: impl FnOnce() -> Result<T, MeshError>,
) -> Result<T, MeshError> {
    quietly(reader).unwrap_or_else(|message| Err(MeshError::Panicked { format, message }))
}

/// Runs what a library does; a panic in it becomes an error, its message. After one, nothing that `work` was
/// changing may be used.
///
/// # Errors
/// The message of the panic.
pub fn quietly<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    static INSTALL: Once = Once::new();
    INSTALL.call_once(|| {
        let previous = take_hook();
        set_hook(Box::new(move |info| {
            if !QUIET.get() {
                previous(info);
            }
        }));
    });
    let outer = QUIET.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    QUIET.set(outer);
    result.map_err(|panic| message(&*panic))
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic
        .downcast_ref::<&str>()
        .map(|text| text.to_string())
        .or_else(|| panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "no message".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_and_the_next_read_works() {
        let error = contain::<()>("OFF", || panic!("boom {}", 7)).unwrap_err();
        assert!(error.to_string().contains("boom 7"), "{error}");
        assert_eq!(contain("OFF", || Ok(3)).unwrap(), 3);
        assert!(!QUIET.get());
    }
}
