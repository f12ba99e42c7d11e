//! The figures of the meshless basis (Lehtinen et al. 2008: Table 1, Fig. 1, 3, 4 and 7) and of meshless radiosity (Zollhöfer and
//! Stamminger 2011: Table 1, Fig. 1, 5 and 6), measured anew on scenes with local lights.
//!
//! Fig. 6 of the former, any kind of surface, is the example `any_surface` of `precompute`.

mod pictures;
mod tables;

use super::{Measurement, cases::Case, notebook::Notebook};
use anyhow::Result;
use lapidary_core::dataset::Dataset;
use std::sync::Arc;

/// Measures all figures. Pictures show the first scene.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, cases: &[Case], notebook: &mut Notebook) -> Result<()> {
    let lit: Vec<(&Case, &Arc<Dataset>)> =
        cases.iter().filter_map(|case| Some((case, case.functions.as_ref()?))).collect();
    let Some(&(case, dataset)) = lit.first() else { return Ok(()) };
    measurement.steps.begin("meshless basis: Table 1");
    tables::record_basis(measurement, &lit, notebook)?;
    measurement.steps.begin("meshless basis: levels and functions");
    pictures::record_basis(measurement, case, dataset, notebook)?;
    measurement.steps.begin("meshless radiosity: Table 1");
    tables::record_radiosity(measurement, &lit, notebook)?;
    measurement.steps.begin("meshless radiosity: pictures");
    pictures::record_radiosity(measurement, case, dataset, notebook)
}
