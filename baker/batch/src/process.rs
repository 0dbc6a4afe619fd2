//! A worker as the batch sees it: a process with a pipe each way.

use super::job::{Job, Reply};
use super::memory::of_process;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::Sender;
use std::thread::JoinHandle;

/// The argument that makes the program a worker.
pub const WORKER: &str = "batch-worker";

/// Last bytes of a worker's standard error that are kept.
const KEPT_ERRORS: usize = 4096;

/// A reply of a worker, or its end.
pub enum Message {
    /// A reply.
    Reply(Reply),
    /// No more will come.
    End,
}

/// A running worker.
pub struct Worker {
    child: Child,
    input: Option<ChildStdin>,
    /// Reads its standard error.
    errors: Option<JoinHandle<String>>,
}

impl Worker {
    /// Starts `program batch-worker`. Its messages are sent with `number`.
    ///
    /// # Errors
    /// A program that can't be started.
    pub fn start(
        program: &Path,
        number: usize,
        sender: &Sender<(usize, Message)>,
    ) -> std::io::Result<Worker> {
        let mut command = Command::new(program);
        command.arg(WORKER).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Ctrl-C is for the batch, which ends its workers.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn()?;
        let (output, errors) = (child.stdout.take(), child.stderr.take());
        let sender = sender.clone();
        std::thread::spawn(move || {
            for line in output.into_iter().flat_map(|output| BufReader::new(output).lines()) {
                let reply = line.ok().and_then(|line| serde_json::from_str(&line).ok());
                if reply.is_none_or(|reply| sender.send((number, Message::Reply(reply))).is_err()) {
                    break;
                }
            }
            let _ = sender.send((number, Message::End));
        });
        let errors = std::thread::spawn(move || errors.map(tail).unwrap_or_default());
        Ok(Worker { input: child.stdin.take(), child, errors: Some(errors) })
    }

    /// Sends it a job. A worker that has ended sends [`Message::End`].
    pub fn send(&mut self, job: &Job) {
        let mut line = serde_json::to_vec(job).expect("plain data");
        line.push(b'\n');
        if let Some(input) = &mut self.input {
            let _ = input.write_all(&line).and_then(|()| input.flush());
        }
    }

    /// Memory that it has in use, bytes, where the system tells.
    pub fn memory(&self) -> Option<u64> {
        of_process(&self.child.id().to_string(), "VmRSS:")
    }

    /// Ends it at once, whatever it does.
    pub fn kill(&mut self) {
        let _ = self.child.kill();
    }

    /// How it ended, in words, and the end of its standard error.
    pub fn end(mut self) -> String {
        drop(self.input.take());
        let status = self.child.wait();
        let errors = self.errors.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        let errors = errors.trim();
        let how = status.map_or_else(|error| error.to_string(), describe);
        if errors.is_empty() { how } else { format!("{how}: {errors}") }
    }
}

/// No worker outlives its batch.
impl Drop for Worker {
    fn drop(&mut self) {
        self.kill();
        let _ = self.child.wait();
    }
}

fn tail(mut errors: impl Read) -> String {
    let mut kept = Vec::new();
    let mut block = [0; 1024];
    while let Ok(count @ 1..) = errors.read(&mut block) {
        kept.extend_from_slice(&block[..count]);
        kept.drain(..kept.len().saturating_sub(KEPT_ERRORS));
    }
    String::from_utf8_lossy(&kept).into_owned()
}

fn describe(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        let cause = match signal {
            9 => " (by the system, probably for want of memory: fewer jobs at once, or larger cells)",
            _ => "",
        };
        return format!("its worker was killed by signal {signal}{cause}");
    }
    format!("its worker ended with {status}")
}
