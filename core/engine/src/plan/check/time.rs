//! Checks of a scene's times, steps and solver settings.

use super::Check;
use crate::scene::{Scene, SceneError};

/// Longest simulated time, s, about 30 years: the clock of devices counts nanoseconds in 64 bits.
const MAX_SECONDS: f64 = 1e9;
/// Largest number of steps of a run.
const MAX_STEPS: f64 = 1e9;

impl Check<'_> {
    pub(super) fn time(&self, scene: &Scene) -> Result<(), SceneError> {
        let (time, tolerance) = (&scene.time, &scene.solver.tolerance);
        let (dt, duration) = (time.dt.get_ref().si, time.duration.get_ref().si);
        self.above(dt, time.dt.span(), "dt", " s")?;
        self.above(duration, time.duration.span(), "duration", " s")?;
        self.above(time.patience.get_ref().si, time.patience.span(), "patience", " s")?;
        if let Some(sleep) = &time.sleep {
            self.above(sleep.get_ref().si, sleep.span(), "sleep", " m/s")?;
        }
        for (what, time) in [("dt", &time.dt), ("duration", &time.duration)] {
            if time.get_ref().si > MAX_SECONDS {
                let text = format!("{what} is {:e} s; allowed is {MAX_SECONDS:e} s at most", time.get_ref().si);
                return self.wrong(time.span(), text);
            }
        }
        if duration / dt > MAX_STEPS {
            let text = format!("dt is {dt:e} s, {:e} steps; allowed is {MAX_STEPS:e} steps at most", duration / dt);
            return self.wrong(time.dt.span(), text);
        }
        let most = *time.most_substeps.get_ref();
        for (what, count) in [("most-substeps", &time.most_substeps), ("iterations", &scene.solver.iterations)] {
            if *count.get_ref() == 0 {
                return self.wrong(count.span(), format!("{what} is 0; allowed is 1 or more"));
            }
        }
        if *time.substeps.get_ref() > most {
            let text = format!("substeps is {}; allowed is 0 to most-substeps, {most}", time.substeps.get_ref());
            return self.wrong(time.substeps.span(), text);
        }
        if !(0.0 < *tolerance.get_ref() && *tolerance.get_ref() < 1.0) {
            let text = format!("tolerance is {}; allowed is a number above 0 and below 1", tolerance.get_ref());
            return self.wrong(tolerance.span(), text);
        }
        let newton = &scene.solver.newton_tolerance;
        self.above(*newton.get_ref(), newton.span(), "newton-tolerance", "")?;
        if let Some(zero) = scene.solver.newton.as_ref().filter(|n| *n.get_ref() == 0) {
            return self.wrong(zero.span(), "newton is 0; allowed is 1 or more");
        }
        if scene.body.is_empty() { Err(self.0.whole("no [[body]]; a scene needs one at least")) } else { Ok(()) }
    }
}
