//! Figures measured so far, as a page and as a file of figures; both are complete documents after each figure.

use super::scale::MeasurementScale;
use crate::{
    report::{self, section},
    terminal::write_json,
};
use anyhow::{Context, Result};
use lapidary_core::output::write_atomically;
use maud::{Markup, html};
use serde::Serialize;
use serde_json::{Map, Value};
use std::{path::Path, time::Instant};

/// Name of the page.
pub const PAGE: &str = "evidence.html";
/// Name of the file of figures.
pub const FIGURES: &str = "evidence.json";

/// Conditions of the measurements.
#[derive(Clone, Debug, Serialize)]
pub struct Head {
    version: &'static str,
    threads: usize,
    environment: String,
    scenes: Vec<String>,
    scale: MeasurementScale,
}

impl Head {
    /// For this program on this machine.
    pub fn new(scale: &MeasurementScale, environment: &str, scenes: Vec<String>) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            environment: environment.into(),
            scenes,
            scale: *scale,
        }
    }
}

#[derive(Serialize)]
struct Contents<'a> {
    #[serde(flatten)]
    head: &'a Head,
    /// Whether all figures that were asked for are present.
    complete: bool,
    /// Wall-clock seconds so far.
    seconds: f64,
    figures: &'a Map<String, Value>,
}

/// Collects figures and writes them.
pub struct Notebook<'a> {
    out: &'a Path,
    head: Head,
    start: Instant,
    complete: bool,
    figures: Map<String, Value>,
    sections: Vec<Markup>,
}

impl<'a> Notebook<'a> {
    /// Starts an empty notebook in a folder and replaces an earlier one.
    ///
    /// # Errors
    /// An unwritable folder.
    pub fn new(out: &'a Path, head: Head) -> Result<Self> {
        let (figures, sections) = (Map::new(), Vec::new());
        let notebook = Self { out, head, start: Instant::now(), complete: false, figures, sections };
        notebook.write()?;
        Ok(notebook)
    }

    /// Whether it has no figure.
    pub fn is_empty(&self) -> bool {
        self.figures.is_empty()
    }

    /// Adds a figure: its name in the file of figures, its heading and markup on the page, and its numbers.
    ///
    /// # Errors
    /// An unwritable folder.
    pub fn record(&mut self, key: &str, heading: &str, body: Markup, numbers: &impl Serialize) -> Result<()> {
        self.figures.insert(key.into(), serde_json::to_value(numbers)?);
        self.sections.push(section(heading, body));
        self.write()
    }

    /// Marks the notebook as complete.
    ///
    /// # Errors
    /// An unwritable folder.
    pub fn finish(&mut self) -> Result<()> {
        self.complete = true;
        self.write()
    }

    /// Wall-clock seconds so far.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn write(&self) -> Result<()> {
        let Self { head, complete, figures, .. } = self;
        let contents = Contents { head, complete: *complete, seconds: self.seconds(), figures };
        write_json(&self.out.join(FIGURES), &contents)?;
        let Head { version, threads, .. } = head;
        let state = if *complete { "complete" } else { "not complete yet" };
        let line = format!("lapidary evidence, version {version}, {threads} threads, {:.0} s, {state}", self.seconds());
        let page = self.out.join(PAGE);
        write_atomically(&page, self.page(&line).as_bytes())
            .with_context(|| format!("cannot write the page; check the free space ({})", page.display()))
    }

    fn page(&self, line: &str) -> String {
        let intro = html! {
            div {
                h1 { "What the cuts cost, and what they save" }
                p {
                    "The figures of Cheslack-Postava, Wang, Akerlund and Pellacini, "
                    em { "Fast, Realistic Lighting and Material Design using Nonlinear Cut Approximation" }
                    " (SIGGRAPH Asia 2008), measured anew with this program, and the error against what a bake is set to; then those \
                     of Dong, Kautz, Theobalt and Seidel, "
                    em { "Interactive Global Illumination Using Implicit Visibility" }
                    " (Pacific Graphics 2007), of Lehtinen et al., "
                    em { "A Meshless Hierarchical Representation for Light Transport" }
                    " (SIGGRAPH 2008), and of Zollhöfer and Stamminger, "
                    em { "Meshless Radiosity on the GPU" }
                    " (2011). All numbers are in " a href="evidence.json" { "evidence.json" } "."
                }
            }
        };
        let sections: Vec<Markup> = std::iter::once(intro).chain(self.sections.iter().cloned()).collect();
        report::page("evidence", line, &sections)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_on_disk_before_the_next_begins() {
        let folder = tempfile::tempdir().unwrap();
        let mut notebook =
            Notebook::new(folder.path(), Head::new(MeasurementScale::QUICK, "studio", vec!["a".into()])).unwrap();
        let read =
            || -> Value { serde_json::from_slice(&std::fs::read(folder.path().join(FIGURES)).unwrap()).unwrap() };
        assert_eq!(read()["figures"], serde_json::json!({}));
        notebook.record("one", "One", html! { p { "first" } }, &[1, 2]).unwrap();
        assert_eq!((&read()["figures"]["one"][1], &read()["complete"]), (&2.into(), &false.into()));
        let page = || std::fs::read_to_string(folder.path().join(PAGE)).unwrap();
        assert!(page().contains("first") && page().contains("not complete"));
        notebook.finish().unwrap();
        assert_eq!(read()["complete"], true);
        assert!(!page().contains("not complete"));
        let file = folder.path().join(FIGURES);
        assert!(
            Notebook::new(&file, Head::new(MeasurementScale::QUICK, "studio", Vec::new())).is_err(),
            "a file is no folder"
        );
    }
}
