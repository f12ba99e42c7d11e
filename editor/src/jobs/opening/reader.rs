//! Reads a scene, a dataset or a session, with its bakes.

use super::{Consent, Opened, Ready, Target, bake_beside, no_document};
use crate::{
    document::{
        Document,
        autosave::Recovery,
        fitting::fit_materials,
        parts::{OwnMaterials, Renumbering},
        session::{self, LoadedSession},
    },
    jobs::{
        Imported,
        kept_bakes::{self, draft_of, kept_in},
        load::{Kind, kind_of},
    },
};
use anyhow::Result;
use lapidary_core::{dataset::Dataset, ground::Ground};
use lapidary_interchange::image;
use lapidary_render::Baked;
use std::path::{Path, PathBuf};

/// Settings of reading.
pub struct Reader<'a> {
    /// The folder of kept bakes.
    pub bakes: &'a Path,
    /// Permission to read files.
    pub consent: &'a Consent,
}

/// Reads a target.
///
/// # Errors
/// A file that cannot be read.
pub fn read(target: Target, reader: &Reader) -> Result<Opened> {
    match target {
        Target::File(path) => match kind_of(&path) {
            Kind::Scene => reader.scene(&path, None).map(ready),
            Kind::Dataset => open_dataset(&path).map(ready),
            Kind::Session => reader.session(&path, Some(path.clone()), None),
            kind => Err(anyhow::Error::msg(no_document(&path, kind))),
        },
        Target::SceneIn { path, scene } => reader.scene(&path, Some(scene)).map(ready),
        Target::Bundled(scene) => reader.bundled(&scene).map(ready),
        Target::Recovered(recovery) => {
            reader.session(&recovery.file.clone(), recovery.session_path.clone(), Some(recovery))
        }
        Target::Session { loaded, path, recovery, look_in: None } => Ok(ready(reader.resolve(*loaded, path, recovery))),
        Target::Session { loaded, path, recovery, look_in: Some(folder) } => {
            Ok(reader.look(loaded, path, recovery, &folder))
        }
    }
}

fn ready(ready: Ready) -> Opened {
    Opened::Ready(ready.into())
}

/// Reads a dataset; a missing or damaged one only has to be baked again.
fn read_if_there(path: &Path, warnings: &mut Vec<String>) -> Option<Baked> {
    if !path.is_file() {
        return None;
    }
    match Dataset::read(path, image::decode) {
        Ok(dataset) => Some(Baked::begun(dataset)),
        Err(error) => {
            warnings.push(format!("Cannot use the bake; bake again: {error}"));
            None
        }
    }
}

fn open_dataset(path: &Path) -> Result<Ready> {
    let baked = Baked::begun(Dataset::read(path, image::decode)?);
    let document = Document::of_dataset(&baked.dataset, path.into(), None);
    Ok(Ready { recent: Some(path.into()), ..Ready::new(document, Some(baked), None, Vec::new()) })
}

/// The bakes of a scene.
struct Found {
    /// The full bake, perhaps of another version of the scene, and its file.
    whole: Option<(Baked, PathBuf)>,
    /// A draft, if there is no full bake.
    draft: Option<Baked>,
    /// Output of an automatic bake.
    kept_output: PathBuf,
}

impl Reader<'_> {
    /// A scene of a file, or its default, whose bakes go beside it.
    fn scene(&self, path: &Path, scene_in_file: Option<String>) -> Result<Ready> {
        let source = self.consent.import(path, scene_in_file.as_deref())?;
        let output = bake_beside(path, scene_in_file.as_deref());
        let mut warnings = source.report.warnings.clone();
        let found = self.bakes_of(&source, path, &output, &mut warnings);
        let document = match &found.whole {
            Some((baked, file)) if *file == output => {
                Document::of_dataset(&baked.dataset, output.clone(), Some(path.into()))
            }
            // The look comes from the present scene. The file is not named: another machine would not find it.
            Some((kept, _)) => Document::of_scene(&source.scene, Some(path.into())).with_bake(&kept.dataset),
            None => Document::of_scene(&source.scene, Some(path.into())),
        };
        let document = Document { scene_in_file, ..document };
        Ok(Ready { recent: Some(path.into()), bake_output: Some(output), ..found.ready(document, source, warnings) })
    }

    fn bundled(&self, scene: &Path) -> Result<Ready> {
        let source = self.consent.import(scene, None)?;
        let output = kept_in(self.bakes, scene, &source.hash);
        let mut warnings = source.report.warnings.clone();
        let found = self.bakes_of(&source, scene, &output, &mut warnings);
        let document = Document::of_scene(&source.scene, Some(scene.into()));
        // A bake of other settings, poses or times is the user's choice.
        let document = match &found.whole {
            Some((baked, _)) => document.with_bake(&baked.dataset),
            None => document,
        };
        // Named before it exists, so that a session finds it later.
        let document = Document { dataset: Some(output.clone()), ..document };
        Ok(Ready { bake_output: Some(output), ..found.ready(document, source, warnings) })
    }

    /// The bakes of a scene: at `output`, else a kept one, else a draft. Only the first may be of another version of the scene.
    fn bakes_of(&self, source: &Imported, scene: &Path, output: &Path, warnings: &mut Vec<String>) -> Found {
        let kept_output = kept_in(self.bakes, scene, &source.hash);
        let is_of_scene = |baked: &Baked| baked.dataset.scene_hash == source.hash;
        let mut read = |path: &Path| read_if_there(path, warnings);
        let asked_for = read(output).map(|baked| (baked, output.to_owned()));
        let whole = match asked_for {
            Some(asked_for) if is_of_scene(&asked_for.0) => Some(asked_for),
            asked_for => {
                let kept = read(&kept_output).filter(is_of_scene).map(|baked| (baked, kept_output.clone()));
                kept.iter().for_each(|(_, file)| kept_bakes::touch(file));
                kept.or(asked_for)
            }
        };
        let draft = if whole.is_none() { read(&draft_of(&kept_output)).filter(is_of_scene) } else { None };
        Found { whole, draft, kept_output }
    }

    fn session(&self, file: &Path, path: Option<PathBuf>, recovery: Option<Recovery>) -> Result<Opened> {
        let loaded = session::load(file)?;
        if loaded.missing.is_empty() {
            return Ok(ready(self.resolve(loaded, path, recovery)));
        }
        Ok(Opened::Missing { loaded: loaded.into(), path, recovery, found: None })
    }

    /// Searches for the missing files of a session.
    fn look(
        &self,
        mut loaded: Box<LoadedSession>,
        path: Option<PathBuf>,
        recovery: Option<Recovery>,
        folder: &Path,
    ) -> Opened {
        let found = Some(loaded.relink(folder));
        if loaded.missing.is_empty() {
            return ready(self.resolve(*loaded, path, recovery));
        }
        Opened::Missing { loaded, path, recovery, found }
    }

    /// Reads all files that the session names; leaves out unreadable ones with a warning.
    fn resolve(&self, loaded: LoadedSession, path: Option<PathBuf>, recovery: Option<Recovery>) -> Ready {
        let mut warnings = Vec::new();
        let scene_path = loaded.session.scene.clone();
        let in_file = loaded.session.scene_in_file.clone();
        let in_file = in_file.as_deref();
        let source = scene_path.as_deref().and_then(|path| self.source_if_there(path, in_file, &mut warnings));
        let beside = || scene_path.as_ref().map(|path| bake_beside(path, in_file));
        let output = loaded.session.dataset.clone().or_else(beside);
        let named = source.as_ref().zip(scene_path.as_deref()).zip(output.as_deref());
        let found = named.map(|((source, scene), output)| self.bakes_of(source, scene, output, &mut warnings));
        let baked = match &found {
            Some(found) => found.best(),
            // A dataset without its scene can still be shown.
            None => output.as_deref().and_then(|output| read_if_there(output, &mut warnings)),
        };
        let unknown = loaded.unknown.clone();
        let bake = loaded.session.bake.clone();
        // Only a bake of the present scene with the session's ground is shown.
        let suits = |baked: &Baked| match &source {
            Some(source) => {
                baked.dataset.scene_hash == source.hash && (bake.ground == Ground::Off || baked.has_ground())
            }
            None => true,
        };
        let preview = || source.as_ref().map(|source| source.unshadowed(&bake));
        let rendered = baked.clone().filter(suits).or_else(preview);
        let (document, remarks) = loaded.into_document(rendered.as_ref().map(|rendered| &rendered.dataset.scene));
        warnings.extend(remarks);
        let recent = path.clone();
        let bake_output = source.is_some().then_some(output).flatten();
        let ready = match found.zip(source) {
            Some((found, source)) => found.ready(document, source, warnings),
            None => Ready::new(document, baked, None, warnings),
        };
        Ready { unknown, session: path, recovery, bake_output, recent, ..ready }
    }

    /// Reads the scene; without it a session can be shown, but not baked again.
    fn source_if_there(&self, path: &Path, in_file: Option<&str>, warnings: &mut Vec<String>) -> Option<Imported> {
        if !path.is_file() {
            return None;
        }
        let source = self.consent.import(path, in_file);
        source.map_err(|error| warnings.push(format!("The scene cannot be baked again: {error}"))).ok()
    }
}

impl Found {
    /// The best bake.
    fn best(&self) -> Option<Baked> {
        self.whole.as_ref().map(|(baked, _)| baked).or(self.draft.as_ref()).cloned()
    }

    /// The document of a scene and these bakes.
    fn ready(self, mut document: Document, source: Imported, warnings: Vec<String>) -> Ready {
        let baked = self.best();
        // A bake of another version of the scene is shown only if the user says so.
        let is_seen = baked.as_ref().is_some_and(|baked| baked.dataset.scene_hash == source.hash);
        let preview = (!is_seen).then(|| source.unshadowed(&document.bake));
        // A ground has a material of its own.
        let rendered = preview.as_ref().or(baked.as_ref());
        let own = document.own_materials();
        let lacks_some = |baked: &&&Baked| own < baked.dataset.scene.materials.len();
        if let Some(rendered) = rendered.as_ref().filter(lacks_some) {
            fit_materials(&mut document, &rendered.dataset);
            let [before, after] = [own, document.own_materials()].map(|count| OwnMaterials { count, ground: None });
            document.renumber_materials(&Renumbering { before, after });
        }
        if let Some(rendered) = rendered {
            document.take_objects(&rendered.dataset.scene);
        }
        let (lacks_bake, is_draft, kept_output) = (self.whole.is_none(), self.draft.is_some(), Some(self.kept_output));
        Ready { preview, lacks_bake, is_draft, kept_output, ..Ready::new(document, baked, Some(source), warnings) }
    }
}
