//! The worker process. It makes assets apart from the batch, so that a crash loses one asset only. It reads jobs from
//! its standard input, writes replies to its standard output, and ends when its input does, even in the middle of a
//! job.

use super::cost::cost;
use super::job::{Job, MakeResult, Reply, Task};
use super::make::make;
use super::memory::of_process;
use crate::error::Error;
use std::io::{self, BufRead, Write};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use volmap_bake::watch::Watch;
use volmap_formats::asset::AssetError;

/// Runs jobs until there are no more.
///
/// # Errors
/// An output that can't be written to; a line that is no job.
pub fn run(output: impl Write + Send + 'static) -> io::Result<()> {
    let output = Arc::new(Mutex::new(output));
    let told = output.clone();
    let watch = Watch::new(move |step| {
        // If nobody reads any more, the input has ended too.
        let _ = send(&told, &Reply::Step(step.name.to_owned()));
    });
    let (sender, jobs) = mpsc::channel();
    std::thread::spawn(move || {
        for line in io::stdin().lock().lines() {
            let Ok(line) = line else { break };
            if sender.send(line).is_err() {
                break;
            }
        }
        // Whoever wanted the asset is gone: files are made whole or not at all.
        std::process::exit(0);
    });
    for line in jobs {
        let job: Job = serde_json::from_str(&line)?;
        reset_peak_memory();
        send(&output, &answer(&job, &watch))?;
    }
    Ok(())
}

fn send(output: &Mutex<impl Write>, reply: &Reply) -> io::Result<()> {
    let mut output = output.lock().unwrap_or_else(PoisonError::into_inner);
    let mut line = serde_json::to_vec(reply)?;
    line.push(b'\n');
    output.write_all(&line)?;
    output.flush()
}

fn answer(job: &Job, watch: &Watch) -> Reply {
    let pool = match rayon::ThreadPoolBuilder::new().num_threads(job.threads).build() {
        Ok(pool) => pool,
        Err(error) => return Reply::Failed { error: error.to_string(), disk_full: false },
    };
    let done = pool.install(|| match &job.task {
        Task::Estimate(input) => cost(input, u64::MAX, watch).map(Reply::Estimated),
        Task::Make(task) => make(task, watch).map(|made| {
            let made = MakeResult { peak_memory: of_process("self", "VmHWM:"), ..made };
            Reply::Made(Box::new(made))
        }),
    });
    done.unwrap_or_else(|error| Reply::Failed { error: error.to_string(), disk_full: is_disk_full(&error) })
}

fn is_disk_full(error: &Error) -> bool {
    fn of(error: &AssetError) -> bool {
        match error {
            AssetError::Io(source) => is_full(source),
            AssetError::InFile { error, .. } => of(error),
            _ => false,
        }
    }
    match error {
        Error::Bake(volmap_bake::Error::Io { source, .. }) => is_full(source),
        Error::Bake(volmap_bake::Error::Asset(source)) => of(source),
        _ => false,
    }
}

fn is_full(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded)
}

/// Linux keeps the most memory that a process ever had, until it is told to begin anew.
fn reset_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
