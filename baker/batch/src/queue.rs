//! The job queue: which asset is next, and with how many threads. The longest comes first (Graham 1969: at most 4/3 of
//! the shortest time). Each gets one thread as long as there is enough other work; one that would outlast its share of
//! what is left gets more.

use super::job::Cost;

/// Jobs that wait, and the threads and memory that are free.
#[derive(Clone, Debug)]
pub struct JobQueue {
    /// Index and cost, the next one last.
    waiting: Vec<(usize, Cost)>,
    threads: Budget,
    memory: Budget,
    jobs: usize,
    running: usize,
}

#[derive(Clone, Copy, Debug)]
struct Budget {
    all: u64,
    free: u64,
}

/// A job that may start now, with what it may use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assignment {
    /// Index of the asset.
    pub index: usize,
    /// Threads of the job.
    pub threads: usize,
    /// Estimated memory, bytes.
    pub memory: u64,
}

impl JobQueue {
    /// A queue of assets with these costs, by index. No cost may exceed the memory.
    pub fn new(costs: &[(usize, Cost)], jobs: usize, threads: usize, memory: u64) -> JobQueue {
        let mut waiting = costs.to_vec();
        waiting.sort_by(|(i, a), (j, b)| a.seconds.total_cmp(&b.seconds).then(j.cmp(i)));
        let budget = |all| Budget { all, free: all };
        JobQueue { waiting, threads: budget(threads as u64), memory: budget(memory), jobs, running: 0 }
    }

    /// The next job, if a slot, a thread and memory are free for it. It waits rather than let smaller ones pass.
    pub fn take(&mut self) -> Option<Assignment> {
        let &(index, cost) = self.waiting.last()?;
        if self.running == self.jobs || self.threads.free == 0 || cost.memory > self.memory.free {
            return None;
        }
        let left: f64 = self.waiting.iter().map(|(_, cost)| cost.seconds).sum();
        let share = (cost.seconds / left * self.threads.all as f64).ceil().max(1.0) as u64;
        let least = self.threads.all / self.jobs.min(self.running + self.waiting.len()) as u64;
        let threads = share.max(least).min(self.threads.free);
        self.waiting.pop();
        self.running += 1;
        self.threads.free -= threads;
        self.memory.free -= cost.memory;
        Some(Assignment { index, threads: threads as usize, memory: cost.memory })
    }

    /// A job is finished: its threads and memory are free again.
    pub fn release(&mut self, assignment: &Assignment) {
        self.running -= 1;
        self.threads.free += assignment.threads as u64;
        self.memory.free += assignment.memory;
    }

    /// Assets that still wait, the next one first.
    pub fn waiting(&self) -> impl Iterator<Item = usize> {
        self.waiting.iter().rev().map(|(index, _)| *index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cost(seconds: f64) -> Cost {
        Cost { seconds, memory: 1, file: 1 }
    }

    fn numbered(seconds: &[f64]) -> Vec<(usize, Cost)> {
        seconds.iter().map(|&s| cost(s)).enumerate().collect()
    }

    #[test]
    fn the_longest_come_first_and_take_more_threads_only_beyond_their_share() {
        let mut queue = JobQueue::new(&numbered(&[1.0, 9.0, 1.0, 1.0]), 2, 2, 100);
        let first = queue.take().unwrap();
        assert_eq!(
            (first.index, first.threads),
            (1, 2),
            "three quarters of the work would take longer alone"
        );
        assert_eq!(queue.take(), None);
        queue.release(&first);
        let (a, b) = (queue.take().unwrap(), queue.take().unwrap());
        assert_eq!((a.index, a.threads, b.index, b.threads), (0, 1, 2, 1));
        queue.release(&a);
        let last = queue.take().unwrap();
        assert_eq!((last.index, last.threads), (3, 1), "the other thread is taken");
    }

    #[test]
    fn one_job_has_all_threads() {
        let mut queue = JobQueue::new(&numbered(&[1.0; 8]), 1, 4, 100);
        assert_eq!(queue.take().unwrap().threads, 4);
        assert_eq!(queue.take(), None);
    }

    #[test]
    fn memory_is_kept() {
        let costs = [(0, Cost { memory: 60, ..cost(2.0) }), (1, Cost { memory: 50, ..cost(1.0) })];
        let mut queue = JobQueue::new(&costs, 2, 2, 100);
        let first = queue.take().unwrap();
        assert_eq!(queue.take(), None);
        assert_eq!(queue.waiting().collect::<Vec<_>>(), [1]);
        queue.release(&first);
        assert_eq!(queue.take().unwrap().index, 1);
    }

    proptest! {
        /// Whatever ends first: every job runs, and nothing is promised twice.
        #[test]
        fn budgets_hold(
            seconds in prop::collection::vec(0.0f64..10.0, 1..40), jobs in 1usize..6, threads in 1usize..9,
            picks in prop::collection::vec(any::<prop::sample::Index>(), 40),
        ) {
            let mut queue = JobQueue::new(&numbered(&seconds), jobs, threads, 5);
            let (mut running, mut done) = (Vec::new(), 0);
            for pick in picks {
                while let Some(first) = queue.take() {
                    prop_assert!(first.threads >= 1);
                    running.push(first);
                }
                prop_assert!(running.len() <= jobs.min(5));
                prop_assert!(running.iter().map(|job: &Assignment| job.threads).sum::<usize>() <= threads);
                if running.is_empty() {
                    break;
                }
                queue.release(&running.swap_remove(pick.index(running.len())));
                done += 1;
            }
            prop_assert_eq!(done, seconds.len());
        }
    }
}
