//! `lapidary evidence`: the figures of the paper's evaluation (Fig. 5, 6, 7 and 10), errors by bake settings, and the figures of
//! the meshless basis, of meshless radiosity, of wavelet transport and of implicit visibility, measured anew. The page and the
//! file of figures are rewritten after each figure.

mod cases;
mod clusters;
mod cube_map;
mod cut_sizes;
mod functions;
mod haar;
mod implicit;
mod ladders;
mod notebook;
mod scale;
mod sweeps;
mod table;
mod transport;
mod variants;
mod wavelets;

use crate::{
    args::OutsideArgs,
    bundled::DataFolder,
    outputs::{CommandFiles, take_folder},
    terminal::{Console, Outcome, Steps},
};
use anyhow::{Result, bail};
use cases::{Case, Plan};
use clap::{Args, ValueEnum};
use lapidary_core::environment::Environment;
use lapidary_interchange::{environment, formats::SceneFormat, image::file_and_layer};
use notebook::{Head, Notebook};
use scale::MeasurementScale;
use std::path::{Path, PathBuf};

/// Options of `evidence`.
#[derive(Args, Clone, Debug)]
pub struct EvidenceArgs {
    /// Folder for the pictures, evidence.json and evidence.html; it is created if missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Further scenes.
    #[arg(long, value_name = "FILE", num_args = 1.., help = format!("Further scenes: {}", SceneFormat::names()))]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    outside: OutsideArgs,
    /// Leave out the bundled scenes
    #[arg(long, requires = "scenes")]
    no_bundled: bool,
    /// Environment, as for `render`: a file, or constant:R,G,B, sun-sky:ELEVATION, studio or orientation
    #[arg(long, value_name = "MAP", default_value = "studio")]
    env: String,
    /// Measure the figures of these papers alone, separated by commas [default: all]
    #[arg(
        long,
        value_name = "PAPERS",
        value_enum,
        value_delimiter = ',',
        default_values_t = Paper::value_variants().to_vec(),
        hide_default_value = true
    )]
    papers: Vec<Paper>,
    /// Use few lights, vertices and pixels, to check in a minute that everything works; the figures mean little
    #[arg(long)]
    quick: bool,
    /// Folder with the bundled scenes [default: in the source tree]
    #[arg(long, value_name = "DIR", env = "LAPIDARY_DATA", hide_env_values = true)]
    data: Option<PathBuf>,
}

impl EvidenceArgs {
    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        let names = [
            notebook::PAGE,
            notebook::FIGURES,
            "fig5-*.png",
            "fig7-*.png",
            "implicit-*.png",
            "functions-*.png",
            "wavelet-*.png",
            "*-bounces.cuts",
            "*-functions.cuts",
        ];
        let environment = Some(file_and_layer(Path::new(&self.env)).0).filter(|path| path.is_file());
        CommandFiles::default().reads(environment).reads(&self.scenes).reads(&self.data).fills(&self.out, names)
    }
}

/// A paper whose figures are measured anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Paper {
    /// Visibility cuts (Cheslack-Postava et al. 2008)
    Cuts,
    /// The meshless hierarchical basis (Lehtinen et al. 2008)
    Meshless,
    /// Wavelet radiance transport (Kontkanen et al. 2006)
    Wavelet,
    /// Implicit visibility (Dong et al. 2007)
    Implicit,
}

/// Bakes, renders, traces, measures and writes the figures.
///
/// # Errors
/// An unwritable folder, unreadable scenes or data, or Ctrl-C; finished figures are kept.
pub fn run(args: &EvidenceArgs, console: Console) -> Result<Outcome> {
    let _taken = take_folder(&args.out)?;
    let scale = if args.quick { MeasurementScale::QUICK } else { MeasurementScale::FULL };
    let (environment, warnings) = environment::from_spec(&args.env)?;
    warnings.iter().for_each(|w| console.warning(w));
    let plans = scenes(args)?.iter().map(|path| Plan::read(path, &args.outside.into())).collect::<Result<Vec<_>>>()?;
    let plans = cases::named_apart(plans);
    let steps = Steps::new(console);
    let head = Head::new(scale, &args.env, plans.iter().map(|plan| plan.name.clone()).collect());
    let mut notebook = Notebook::new(&args.out, head)?;
    let (environment, papers) = (environment.into(), &args.papers);
    let measurement = Measurement { scale, environment, papers, steps: &steps, out: &args.out };
    let cases = plans.into_iter().map(|plan| measurement.bake(plan)).collect::<Result<Vec<_>>>()?;
    measurement.figures(&cases, &mut notebook)?;
    if notebook.is_empty() {
        bail!(
            "no scene has what these papers measure; give scenes with lamps, for the wavelet paper of quads, or other --papers"
        );
    }
    notebook.finish()?;
    console.summary(format_args!("{:.0} s; open {}", notebook.seconds(), args.out.join(notebook::PAGE).display()))?;
    Ok(Outcome::Done)
}

/// The bundled scenes and the given ones.
fn scenes(args: &EvidenceArgs) -> Result<Vec<PathBuf>> {
    let mut scenes = if args.no_bundled { Vec::new() } else { DataFolder::find(args.data.as_deref())?.scenes() };
    scenes.extend(args.scenes.iter().cloned());
    if scenes.is_empty() {
        bail!("there are no scenes to measure; give some with --scenes");
    }
    Ok(scenes)
}

/// Shared state of all figures.
struct Measurement<'a> {
    scale: &'static MeasurementScale,
    environment: std::sync::Arc<Environment>,
    papers: &'a [Paper],
    steps: &'a Steps,
    out: &'a std::path::Path,
}

impl Measurement<'_> {
    /// Whether the figures of any of these papers are measured.
    fn has(&self, papers: &[Paper]) -> bool {
        papers.iter().any(|paper| self.papers.contains(paper))
    }

    /// All figures in the papers' order, each written before the next begins.
    fn figures(&self, cases: &[Case], notebook: &mut Notebook) -> Result<()> {
        for paper in Paper::value_variants().iter().filter(|paper| self.papers.contains(paper)) {
            match paper {
                Paper::Cuts => self.figures_of_cuts(cases, notebook),
                Paper::Meshless => functions::record(self, cases, notebook),
                Paper::Wavelet => transport::record(self, cases, notebook),
                Paper::Implicit => implicit::record(self, cases, notebook),
            }?;
        }
        Ok(())
    }

    fn figures_of_cuts(&self, cases: &[Case], notebook: &mut Notebook) -> Result<()> {
        let open: Vec<_> = cases.iter().filter_map(|case| case.environment.as_ref().map(|e| (case, e))).collect();
        if let Some((case, bakes)) = open.first() {
            self.steps.begin("Fig. 5: clusters of the light tree");
            clusters::record(self, case, bakes, notebook)?;
            self.steps.begin("Fig. 6a: wavelets against cuts");
            wavelets::record(self, case, bakes, notebook)?;
            cut_sizes::record(&open, notebook)?;
        }
        self.steps.begin("Fig. 7: size of the illumination cut");
        let ladders = ladders::record(self, cases, notebook)?;
        self.steps.begin("Fig. 10: the table");
        table::record(self, cases, &ladders, notebook)?;
        if let Some((case, bakes)) = open.first() {
            let truth = ladders.iter().find(|ladder| ladder.of_environment_of(case)).map(|ladder| &ladder.truth);
            self.steps.begin("errors against beta, sigma, lights and vertices");
            sweeps::record(self, case, bakes, truth, notebook)?;
        }
        Ok(())
    }
}
