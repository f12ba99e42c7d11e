//! The BRDFs that users wrote, as shaders have them: a module each, with names of its own, and what every model has.

use lapidary_core::brdf::{WIDE_LIGHT, Written};

/// What the names of a module begin with.
pub fn prefix(index: usize) -> String {
    format!("written_{index}_of_")
}

/// The module of one, and what every model has: `template` is `shaders/brdf_written.wgsl`.
pub fn text(written: &Written, index: usize, template: &str) -> String {
    // It was written once when it was read.
    let functions = written.wgsl(&prefix(index)).unwrap_or_default();
    let named =
        template.replace("written_N", &format!("written_{index}")).replace("WrittenN", &format!("Written{index}"));
    format!("\n{functions}\n{}", named.replace("WIDE_LIGHT", &format!("{WIDE_LIGHT:?}")))
}
