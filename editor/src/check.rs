//! `lapidary check`: whether all files of a session are there and can be read, without a window.

use crate::document::{
    EnvironmentSettings,
    session::{self, LoadedSession, SessionError, SessionLight},
};
use anyhow::{Result, bail};
use clap::Args;
use lapidary_core::{dataset::Dataset, scene::Scene};
use lapidary_interchange::{
    environment, image,
    import::{ImportOptions, Imported, import_with},
};
use lapidary_studies::{
    args::OutsideArgs,
    terminal::{Outcome, print_out},
};
use std::path::{Path, PathBuf};

/// Options of `check`.
#[derive(Args, Clone, Debug)]
pub struct CheckArgs {
    /// Session to check
    #[arg(value_name = "FILE.lapidary")]
    file: PathBuf,
    #[command(flatten)]
    outside: OutsideArgs,
}

impl CheckArgs {
    /// Prints the files of the session and their problems.
    ///
    /// # Errors
    /// A session that cannot be read, or that has problems.
    pub fn run(&self) -> Result<Outcome> {
        let checked = check(&self.file, &self.outside.into())?;
        print_out(&checked.text())?;
        match checked.problems.len() {
            0 => Ok(Outcome::Done),
            1 => bail!("the session has a problem, see above ({})", self.file.display()),
            count => bail!("the session has {count} problems, see above ({})", self.file.display()),
        }
    }
}

/// Contents of a session, and its problems.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// Contents: a word for the kind, and the name.
    pub named: Vec<(&'static str, String)>,
    /// Missing and damaged files, in sentences.
    pub problems: Vec<String>,
}

/// Reads a session and every file that it names: scene, dataset, environment and textures.
///
/// # Errors
/// A session that cannot be read. Problems of other files are in [`Checked::problems`].
pub fn check(file: &Path, options: &ImportOptions) -> Result<Checked, SessionError> {
    let loaded = session::load(file)?;
    let mut checked = Checked::default();
    checked.list(&loaded);
    let scene = checked.scene(&loaded, options);
    checked.environments(&loaded);
    let (_, warnings) = loaded.into_document(scene.as_ref());
    checked.problems.extend(warnings);
    Ok(checked)
}

impl Checked {
    fn list(&mut self, loaded: &LoadedSession) {
        let mut session = loaded.session.clone();
        session.visit_paths(&mut |kind, path| {
            let entry = (kind, path.display().to_string());
            if !self.named.contains(&entry) {
                self.named.push(entry);
            }
        });
        let SessionLight { environment, lights, .. } = session.light;
        if environment.file().is_none() {
            self.named.push(("environment", environment.spec));
        }
        let lights = lights.map_or_else(|| "those of the scene".into(), |lights| lights.len().to_string());
        self.named.push(("lights", lights));
        self.named.push(("materials", session.materials.materials.len().to_string()));
        self.named.push(("bookmarks", session.bookmarks.len().to_string()));
        self.named.extend(session.looks.into_iter().map(|look| ("look", look.name)));
    }

    /// The scene that the session's materials belong to: the baked one, or the one to bake.
    fn scene(&mut self, loaded: &LoadedSession, options: &ImportOptions) -> Option<Scene> {
        let options = ImportOptions { scene: loaded.session.scene_in_file.clone(), ..options.clone() };
        let source = loaded.session.scene.as_deref().map(|path| self.source(path, &options));
        let baked = loaded
            .session
            .dataset
            .as_deref()
            .map(|path| self.kept(Dataset::read(path, image::decode)).map(|baked| baked.scene));
        baked.flatten().or(source.flatten())
    }

    /// The scene of a file. Files that it lacks are problems too; repairs are not.
    fn source(&mut self, path: &Path, options: &ImportOptions) -> Option<Scene> {
        let Imported { scene, report } = self.kept(import_with(path, options))?;
        let unread = report.unread.iter().map(|problem| format!("{problem} ({})", path.display()));
        self.problems.extend(unread);
        Some(scene)
    }

    /// The environments of the session and its looks, each once.
    fn environments(&mut self, loaded: &LoadedSession) {
        let of_looks = loaded.session.looks.iter().filter_map(|look| look.light.as_ref());
        let mut read = Vec::new();
        for EnvironmentSettings { spec, color_space, .. } in
            [&loaded.session.light].into_iter().chain(of_looks).map(|light| &light.environment)
        {
            if !read.contains(&(spec, color_space)) {
                read.push((spec, color_space));
                self.kept(environment::from_spec_in(spec, *color_space));
            }
        }
    }

    fn kept<T>(&mut self, read: Result<T, impl std::fmt::Display>) -> Option<T> {
        read.map_err(|error| self.problems.push(error.to_string())).ok()
    }

    fn text(&self) -> String {
        let named = self.named.iter().map(|(kind, which)| format!("{kind:<11} {which}\n"));
        let problems = self.problems.iter().map(|problem| format!("problem     {problem}\n"));
        named.chain(problems).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        document::{
            Document, TextureEntry,
            looks::{LookState, NamedLook},
        },
        test_support::write_picture,
    };
    use lapidary_core::{test_scenes::dataset, texture::TextureSlot};

    /// A session of a dataset, an environment and a texture, all there.
    struct Place(tempfile::TempDir);

    impl Place {
        fn new() -> Self {
            let place = Self(tempfile::tempdir().unwrap());
            write_picture(&place.path("linen.png"));
            write_picture(&place.path("room.png"));
            let dataset = dataset(&["cloth"], &[]);
            dataset.write(&place.path("a.cuts")).unwrap();
            let mut document = Document::of_dataset(&dataset, place.path("a.cuts"), None);
            let texture = image::read_texture(&place.path("linen.png")).unwrap().into();
            document.textures.push(TextureEntry { texture, file: Some(place.path("linen.png")) });
            document.materials[0].maps.set("base_color", Some(TextureSlot::default()));
            document.environment.spec = place.path("room.png").display().to_string();
            write_picture(&place.path("night.png"));
            let mut night = document.clone();
            night.environment.spec = place.path("night.png").display().to_string();
            document.looks = vec![NamedLook { name: "Night".into(), state: LookState::of(&night) }];
            session::save(&document, &Default::default(), &place.path("look.lapidary")).unwrap();
            place
        }

        fn path(&self, name: &str) -> PathBuf {
            self.0.path().join(name)
        }

        fn check(&self) -> Checked {
            check(&self.path("look.lapidary"), &ImportOptions::default()).unwrap()
        }

        fn run(&self) -> Result<Outcome> {
            CheckArgs { file: self.path("look.lapidary"), outside: OutsideArgs::default() }.run()
        }
    }

    #[test]
    fn a_session_whose_files_are_there_has_no_problems() {
        let place = Place::new();
        let checked = place.check();
        assert_eq!(checked.problems, Vec::<String>::new());
        for (kind, name) in [("dataset", "a.cuts"), ("environment", "room.png"), ("texture", "linen.png")] {
            assert!(checked.named.iter().any(|(k, which)| *k == kind && which.ends_with(name)), "{kind}");
        }
        assert!(checked.text().contains("lights      0\n") && checked.text().contains("look        Night\n"));
        assert_eq!(place.run().unwrap(), Outcome::Done);
    }

    #[test]
    fn each_file_that_is_missing_or_damaged_is_a_problem_that_names_it() {
        for name in ["a.cuts", "room.png", "linen.png", "night.png"] {
            let damages: [fn(&Path) -> std::io::Result<()>; 2] =
                [|path| std::fs::remove_file(path), |path| std::fs::write(path, b"not what it was")];
            for damage in damages {
                let place = Place::new();
                damage(&place.path(name)).unwrap();
                let problems = place.check().problems;
                assert!(problems.len() == 1 && problems[0].contains(name), "{name}: {problems:?}");
                assert!(place.run().unwrap_err().to_string().contains("look.lapidary"));
            }
        }
    }

    #[test]
    fn what_the_scene_names_must_be_there_and_in_its_folder() {
        let place = Place::new();
        let bare = place.check().problems;
        assert!(bare.is_empty(), "{bare:?}");
        std::fs::create_dir(place.path("inner")).unwrap();
        std::fs::write(place.path("inner/a.obj"), "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            .unwrap();
        let checked = |picture: &str, allow_outside: bool| {
            std::fs::write(place.path("inner/a.mtl"), format!("newmtl m\nmap_Kd {picture}\n")).unwrap();
            let mut checked = Checked::default();
            let options = ImportOptions { allow_outside, ..Default::default() };
            assert!(checked.source(&place.path("inner/a.obj"), &options).is_some());
            checked.problems
        };
        for (picture, allow) in [("wood.png", false), ("wood.png", true), ("../linen.png", false)] {
            let problems = checked(picture, allow);
            assert!(problems.len() == 1 && problems[0].contains(picture), "{problems:?}");
            assert!(problems[0].ends_with("a.obj)"), "{problems:?}");
        }
        assert_eq!(checked("../linen.png", true), Vec::<String>::new());
        write_picture(&place.path("inner/wood.png"));
        assert_eq!(checked("wood.png", false), Vec::<String>::new());
    }

    #[test]
    fn values_that_cannot_be_used_are_problems() {
        let place = Place::new();
        let text = std::fs::read_to_string(place.path("look.lapidary")).unwrap();
        std::fs::write(place.path("look.lapidary"), text.replace("\"intensity\": 1.0", "\"intensity\": -1.0")).unwrap();
        let problems = place.check().problems;
        assert!(problems.len() == 2 && problems[0].starts_with("the intensity"), "{problems:?}");
        assert!(problems[1].starts_with("in the look \"Night\", the intensity"), "{problems:?}");
    }

    #[test]
    fn what_is_no_session_is_an_error_that_names_it() {
        let place = Place::new();
        std::fs::write(place.path("look.lapidary"), "{\"lapidary_session\": 99}").unwrap();
        assert!(place.run().unwrap_err().to_string().contains("look.lapidary"));
    }
}
