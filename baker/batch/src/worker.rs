//! The process that makes assets, so that nothing that happens to one of them happens to the batch: it reads jobs from
//! its input and writes replies to its output, and ends when its input does, even in the middle of a job.

use super::cost::cost;
use super::job::{Job, Reply, Task};
use super::make::make;
use super::memory::of_process;
use crate::error::Error;
use std::io::{self, BufRead, Write};
use std::sync::mpsc;
use volmap_formats::asset::AssetError;

/// Works until there are no more jobs.
///
/// # Errors
/// An output that can't be written to; a line that is no job.
pub fn work(mut output: impl Write + Send) -> io::Result<()> {
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
        let reply = answer(&job, &mut |step| {
            // If nobody reads any more, the input has ended too.
            let _ = say(&mut output, &Reply::Step(step.to_owned()));
        });
        say(&mut output, &reply)?;
    }
    Ok(())
}

fn say(output: &mut impl Write, reply: &Reply) -> io::Result<()> {
    let mut line = serde_json::to_vec(reply)?;
    line.push(b'\n');
    output.write_all(&line)?;
    output.flush()
}

fn answer(job: &Job, on_step: &mut (dyn FnMut(&str) + Send)) -> Reply {
    let pool = match rayon::ThreadPoolBuilder::new().num_threads(job.threads).build() {
        Ok(pool) => pool,
        Err(error) => return Reply::Failed { error: error.to_string(), disk_full: false },
    };
    let done = pool.install(|| match &job.task {
        Task::Estimate(subject) => cost(subject, u64::MAX).map(Reply::Estimated),
        Task::Make(order) => make(order, on_step).map(|made| {
            let made = super::job::Made { peak_memory: of_process("self", "VmHWM:"), ..made };
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
