//! Which asset next, and with how many threads: the longest first (Graham 1969: at most 4/3 of the shortest time), each
//! with one thread as long as there is enough other work, and one that would outlast its share of what is left with more.

use super::job::Cost;

/// What is waiting and what is free.
#[derive(Clone, Debug)]
pub struct Schedule {
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

/// An asset's turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Which.
    pub index: usize,
    /// With so many threads.
    pub threads: usize,
    /// Estimated memory, bytes.
    pub memory: u64,
}

impl Schedule {
    /// For assets of these costs. No cost may exceed the memory.
    pub fn new(costs: &[(usize, Cost)], jobs: usize, threads: usize, memory: u64) -> Schedule {
        let mut waiting = costs.to_vec();
        waiting.sort_by(|(i, a), (j, b)| a.seconds.total_cmp(&b.seconds).then(j.cmp(i)));
        let budget = |all| Budget { all, free: all };
        Schedule { waiting, threads: budget(threads as u64), memory: budget(memory), jobs, running: 0 }
    }

    /// Takes the next asset, if there are a job, a thread and memory for it. It waits rather than let smaller ones pass.
    pub fn take(&mut self) -> Option<Turn> {
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
        Some(Turn { index, threads: threads as usize, memory: cost.memory })
    }

    /// An asset is done.
    pub fn finished(&mut self, turn: &Turn) {
        self.running -= 1;
        self.threads.free += turn.threads as u64;
        self.memory.free += turn.memory;
    }

    /// Those that had no turn, in the order of their turns.
    pub fn rest(&self) -> impl Iterator<Item = usize> {
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
        let mut schedule = Schedule::new(&numbered(&[1.0, 9.0, 1.0, 1.0]), 2, 2, 100);
        let turn = schedule.take().unwrap();
        assert_eq!((turn.index, turn.threads), (1, 2), "three quarters of the work would take longer alone");
        assert_eq!(schedule.take(), None);
        schedule.finished(&turn);
        let (a, b) = (schedule.take().unwrap(), schedule.take().unwrap());
        assert_eq!((a.index, a.threads, b.index, b.threads), (0, 1, 2, 1));
        schedule.finished(&a);
        let last = schedule.take().unwrap();
        assert_eq!((last.index, last.threads), (3, 1), "the other thread is taken");
    }

    #[test]
    fn one_job_has_all_threads() {
        let mut schedule = Schedule::new(&numbered(&[1.0; 8]), 1, 4, 100);
        assert_eq!(schedule.take().unwrap().threads, 4);
        assert_eq!(schedule.take(), None);
    }

    #[test]
    fn memory_is_kept() {
        let costs = [(0, Cost { memory: 60, ..cost(2.0) }), (1, Cost { memory: 50, ..cost(1.0) })];
        let mut schedule = Schedule::new(&costs, 2, 2, 100);
        let first = schedule.take().unwrap();
        assert_eq!(schedule.take(), None);
        assert_eq!(schedule.rest().collect::<Vec<_>>(), [1]);
        schedule.finished(&first);
        assert_eq!(schedule.take().unwrap().index, 1);
    }

    proptest! {
        /// Whatever ends first: all have a turn, and nothing is promised twice.
        #[test]
        fn budgets_hold(
            seconds in prop::collection::vec(0.0f64..10.0, 1..40), jobs in 1usize..6, threads in 1usize..9,
            picks in prop::collection::vec(any::<prop::sample::Index>(), 40),
        ) {
            let mut schedule = Schedule::new(&numbered(&seconds), jobs, threads, 5);
            let (mut running, mut done) = (Vec::new(), 0);
            for pick in picks {
                while let Some(turn) = schedule.take() {
                    prop_assert!(turn.threads >= 1);
                    running.push(turn);
                }
                prop_assert!(running.len() <= jobs.min(5));
                prop_assert!(running.iter().map(|turn: &Turn| turn.threads).sum::<usize>() <= threads);
                if running.is_empty() {
                    break;
                }
                schedule.finished(&running.swap_remove(pick.index(running.len())));
                done += 1;
            }
            prop_assert_eq!(done, seconds.len());
        }
    }
}
