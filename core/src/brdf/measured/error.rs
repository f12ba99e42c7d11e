//! What is wrong with a measured BRDF.

use super::MEASURED_SIZE;
use thiserror::Error;

/// A table that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeasuredError {
    /// Too short for its head.
    #[error("it has {0} bytes, too few for a MERL BRDF; choose another file")]
    Short(u64),
    /// Another resolution.
    #[error(
        "its table is {} x {} x {}, not {} x {} x {} as MERL BRDFs have; choose another file", found[0], found[1], found[2],
        MEASURED_SIZE[0], MEASURED_SIZE[1], MEASURED_SIZE[2]
    )]
    Size {
        /// The numbers that the file begins with.
        found: [i32; 3],
    },
    /// Truncated, or with something after the table.
    #[error("it has {found} bytes instead of {expected}; get the file again")]
    Length {
        /// Bytes of the file.
        found: u64,
        /// Bytes of a table.
        expected: u64,
    },
    /// Something that is no reflectance.
    #[error("its entry {index} is {value}, which is no reflectance; get the file again")]
    Value {
        /// Which, from 0.
        index: usize,
        /// After its scale.
        value: f64,
    },
    /// Nothing was measured.
    #[error("all of its entries are negative, so nothing was measured; get the file again")]
    Empty,
}
