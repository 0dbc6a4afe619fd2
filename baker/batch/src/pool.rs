//! The worker pool: gives jobs from a queue to worker processes, passes on their replies, and ends workers that take
//! too long or too much memory.

use super::job::{Job, REPORT_STEP, Reply, Task};
use super::process::{Message, Worker};
use super::queue::{Assignment, JobQueue};
use crate::error::Error;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};
use volmap_bake::watch::Cancel;

/// How often limits are checked.
const TICK: Duration = Duration::from_millis(50);
/// An idle worker with more memory than this is ended when others need it.
const IDLE_MEMORY: u64 = 64 << 20;

/// The workers of a batch.
pub struct WorkerPool<'a> {
    program: PathBuf,
    slots: Vec<Slot>,
    /// Memory of all workers together, bytes.
    max_memory: u64,
    messages: Receiver<(usize, Message)>,
    sender: Sender<(usize, Message)>,
    /// Number of the next worker.
    next: usize,
    cancel: &'a Cancel,
}

/// Room for one worker and its job.
#[derive(Default)]
struct Slot {
    /// Number of the worker, and the worker.
    worker: Option<(usize, Worker)>,
    job: Option<RunningJob>,
}

struct RunningJob {
    assignment: Assignment,
    /// When the part that is in work began.
    since: Instant,
    part: Part,
    limits: Limits,
    /// The last step that was told.
    step: String,
    /// Why its worker was ended.
    killed: Option<String>,
}

/// Seconds that the parts of a job may take; none: as long as they want.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Reading, baking, and measuring the error.
    pub bake: Option<f64>,
    /// The report, and writing the files.
    pub report: Option<f64>,
}

/// Part of a job.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Estimate,
    Bake,
    Report,
}

impl RunningJob {
    fn new(assignment: Assignment, job: &Job, limits: Limits) -> RunningJob {
        let part = if matches!(job.task, Task::Estimate(_)) { Part::Estimate } else { Part::Bake };
        RunningJob { assignment, since: Instant::now(), part, limits, step: String::new(), killed: None }
    }

    fn begin(&mut self, step: &str) {
        self.step = step.to_owned();
        if step == REPORT_STEP {
            (self.part, self.since) = (Part::Report, Instant::now());
        }
    }

    /// Why it is late, with the cure, if it is.
    fn lateness(&self) -> Option<String> {
        let limit = if self.part == Part::Report { self.limits.report } else { self.limits.bake };
        let limit = limit.filter(|limit| self.since.elapsed().as_secs_f64() > *limit)?;
        let step = if self.step.is_empty() { String::new() } else { format!(", while {}", self.step) };
        Some(match self.part {
            Part::Estimate => format!(
                "reading and examining it took longer than its timeout of {limit} s{step}; allow more by `timeout`"
            ),
            Part::Bake => format!(
                "its bake took longer than its timeout of {limit} s{step}; allow more by `timeout`, or take larger \
                 cells (`cell_size`)"
            ),
            Part::Report => format!(
                "its report took longer than its report_timeout of {limit} s; allow more by `report_timeout`, or do \
                 without it (report = false)"
            ),
        })
    }
}

/// Makes the jobs of a queue, and takes their results.
pub trait JobHandler {
    /// The job of an assignment, and the seconds that it may take.
    fn job(&mut self, assignment: &Assignment) -> (Job, Limits);
    /// A job starts in a slot.
    fn started(&mut self, _slot: usize, _assignment: &Assignment) {}
    /// A step of it starts.
    fn step(&mut self, _slot: usize, _assignment: &Assignment, _step: &str) {}
    /// It is finished, or its worker ended for this reason. Returns whether to go on.
    ///
    /// # Errors
    /// Those that end the batch.
    fn finished(
        &mut self,
        slot: usize,
        assignment: &Assignment,
        reply: Result<Reply, String>,
    ) -> Result<bool, Error>;
}

impl<'a> WorkerPool<'a> {
    /// A pool of so many slots; workers are started when they are needed.
    pub fn new(program: &Path, slots: usize, max_memory: u64, cancel: &'a Cancel) -> WorkerPool<'a> {
        let (sender, messages) = mpsc::channel();
        let slots = (0..slots).map(|_| Slot::default()).collect();
        WorkerPool { program: program.to_owned(), slots, max_memory, messages, sender, next: 0, cancel }
    }

    /// Runs the jobs of a queue until it is empty, `stop` is set, or the handler says no to more: running jobs are
    /// finished then.
    ///
    /// # Errors
    /// A worker that can't be started; the handler's.
    pub fn run(&mut self, queue: &mut JobQueue, handler: &mut dyn JobHandler) -> Result<(), Error> {
        let mut go_on = true;
        loop {
            while go_on && !self.cancel.is_cancelled() {
                let Some(assignment) = queue.take() else { break };
                self.start(assignment, handler)?;
            }
            if self.slots.iter().all(|slot| slot.job.is_none()) {
                return Ok(());
            }
            match self.messages.recv_timeout(TICK) {
                Ok((number, message)) => go_on &= self.receive(number, message, queue, handler)?,
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
            }
            if self.cancel.is_cancelled() {
                self.slots.iter_mut().for_each(|slot| *slot = Slot::default());
                return Ok(());
            }
            self.end_late();
            self.keep_memory();
        }
    }

    fn start(&mut self, assignment: Assignment, handler: &mut dyn JobHandler) -> Result<(), Error> {
        let slot = self.slots.iter().position(|slot| slot.job.is_none()).expect("as many slots as jobs");
        if self.slots[slot].worker.is_none() {
            let worker = Worker::start(&self.program, self.next, &self.sender)
                .map_err(|source| Error::io(&self.program, source))?;
            self.slots[slot].worker = Some((self.next, worker));
            self.next += 1;
        }
        let (job, limits) = handler.job(&assignment);
        handler.started(slot, &assignment);
        self.slots[slot].job = Some(RunningJob::new(assignment, &job, limits));
        if let Some((_, worker)) = &mut self.slots[slot].worker {
            worker.send(&job);
        }
        Ok(())
    }

    fn receive(
        &mut self,
        number: usize,
        message: Message,
        queue: &mut JobQueue,
        handler: &mut dyn JobHandler,
    ) -> Result<bool, Error> {
        let is_its = |slot: &Slot| slot.worker.as_ref().is_some_and(|(own, _)| *own == number);
        // Workers that were ended while idle still send their end.
        let Some(index) = self.slots.iter().position(is_its) else { return Ok(true) };
        let slot = &mut self.slots[index];
        let reply = match message {
            Message::Reply(Reply::Step(step)) => {
                if let Some(job) = &mut slot.job {
                    job.begin(&step);
                    handler.step(index, &job.assignment, &step);
                }
                return Ok(true);
            }
            Message::Reply(reply) => Ok(reply),
            Message::End => Err(slot.worker.take().map(|(_, worker)| worker.end()).unwrap_or_default()),
        };
        let Some(job) = slot.job.take() else { return Ok(true) };
        if job.killed.is_some() {
            // Its end may arrive later; the next job needs a new worker.
            slot.worker = None;
        }
        queue.release(&job.assignment);
        let reply = reply.map_err(|how| job.killed.unwrap_or(how));
        handler.finished(index, &job.assignment, reply)
    }

    /// Ends workers whose jobs take longer than their timeouts.
    fn end_late(&mut self) {
        for slot in &mut self.slots {
            let (Some(job), Some((_, worker))) = (&mut slot.job, &mut slot.worker) else { continue };
            if let (None, Some(why)) = (&job.killed, job.lateness()) {
                job.killed = Some(why);
                worker.kill();
            }
        }
    }

    /// If all workers together take too much memory, ends a large idle one, or the largest.
    fn keep_memory(&mut self) {
        let memory = |slot: &Slot| slot.worker.as_ref().and_then(|(_, worker)| worker.memory()).unwrap_or(0);
        let uses: Vec<u64> = self.slots.iter().map(memory).collect();
        if uses.iter().sum::<u64>() <= self.max_memory {
            return;
        }
        let idle = |(slot, uses): &(&mut Slot, &u64)| slot.job.is_none() && **uses > IDLE_MEMORY;
        if let Some((slot, _)) = self.slots.iter_mut().zip(&uses).find(idle) {
            slot.worker = None;
            return;
        }
        let largest = self.slots.iter_mut().zip(&uses).max_by_key(|(_, uses)| **uses);
        if let Some((Slot { job: Some(job), worker: Some((_, worker)) }, uses)) = largest {
            if job.killed.is_some() {
                return;
            }
            let (has, most) = (uses >> 20, self.max_memory >> 20);
            job.killed = Some(format!(
                "took {has} MiB when the batch had reached its limit of {most} MiB; fewer jobs at once, \
                 larger cells, or allow more"
            ));
            worker.kill();
        }
    }
}
