//! Storage of finished rows of the operator, for resuming an interrupted computation.

use super::gather::Row;
use crate::errors::{BakeError, CheckpointError, ShardError};

/// Stores the rows of finished steps.
pub trait KeepsRows {
    /// The rows of a step, if it was finished with this number of rows, over `senders` functions.
    fn load_rows(&self, step: usize, rows: usize, senders: usize) -> Option<Vec<Row>>;

    /// Stores the rows of a step.
    fn store_rows(&self, step: usize, rows: &[Row]) -> Result<(), CheckpointError>;

    /// Whether a step of the finest level is needed here, computed or read. Coarser levels are always needed in full.
    fn has(&self, _step: usize) -> bool {
        true
    }

    /// Checks that a missing step may be computed.
    ///
    /// # Errors
    /// The share that should have it.
    fn may_make(&self, _step: usize) -> Result<(), ShardError> {
        Ok(())
    }
}

/// Stores nothing.
pub struct Forget;

impl KeepsRows for Forget {
    fn load_rows(&self, _: usize, _: usize, _: usize) -> Option<Vec<Row>> {
        None
    }

    fn store_rows(&self, _: usize, _: &[Row]) -> Result<(), CheckpointError> {
        Ok(())
    }
}

/// The rows of a step over `senders` functions: stored ones, or computed and then stored.
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
