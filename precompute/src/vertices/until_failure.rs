//! A device that traces until it fails: then the cores go on, after one warning.

use crate::{
    observer::{Event, Observer},
    warning::Warning,
};
use std::sync::atomic::{AtomicBool, Ordering};

/// A device, unless there is none or it failed.
pub struct UntilFailure<'a, D> {
    device: Option<D>,
    has_failed: AtomicBool,
    observer: &'a dyn Observer,
}

impl<'a, D> UntilFailure<'a, D> {
    /// A device as it was made, if it could be.
    pub fn new(made: Result<Option<D>, String>, observer: &'a dyn Observer) -> Self {
        let mut device = Self { device: None, has_failed: AtomicBool::new(false), observer };
        match made {
            Ok(made) => device.device = made,
            Err(reason) => device.fail(reason),
        }
        device
    }

    /// Whether it traces, or did until it failed.
    pub fn has_traced(&self) -> bool {
        self.device.is_some()
    }

    /// The device, if it traces.
    pub fn get(&self) -> Option<&D> {
        self.device.as_ref().filter(|_| !self.has_failed.load(Ordering::Relaxed))
    }

    /// What `act` makes on the device; `None` leaves it to the cores.
    pub fn run<T>(&self, act: impl FnOnce(&D) -> Result<T, String>) -> Option<T> {
        act(self.get()?).map_err(|reason| self.fail(reason)).ok()
    }

    /// Says once why a device does not trace any more.
    fn fail(&self, reason: String) {
        if !self.has_failed.swap(true, Ordering::Relaxed) {
            self.observer.event(Event::Warning { message: Warning::DeviceFailed { reason } });
        }
    }
}
