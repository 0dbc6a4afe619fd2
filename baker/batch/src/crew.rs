//! Workers at work: gives them assets by the schedule, hears what they say, ends those that take too long or too much.

use super::job::{Job, Reply};
use super::process::{Heard, Worker};
use super::schedule::{Schedule, Turn};
use crate::error::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

/// How often limits are looked at.
const TICK: Duration = Duration::from_millis(50);
/// An idle worker with more memory than this is ended when others need it.
const IDLE_MEMORY: u64 = 64 << 20;

/// The workers of a batch.
pub struct Crew<'a> {
    program: PathBuf,
    seats: Vec<Seat>,
    /// Memory of all workers together, bytes.
    max_memory: u64,
    heard: Receiver<(usize, Heard)>,
    mouth: Sender<(usize, Heard)>,
    /// Number of the next worker.
    next: usize,
    stop: &'a AtomicBool,
}

#[derive(Default)]
struct Seat {
    worker: Option<(usize, Worker)>,
    work: Option<Work>,
}

struct Work {
    turn: Turn,
    since: Instant,
    timeout: Option<f64>,
    /// Why the worker was ended.
    ended: Option<String>,
}

/// What a batch wants to know and has to say while its crew works.
pub trait Foreman {
    /// The job of a turn, and the seconds that it may take.
    fn job(&mut self, turn: &Turn) -> (Job, Option<f64>);
    /// A job begins in a seat.
    fn begun(&mut self, _seat: usize, _turn: &Turn) {}
    /// A step of it begins.
    fn step(&mut self, _seat: usize, _turn: &Turn, _step: &str) {}
    /// It is done, or its worker ended for this reason. Whether to go on.
    ///
    /// # Errors
    /// Those that end the batch.
    fn done(&mut self, seat: usize, turn: &Turn, reply: Result<Reply, String>) -> Result<bool, Error>;
}

impl<'a> Crew<'a> {
    /// Of so many seats; workers are started when they are needed.
    pub fn new(program: &Path, seats: usize, max_memory: u64, stop: &'a AtomicBool) -> Crew<'a> {
        let (mouth, heard) = mpsc::channel();
        let seats = (0..seats).map(|_| Seat::default()).collect();
        Crew { program: program.to_owned(), seats, max_memory, heard, mouth, next: 0, stop }
    }

    /// Works until all had their turn, or `stop` is set, or the foreman has enough: what is at work then is finished.
    ///
    /// # Errors
    /// A worker that can't be started; the foreman's.
    pub fn work(&mut self, schedule: &mut Schedule, foreman: &mut dyn Foreman) -> Result<(), Error> {
        let mut go_on = true;
        loop {
            while go_on && !self.stop.load(Ordering::Relaxed) {
                let Some(turn) = schedule.take() else { break };
                self.begin(turn, foreman)?;
            }
            if self.seats.iter().all(|seat| seat.work.is_none()) {
                return Ok(());
            }
            match self.heard.recv_timeout(TICK) {
                Ok((number, heard)) => go_on &= self.hear(number, heard, schedule, foreman)?,
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
            }
            if self.stop.load(Ordering::Relaxed) {
                self.seats.iter_mut().for_each(|seat| *seat = Seat::default());
                return Ok(());
            }
            self.watch();
        }
    }

    fn begin(&mut self, turn: Turn, foreman: &mut dyn Foreman) -> Result<(), Error> {
        let seat = self.seats.iter().position(|seat| seat.work.is_none()).expect("as many seats as jobs");
        if self.seats[seat].worker.is_none() {
            let worker = Worker::start(&self.program, self.next, &self.mouth)
                .map_err(|source| Error::io(&self.program, source))?;
            self.seats[seat].worker = Some((self.next, worker));
            self.next += 1;
        }
        let (job, timeout) = foreman.job(&turn);
        foreman.begun(seat, &turn);
        self.seats[seat].work = Some(Work { turn, since: Instant::now(), timeout, ended: None });
        if let Some((_, worker)) = &mut self.seats[seat].worker {
            worker.give(&job);
        }
        Ok(())
    }

    fn hear(
        &mut self,
        number: usize,
        heard: Heard,
        schedule: &mut Schedule,
        foreman: &mut dyn Foreman,
    ) -> Result<bool, Error> {
        let is_its = |seat: &Seat| seat.worker.as_ref().is_some_and(|(own, _)| *own == number);
        // Those that were ended while idle still say so.
        let Some(index) = self.seats.iter().position(is_its) else { return Ok(true) };
        let seat = &mut self.seats[index];
        let reply = match heard {
            Heard::Reply(Reply::Step(step)) => {
                if let Some(work) = &seat.work {
                    foreman.step(index, &work.turn, &step);
                }
                return Ok(true);
            }
            Heard::Reply(reply) => Ok(reply),
            Heard::End => Err(seat.worker.take().map(|(_, worker)| worker.end()).unwrap_or_default()),
        };
        let Some(work) = seat.work.take() else { return Ok(true) };
        if work.ended.is_some() {
            // Its end may be heard of later; the next job isn't for the dead.
            seat.worker = None;
        }
        schedule.finished(&work.turn);
        let reply = reply.map_err(|how| work.ended.unwrap_or(how));
        foreman.done(index, &work.turn, reply)
    }

    /// Ends what takes too long, and what takes the memory of all.
    fn watch(&mut self) {
        for seat in &mut self.seats {
            let (Some(work), Some((_, worker))) = (&mut seat.work, &mut seat.worker) else { continue };
            let Some(timeout) = work.timeout else { continue };
            if work.ended.is_none() && work.since.elapsed().as_secs_f64() > timeout {
                work.ended = Some(format!("took longer than its timeout of {timeout} s"));
                worker.kill();
            }
        }
        let memory = |seat: &Seat| seat.worker.as_ref().and_then(|(_, worker)| worker.memory()).unwrap_or(0);
        let uses: Vec<u64> = self.seats.iter().map(memory).collect();
        if uses.iter().sum::<u64>() <= self.max_memory {
            return;
        }
        let idle = |(seat, uses): &(&mut Seat, &u64)| seat.work.is_none() && **uses > IDLE_MEMORY;
        if let Some((seat, _)) = self.seats.iter_mut().zip(&uses).find(idle) {
            seat.worker = None;
            return;
        }
        let largest = self.seats.iter_mut().zip(&uses).max_by_key(|(_, uses)| **uses);
        if let Some((Seat { work: Some(work), worker: Some((_, worker)) }, uses)) = largest {
            if work.ended.is_some() {
                return;
            }
            let (has, most) = (uses >> 20, self.max_memory >> 20);
            work.ended = Some(format!(
                "took {has} MiB when the batch had reached its --max-memory of {most} MiB; fewer --jobs, larger cells, or allow more"
            ));
            worker.kill();
        }
    }
}
