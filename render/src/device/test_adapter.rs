//! The adapter that tests share.

use super::{adapter::Room, compute::SharedDevice};
use crate::error::BackendError;
use std::sync::{
    Mutex, MutexGuard, PoisonError, TryLockError,
    atomic::{AtomicUsize, Ordering},
};

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

/// What `make` makes on an adapter, or `None`, said aloud, where there is no adapter and none is required. Two at a time: a software
/// adapter uses all cores for pixels, and one to compile.
pub fn on_adapter<T>(make: impl FnOnce() -> Result<T, BackendError>) -> Option<(MutexGuard<'static, ()>, T)> {
    static PLACES: [Mutex<()>; 2] = [Mutex::new(()), Mutex::new(())];
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let free = PLACES.iter().find_map(|place| match place.try_lock() {
        Ok(guard) => Some(guard),
        Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    });
    let next = || PLACES[COUNT.fetch_add(1, Ordering::Relaxed) % 2].lock().unwrap_or_else(PoisonError::into_inner);
    let guard = free.unwrap_or_else(next);
    match make() {
        Ok(made) => Some((guard, made)),
        Err(error) if std::env::var_os("LAPIDARY_REQUIRE_GPU").is_none() => {
            eprintln!("SKIPPED: {error}");
            None
        }
        Err(error) => panic!("LAPIDARY_REQUIRE_GPU is set, but {error}"),
    }
}
