//! Long work, watched and stopped: one [`Watch`] for all of it.
//!
//! Whoever starts long work gives it a watch. The work tells each step when it begins, counts what is done of it, and
//! ends with [`Cancelled`] soon after it was asked to stop: it looks once per row, block or point, never in the
//! innermost loops. A watch never changes a result.
//!
//! ```
//! use volmap_bake::watch::{Cancelled, Watch};
//!
//! fn add_up(rows: &[Vec<f64>], watch: &Watch) -> Result<f64, Cancelled> {
//!     let work = watch.begin("adding up", rows.len() as u64)?;
//!     let mut sum = 0.0;
//!     for row in rows {
//!         work.check()?;
//!         sum += row.iter().sum::<f64>();
//!         work.add(1);
//!     }
//!     Ok(sum)
//! }
//!
//! let watch = Watch::new(|step| println!("{}", step.name));
//! assert_eq!(add_up(&[vec![1.0, 2.0]], &watch), Ok(3.0));
//! watch.cancel().cancel();
//! assert_eq!(add_up(&[vec![1.0, 2.0]], &watch), Err(Cancelled));
//! ```

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Long work ended because it was asked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// A request to stop, which can be made from any thread. Clones are the same request, and it can't be taken back.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether that was asked for.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// An error if it was.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// The request is made by setting the flag, which is all that a signal handler may do.
impl From<Arc<AtomicBool>> for Cancel {
    fn from(flag: Arc<AtomicBool>) -> Cancel {
        Cancel(flag)
    }
}

/// A step of long work, as it begins.
#[derive(Clone, Debug)]
pub struct Step {
    /// What is done, as "sampling the distance".
    pub name: &'static str,
    /// How far it is, if it counts. It can be read at any time and from any thread.
    pub work: Option<Work>,
}

/// Units of work of a step, and how many are done. Clones count together.
#[derive(Clone, Debug, Default)]
pub struct Work {
    total: u64,
    done: Arc<AtomicU64>,
    cancel: Cancel,
}

impl Work {
    /// All units.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Units done so far.
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Counts units as done.
    pub fn add(&self, units: u64) {
        self.done.fetch_add(units, Ordering::Relaxed);
    }

    /// Whether to stop: what was not done then is never used.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// An error if the work was asked to stop.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        self.cancel.check()
    }
}

type OnStep = dyn Fn(&Step) + Send + Sync;

/// Who is told of the steps of long work, and may stop it. The default is nobody.
#[derive(Clone, Default)]
pub struct Watch {
    on_step: Option<Arc<OnStep>>,
    cancel: Cancel,
}

impl Watch {
    /// Calls `on_step` at the beginning of each step, on the thread that does the work.
    pub fn new(on_step: impl Fn(&Step) + Send + Sync + 'static) -> Watch {
        Watch { on_step: Some(Arc::new(on_step)), cancel: Cancel::default() }
    }

    /// The same, stopped by a request that is made elsewhere.
    pub fn stopped_by(self, cancel: &Cancel) -> Watch {
        Watch { cancel: cancel.clone(), ..self }
    }

    /// The same, with `on_step` told first of each step.
    pub fn also(&self, on_step: impl Fn(&Step) + Send + Sync + 'static) -> Watch {
        let before = self.on_step.clone();
        let both = move |step: &Step| {
            on_step(step);
            before.iter().for_each(|before| before(step));
        };
        Watch { on_step: Some(Arc::new(both)), cancel: self.cancel.clone() }
    }

    /// The same for a part of the work whose steps are not told.
    pub fn silent(&self) -> Watch {
        Watch { on_step: None, cancel: self.cancel.clone() }
    }

    /// What stops the work. A clone of it can be kept.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// An error if the work was asked to stop.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        self.cancel.check()
    }

    /// A step begins that doesn't count.
    ///
    /// # Errors
    /// [`Cancelled`], before the step is told.
    pub fn step(&self, name: &'static str) -> Result<(), Cancelled> {
        self.tell(Step { name, work: None })
    }

    /// A step of so many units of work begins.
    ///
    /// # Errors
    /// [`Cancelled`], before the step is told.
    pub fn begin(&self, name: &'static str, total: u64) -> Result<Work, Cancelled> {
        let work = Work { total, done: Arc::default(), cancel: self.cancel.clone() };
        self.tell(Step { name, work: Some(work.clone()) })?;
        Ok(work)
    }

    fn tell(&self, step: Step) -> Result<(), Cancelled> {
        self.check()?;
        self.on_step.iter().for_each(|on_step| on_step(&step));
        Ok(())
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut out = f.debug_struct("Watch");
        out.field("tells", &self.on_step.is_some()).field("cancel", &self.cancel).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn steps_are_told_in_order_until_the_work_is_cancelled() {
        let names = Arc::new(Mutex::new(Vec::new()));
        let (first, second) = (names.clone(), names.clone());
        let outer = Watch::new(move |step| first.lock().unwrap().push((1, step.name)));
        let watch = outer.also(move |step| second.lock().unwrap().push((2, step.name)));
        watch.step("a").unwrap();
        let work = watch.begin("b", 3).unwrap();
        work.clone().add(2);
        assert_eq!((work.total(), work.done(), work.is_cancelled()), (3, 2, false));
        watch.silent().step("c").unwrap();
        outer.cancel().cancel();
        assert_eq!(
            (work.check(), watch.step("d"), watch.silent().check()),
            (Err(Cancelled), Err(Cancelled), Err(Cancelled))
        );
        assert_eq!(*names.lock().unwrap(), [(2, "a"), (1, "a"), (2, "b"), (1, "b")]);
    }

    #[test]
    fn a_flag_cancels_what_is_stopped_by_it() {
        let flag = Arc::new(AtomicBool::new(false));
        let watch = Watch::default().stopped_by(&flag.clone().into());
        assert_eq!(watch.check(), Ok(()));
        flag.store(true, Ordering::Relaxed);
        assert_eq!(watch.check(), Err(Cancelled));
    }
}
