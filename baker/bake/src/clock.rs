//! Wall time of a bake's stages.

use crate::stage::Stage;
use crate::watch::Watch;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Seconds of each stage, in order. Clones are one clock.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clock(Arc<Mutex<Laps>>);

#[derive(Debug, Default)]
struct Laps {
    current: Option<(Stage, Instant)>,
    seconds: Vec<(&'static str, f64)>,
}

impl Clock {
    /// The same watch, whose steps the clock hears too.
    pub fn beside(&self, watch: &Watch) -> Watch {
        let clock = self.clone();
        watch.also(move |step| clock.enter(Stage::of(step.name)))
    }

    /// Ends the stage that runs.
    pub fn stop(&self) {
        self.enter(None);
    }

    /// Stages and their seconds so far.
    pub fn seconds(&self) -> Vec<(&'static str, f64)> {
        self.laps().seconds.clone()
    }

    /// Seconds of a stage so far.
    pub fn seconds_of(&self, stage: Stage) -> f64 {
        let laps = self.laps();
        laps.seconds.iter().find(|lap| lap.0 == stage.name()).map_or(0.0, |lap| lap.1)
    }

    fn enter(&self, next: Option<Stage>) {
        let now = Instant::now();
        let mut laps = self.laps();
        if let Some((stage, since)) = laps.current.take() {
            let seconds = (now - since).as_secs_f64();
            // A search goes through the stages several times.
            match laps.seconds.iter_mut().find(|lap| lap.0 == stage.name()) {
                Some(lap) => lap.1 += seconds,
                None => laps.seconds.push((stage.name(), seconds)),
            }
        }
        laps.current = next.map(|stage| (stage, now));
    }

    fn laps(&self) -> MutexGuard<'_, Laps> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_that_come_again_add_up() {
        let clock = Clock::default();
        let watch = clock.beside(&Watch::default());
        for stage in [Stage::Band, Stage::Volume, Stage::Band, Stage::Volume] {
            watch.step(stage.step()).unwrap();
        }
        clock.stop();
        let names: Vec<_> = clock.seconds().into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["band", "volume"]);
    }
}
