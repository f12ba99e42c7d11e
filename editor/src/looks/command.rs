//! `lapidary looks`, and `lapidary render` of a session.

use super::{Maps, PictureOfDocument, file_names};
use crate::{
    document::{
        Document,
        looks::NamedLook,
        session::{self, EXTENSION, SessionLook},
    },
    jobs::opening::{self, Consent, Opened, Ready, Target},
    paths::Folders,
    pose,
    preferences::Preferences,
    workspace::files_in_use,
};
use anyhow::{Context, Result, bail};
use clap::Args;
use lapidary_core::ground::Ground;
use lapidary_render::Baked;
use lapidary_studies::{
    args::{DeviceArgs, SMOOTH, check_memory},
    export::{Finished, LayerKind, Studio, check_pictures},
    outputs::CommandFiles,
    terminal::{Console, Outcome, print_out},
    values,
};
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

/// Options of `looks`.
#[derive(Args, Clone, Debug)]
pub struct LooksArgs {
    /// Session whose looks are listed
    #[arg(value_name = "FILE.lapidary")]
    file: PathBuf,
}

impl LooksArgs {
    /// Prints a line for each look: its name, and what it keeps.
    ///
    /// # Errors
    /// A session that cannot be read.
    pub fn run(&self, console: Console) -> Result<Outcome> {
        let loaded = session::load(&self.file)?;
        loaded.warnings.iter().for_each(|warning| console.warning(warning));
        if loaded.session.looks.is_empty() {
            console.note("the session has no looks; add one in the window, in the tab Looks");
        }
        let line = |look: &SessionLook| format!("{}: {}\n", look.name.escape_debug(), kept(look).join(", "));
        print_out(&loaded.session.looks.iter().map(line).collect::<String>())?;
        Ok(Outcome::Done)
    }
}

fn kept(look: &SessionLook) -> Vec<&'static str> {
    let parts = [
        ("materials", look.materials.is_some()),
        ("light", look.light.is_some()),
        ("camera", look.camera.is_some()),
        ("view", look.view.is_some()),
    ];
    parts.into_iter().filter_map(|(part, is_kept)| is_kept.then_some(part)).collect()
}

/// Options of `render` with a session.
#[derive(Args, Clone, Debug)]
pub struct RenderSessionArgs {
    /// Session to render
    #[arg(value_name = "FILE.lapidary")]
    file: PathBuf,
    /// Look to render, by its name [default: what the session shows]
    #[arg(long, value_name = "NAME")]
    look: Option<String>,
    /// Render all looks; the name of each is put before the extension of the files
    #[arg(long, conflicts_with = "look")]
    all: bool,
    /// Picture to write: .exr or .hdr (scene-linear), .png (as displayed); may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = values::size)]
    size: [u32; 2],
    /// Samples per pixel, 1 to 256, whatever the session says [default: 16, 64 through an open lens]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    aa: Option<u32>,
    #[command(flatten)]
    device: DeviceArgs,
}

impl RenderSessionArgs {
    /// Whether these arguments of the program render a session.
    pub fn are_meant(arguments: &[OsString]) -> bool {
        let mut words = arguments.iter().skip(1).filter(|word| !word.to_string_lossy().starts_with('-'));
        let is_session = |word: &OsString| {
            Path::new(word).extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
        };
        words.next().is_some_and(|command| command == "render") && words.any(is_session)
    }

    /// Renders the pictures.
    ///
    /// # Errors
    /// Files that cannot be read or written, a session without a bake, or a look that it does not have.
    pub fn run(&self, console: Console) -> Result<Outcome> {
        check_pictures(&self.out)?;
        check_memory(self.size, 1)?;
        let folders = Folders::find()?;
        let ready = self.open(&folders)?;
        ready.warnings.iter().for_each(|warning| console.warning(warning));
        let pictures = self.pictures(&ready.document)?;
        let outputs: Vec<&PathBuf> = pictures.iter().flat_map(|(_, outputs)| outputs).collect();
        let inputs = files_in_use(&ready.document);
        let bakes = [&ready.document.dataset, &ready.bake_output].into_iter().flatten();
        CommandFiles::default().reads([&self.file]).reads(inputs).reads(bakes).writes(outputs).check()?;
        if ready.is_draft {
            console.warning("the scene has only a draft of its bake; bake it in the window for exact shadows");
        }
        let shown = self.shown(ready)?;
        let (mut studio, mut maps) = (Studio::new(self.device.open()?, shown.baked.clone())?, Maps::default());
        for (look, outputs) in pictures {
            let picture = match look {
                Some(look) => shown.clone().with_look(&look.state),
                None => shown.clone(),
            };
            let look = picture.look(&mut maps)?;
            let finished = Finished::take(&mut studio, &look, &[LayerKind::Beauty], &|| false)?;
            studio.remarks().iter().for_each(|remark| console.warning(remark));
            let seconds = finished.taken.stats.seconds;
            finished.write(&look, &shown.baked.dataset, &outputs)?;
            let [width, height] = self.size;
            for path in outputs {
                console.summary(format!("{}: {width} x {height} in {seconds:.2} s", path.display()))?;
            }
        }
        Ok(Outcome::Done)
    }

    fn open(&self, folders: &Folders) -> Result<Ready> {
        let consent = Consent::from(Preferences::load(&folders.config).0.outside);
        match opening::open(Target::File(self.file.clone()), &folders.bakes(), &consent)? {
            Opened::Ready(ready) => Ok(*ready),
            Opened::Missing { loaded, .. } => {
                let missing = loaded.missing.iter().map(|file| format!("\n  {} {}", file.what, file.path.display()));
                bail!(
                    "files of the session are missing; put them back, or open it in the window to search for them ({}){}",
                    self.file.display(),
                    missing.collect::<String>()
                )
            }
            Opened::Outside { scene, .. } => bail!(
                "the scene names files outside its folder; open it in the window and allow them ({})",
                scene.display()
            ),
        }
    }

    /// What is rendered: looks with the files for each.
    fn pictures(&self, document: &Document) -> Result<Vec<(Option<NamedLook>, Vec<PathBuf>)>> {
        if self.all {
            if document.looks.is_empty() {
                bail!("the session has no looks; add one in the window, or leave --all out ({})", self.file.display());
            }
            let names = file_names(document.looks.iter().map(|look| &look.name));
            let files = |name: &String| self.out.iter().map(|path| with_name(path, name)).collect();
            let looks = document.looks.iter().zip(&names);
            return Ok(looks.map(|(look, name)| (Some(look.clone()), files(name))).collect());
        }
        let named = |name: &String| {
            let names = document.looks.iter().map(|look| format!("\"{}\"", look.name)).collect::<Vec<_>>().join(", ");
            let there = if names.is_empty() { "it has none".into() } else { format!("it has {names}") };
            let found = document.look(name).cloned();
            found.with_context(|| format!("the session has no look \"{name}\"; {there} ({})", self.file.display()))
        };
        let look = self.look.as_ref().map(named).transpose()?;
        Ok(vec![(look, self.out.clone())])
    }

    /// What the session shows.
    fn shown(&self, ready: Ready) -> Result<PictureOfDocument> {
        let ground = ready.document.bake.ground;
        let suits = |baked: &Baked| ready.preview.is_none() && (ground == Ground::Off || baked.has_ground());
        let Some(baked) = ready.baked.filter(suits) else {
            bail!(
                "the session has no bake of its scene as it is now; open it in the window and bake it ({})",
                self.file.display()
            )
        };
        let animation = ready.source.as_ref().and_then(|source| source.animation.as_ref()).or(ready.animation.as_ref());
        let poses = pose::poses_since(&ready.document, animation, &baked);
        let aa = self.aa.unwrap_or(SMOOTH.max(ready.document.camera.lens.least_samples()));
        Ok(PictureOfDocument { document: ready.document, baked, poses, size: self.size, aa: Some(aa) })
    }
}

/// The path of a picture of a look, whose name in files comes before the extension.
fn with_name(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{name}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_looks_become_names_of_files() {
        let named = |look: &str| with_name(Path::new("out/a.png"), &file_names([look.to_owned()].iter())[0]);
        assert_eq!(named("Blue car"), Path::new("out/a-Blue car.png"));
        assert_eq!(named("../b:c"), Path::new("out/a-..-b-c.png"), "no other folder");
    }

    #[test]
    fn a_session_is_told_from_a_dataset() {
        let are_meant =
            |text: &str| RenderSessionArgs::are_meant(&text.split(' ').map(OsString::from).collect::<Vec<_>>());
        assert!(are_meant("lapidary render A.LAPIDARY --out a.png") && are_meant("lapidary --quiet render a.lapidary"));
        assert!(!are_meant("lapidary render a.cuts --out a.png") && !are_meant("lapidary check a.lapidary"));
        assert!(!are_meant("lapidary"));
    }
}
