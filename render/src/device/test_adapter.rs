//! The adapter that tests share.

use super::{adapter::Room, compute::SharedDevice};
use crate::error::BackendError;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The device that tests share, and with it what they have compiled. A test that loses its device takes another.
///
/// # Errors
/// No adapter.
pub fn shared_device() -> Result<SharedDevice, BackendError> {
    static DEVICE: Mutex<Option<SharedDevice>> = Mutex::new(None);
    let mut device = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    let shared = match device.take() {
        Some(shared) => shared,
        None => SharedDevice::new(Room::Defaults)?,
    };
    Ok(device.insert(shared).clone())
}

/// What `make` makes on an adapter, or `None`, said aloud, where there is no adapter and none is required. One at a time: a software
/// adapter uses all cores by itself.
pub fn on_adapter<T>(make: impl FnOnce() -> Result<T, BackendError>) -> Option<(MutexGuard<'static, ()>, T)> {
    static ONE: Mutex<()> = Mutex::new(());
    let guard = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    match make() {
        Ok(made) => Some((guard, made)),
        Err(error) if std::env::var_os("LAPIDARY_REQUIRE_GPU").is_none() => {
            eprintln!("SKIPPED: {error}");
            None
        }
        Err(error) => panic!("LAPIDARY_REQUIRE_GPU is set, but {error}"),
    }
}
