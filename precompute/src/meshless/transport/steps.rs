//! Keeping what is finished of the operator, so that an interrupted computation can go on.

use super::gather::Row;
use crate::errors::CheckpointError;

/// Keeps the rows of finished steps.
pub trait KeepsRows {
    /// The rows of a step, if it was finished with so many of them.
    fn load_rows(&self, step: usize, rows: usize) -> Option<Vec<Row>>;

    /// Keeps them.
    fn store_rows(&self, step: usize, rows: &[Row]) -> Result<(), CheckpointError>;
}

/// Keeps nothing.
pub struct Forget;

impl KeepsRows for Forget {
    fn load_rows(&self, _: usize, _: usize) -> Option<Vec<Row>> {
        None
    }

    fn store_rows(&self, _: usize, _: &[Row]) -> Result<(), CheckpointError> {
        Ok(())
    }
}

/// The rows of a step, made and stored unless they are kept already.
pub fn kept_or_made(
    kept: &dyn KeepsRows,
    step: usize,
    rows: usize,
    make: impl FnOnce() -> Vec<Row>,
) -> Result<Vec<Row>, CheckpointError> {
    if let Some(rows) = kept.load_rows(step, rows) {
        return Ok(rows);
    }
    let made = make();
    kept.store_rows(step, &made)?;
    Ok(made)
}
