//! Figures of an earlier run in multiples of the kernel, as a JSON file.

use super::{kernel, report::Report};
use anyhow::{Context, Result, ensure};
use lapidary_core::input::read_text;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, path::Path};

/// The baseline of this version.
const STORED: &str = include_str!("baseline.json");

/// Figures by name, in multiples of the kernel's time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// [`kernel::VERSION`] of the run.
    kernel: u32,
    /// Multiples by figure.
    pub figures: BTreeMap<String, f64>,
}

impl Baseline {
    /// The one that comes with this version.
    ///
    /// # Errors
    /// None, or the tests would fail.
    pub fn stored() -> Result<Self> {
        Self::parse(STORED)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, that is no baseline, or whose figures have another unit.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_text(path).with_context(|| format!("cannot read the baseline ({})", path.display()))?;
        Self::parse(&text)
            .with_context(|| format!("not a baseline; make one with bench --suite --save ({})", path.display()))
    }

    /// That of a run.
    pub fn of(report: &Report) -> Self {
        let figures = report.figures.iter().map(|figure| (figure.name.clone(), figure.kernels));
        Self { kernel: kernel::VERSION, figures: figures.collect() }
    }

    fn parse(text: &str) -> Result<Self> {
        let baseline: Self = serde_json::from_str(text)?;
        ensure!(
            baseline.kernel == kernel::VERSION,
            "its unit is kernel {}, this version has kernel {}",
            baseline.kernel,
            kernel::VERSION
        );
        let bad = baseline.figures.iter().find(|&(_, &kernels)| !(kernels > 0.0 && kernels.is_finite()));
        ensure!(bad.is_none(), "the figure {} is not above 0", bad.map_or("", |(name, _)| name));
        Ok(baseline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_no_baselines_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let message = |text: &str| {
            std::fs::write(&path, text).unwrap();
            crate::terminal::error_text(&Baseline::read(&path).unwrap_err())
        };
        let good = r#"{"kernel": 1, "figures": {"a: bake": 2.5}}"#;
        assert_eq!(Baseline::parse(good).unwrap().figures["a: bake"], 2.5);
        let bad = ["", "[]", "{}", "{\"kernel\": 1}", r#"{"kernel": 1, "figures": {"a": "b"}}"#];
        for text in bad {
            let message = message(text);
            assert!(message.starts_with("not a baseline") && message.contains("a.json"), "{message}");
        }
        assert!(message(&good.replace("1,", "77,")).contains("kernel 77"));
        for value in ["0", "-1"] {
            assert!(message(&good.replace("2.5", value)).contains("the figure a: bake is not above 0"));
        }
        let missing = Baseline::read(&folder.path().join("b.json")).unwrap_err().to_string();
        assert!(missing.contains("b.json"), "{missing}");
    }
}
