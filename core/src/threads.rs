//! Work on its own pool of threads, so that some of the machine is left to others.

/// Runs `work` with its parallel parts on `threads` threads, or on the shared pool if the system has no more threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pool_has_as_many_threads_as_asked_for() {
        assert_eq!(on_threads(3, rayon::current_num_threads), 3);
    }
}
