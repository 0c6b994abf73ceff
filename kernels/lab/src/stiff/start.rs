//! A measurement that is made once, when it is first needed.

use std::fmt;
use std::io;
use std::sync::{Mutex, PoisonError};

use raystep_scenes::Scene;

use super::{Cost, Kept, Wanted, measure, measure_scene};
use crate::Error;
use crate::meter::Meter;
use crate::reporter::Reporter;

type Append = Box<dyn FnMut(&'static str, &[u8]) -> io::Result<()> + Send>;

/// What to measure, what is finished, and where finished rows go.
pub struct Start {
    wanted: Wanted,
    state: Mutex<State>,
}

struct State {
    kept: Kept,
    append: Append,
    cost: Option<Cost>,
}

impl fmt::Debug for Start {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Start").field("wanted", &self.wanted).finish_non_exhaustive()
    }
}

impl Start {
    /// A measurement that has not begun; for `append` see [`measure`].
    pub fn new(
        wanted: Wanted,
        kept: Kept,
        append: impl FnMut(&'static str, &[u8]) -> io::Result<()> + Send + 'static,
    ) -> Self {
        Self { wanted, state: Mutex::new(State { kept, append: Box::new(append), cost: None }) }
    }

    /// The families, measured at the first call.
    ///
    /// # Errors
    /// If the device fails, or finished rows cannot be kept.
    pub fn cost(&self, meter: &Meter, reporter: &dyn Reporter) -> Result<Cost, Error> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { kept, append, cost } = &mut *state;
        if let Some(cost) = cost {
            return Ok(cost.clone());
        }
        let measured = measure(&self.wanted, std::mem::take(kept), meter, reporter, &mut **append)?;
        Ok(cost.insert(measured).clone())
    }

    /// Measures a scene of the user's.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn scene(
        &self,
        name: &str,
        scene: &Scene,
        meter: &Meter,
        reporter: &dyn Reporter,
    ) -> Result<Cost, Error> {
        let mut own = Cost::new(&self.wanted.run_id);
        measure_scene(&self.wanted, name, scene, meter, reporter, &mut own)?;
        Ok(own)
    }
}
