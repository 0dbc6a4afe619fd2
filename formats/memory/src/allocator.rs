//! The system's allocator, which remembers when it had nothing to give, and what is said then.
//!
//! Rust ends a program without memory by an abort, and a hook for that isn't stable. So the abort's signal is caught:
//! its handler prints a message and ends the program, unless something else was the abort's cause.
//!
//! `unsafe` is needed twice: to be an allocator, and to handle a signal. The allocator passes every call on as it is.
//! The handler only reads two atomics and makes two system calls, as signals allow.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator, for `#[global_allocator]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Allocator;

/// Whether a call has failed. An abort after that comes from it, as nothing else here aborts.
static HAD_NOTHING: AtomicBool = AtomicBool::new(false);

#[inline]
fn noted(memory: *mut u8) -> *mut u8 {
    if memory.is_null() {
        HAD_NOTHING.store(true, Ordering::Relaxed);
    }
    memory
}

// SAFETY: every call goes to the system's allocator with what was given, and its answer comes back.
unsafe impl GlobalAlloc for Allocator {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        noted(unsafe { System.alloc(layout) })
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        noted(unsafe { System.alloc_zeroed(layout) })
    }

    #[inline]
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        noted(unsafe { System.realloc(memory, layout, size) })
    }

    #[inline]
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

/// Prints the message, which ends its line itself, when a program with this [`Allocator`] aborts after the system had
/// no memory left, and ends it with [`EXIT_CODE`](crate::EXIT_CODE). To be called once, first of all.
///
/// # Errors
/// A system that refuses the signal's handler.
#[cfg(unix)]
pub fn tell(message: &'static str) -> std::io::Result<()> {
    use signal_hook::{consts::SIGABRT, low_level};
    let at_abort = move || {
        if HAD_NOTHING.load(Ordering::Relaxed) {
            let _ = rustix::io::write(rustix::stdio::stderr(), message.as_bytes());
            low_level::exit(crate::EXIT_CODE.into());
        }
    };
    // SAFETY: the handler allocates nothing and locks nothing.
    unsafe { low_level::register(SIGABRT, at_abort) }.map(drop)
}

/// There is no such signal here: the program aborts as any other.
#[cfg(not(unix))]
pub fn tell(_: &'static str) -> std::io::Result<()> {
    Ok(())
}
