//! What a program does when the system has no memory left: a message with the cure and an exit code of its own, instead
//! of a crash. For programs, not for libraries.
//!
//! ```
//! #[global_allocator]
//! static ALLOCATOR: volmap_memory::Allocator = volmap_memory::Allocator;
//!
//! volmap_memory::tell("error: out of memory; take less\n")?;
//! volmap_memory::start_threads(Some(2)).expect("two threads");
//! # Ok::<(), std::io::Error>(())
//! ```

mod allocator;

pub use allocator::{Allocator, tell};

/// Exit code of a program that had no memory left.
pub const EXIT_CODE: u8 = 3;

/// The system refuses the threads of parallel loops: as a rule memory for their stacks.
#[derive(Debug, thiserror::Error)]
#[error(
    "the system refuses {}: {reason}; allow more memory (ulimit -v) or processes (ulimit -u), or take fewer threads \
     (--threads)",
    threads.map_or("a thread for each processor".to_owned(), |count| format!("{count} threads"))
)]
pub struct NoThreads {
    /// How many were asked for; none: one for each processor.
    pub threads: Option<usize>,
    /// What the system says.
    pub reason: String,
}

/// Starts the threads on which parallel loops run: so many, or one for each processor. To be called once, before the
/// first loop.
///
/// # Errors
/// [`NoThreads`]
pub fn start_threads(threads: Option<usize>) -> Result<(), NoThreads> {
    let started = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build_global();
    started.map_err(|error| NoThreads { threads, reason: error.to_string() })
}
