//! Errors of measured BRDFs.

use super::MEASURED_SIZE;
use thiserror::Error;

/// A table that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeasuredError {
    /// The file is shorter than its header.
    #[error("it has {0} bytes, too few for a MERL BRDF; choose another file")]
    Short(u64),
    /// The table has another resolution.
    #[error(
        "its table is {} x {} x {}, not {} x {} x {} as MERL BRDFs have; choose another file", found[0], found[1], found[2],
        MEASURED_SIZE[0], MEASURED_SIZE[1], MEASURED_SIZE[2]
    )]
    Size {
        /// The numbers at the start of the file.
        found: [i32; 3],
    },
    /// The file is truncated or has trailing bytes.
    #[error("it has {found} bytes instead of {expected}; get the file again")]
    Length {
        /// Bytes of the file.
        found: u64,
        /// Bytes of a table.
        expected: u64,
    },
    /// An entry is not a reflectance.
    #[error("its entry {index} is {value}, which is not a reflectance; get the file again")]
    Value {
        /// Index of the entry.
        index: usize,
        /// Value after scaling.
        value: f64,
    },
    /// No entry was measured.
    #[error("all of its entries are negative, so nothing was measured; get the file again")]
    Empty,
}
