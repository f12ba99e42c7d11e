//! Keeps finished rows of the operator, so that an interrupted computation can resume.

use super::gather::Row;
use crate::errors::{BakeError, CheckpointError, ShardError};

/// Keeps the rows of finished steps.
pub trait KeepsRows {
    /// The rows of a step, if it was finished with this number of rows. They link to `senders` functions.
    fn load_rows(&self, step: usize, rows: usize, senders: usize) -> Option<Vec<Row>>;

    /// Stores them.
    fn store_rows(&self, step: usize, rows: &[Row]) -> Result<(), CheckpointError>;

    /// Whether a step of the finest level is needed here, to be made or read. Finer levels follow from all coarser ones.
    fn has(&self, _step: usize) -> bool {
        true
    }

    /// Whether a step may be made that is not kept.
    ///
    /// # Errors
    /// What should have kept it.
    fn may_make(&self, _step: usize) -> Result<(), ShardError> {
        Ok(())
    }
}

/// Keeps nothing.
pub struct Forget;

impl KeepsRows for Forget {
    fn load_rows(&self, _: usize, _: usize, _: usize) -> Option<Vec<Row>> {
        None
    }

    fn store_rows(&self, _: usize, _: &[Row]) -> Result<(), CheckpointError> {
        Ok(())
    }
}

/// The rows of a step over `senders` functions: those kept, else made and stored.
pub fn kept_or_made(
    kept: &dyn KeepsRows,
    step: usize,
    rows: usize,
    senders: usize,
    make: impl FnOnce() -> Vec<Row>,
) -> Result<Vec<Row>, BakeError> {
    if let Some(rows) = kept.load_rows(step, rows, senders) {
        return Ok(rows);
    }
    kept.may_make(step)?;
    let made = make();
    kept.store_rows(step, &made)?;
    Ok(made)
}
