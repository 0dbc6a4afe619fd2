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

/// Memory of a thread in bytes: its stack, as the standard library makes it, and what it keeps beside that.
const OF_A_THREAD: usize = (2 << 20) + (64 << 10);

/// Starts the threads on which parallel loops run: so many, or one for each processor. To be called once, before the
/// first loop.
///
/// # Errors
/// [`NoThreads`]
pub fn start_threads(threads: Option<usize>) -> Result<(), NoThreads> {
    // Asked for as a whole first: a thread that the system starts, but has no second stack for, ends in a panic.
    let count = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    if let Err(error) = Vec::<u8>::new().try_reserve_exact(count.saturating_mul(OF_A_THREAD)) {
        return Err(NoThreads { threads, reason: error.to_string() });
    }
    let started = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build_global();
    started.map_err(|error| NoThreads { threads, reason: error.to_string() })
}
