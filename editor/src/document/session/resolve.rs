//! Turns a session and its scene into a document.

use super::{
    LoadedSession, Session, SessionAssignment, SessionMaterial, SessionPose, TextureSource, brdfs,
    file::document_material,
};
use crate::document::{Document, TextureEntry};
use lapidary_core::{ground, material::Material, parts::Part, scene::Scene, texture::Texture};
use lapidary_interchange::image;
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

/// Most stand-ins for scene textures without a scene; a file may name any number.
const MAX_STAND_INS: u32 = 10_000;

impl LoadedSession {
    /// The document, and the warnings of loading and of this step. Reads pictures, so it takes a while.
    ///
    /// Without a scene the materials are the session's. With one they are the scene's, each with the values of the session's
    /// material of the same name, or else in the same place.
    pub fn into_document(self, scene: Option<&Scene>) -> (Document, Vec<String>) {
        let Self { mut session, mut warnings, .. } = self;
        let mut document = match scene {
            Some(scene) => Document::of_scene(scene, None),
            None => Document::empty(),
        };
        let mut textures = Textures::new(document.textures, &mut session, scene.is_some(), &mut warnings);
        let own_count = session.materials.len().saturating_sub(session.added);
        let added = session.materials.split_off(own_count);
        let hidden = scene.and_then(|scene| hidden_ground(scene, &mut session.materials));
        document.hidden_ground = hidden.map(|m| textures.material(&m));
        let places = match scene {
            Some(scene) => match_materials(&scene.materials, &session.materials),
            None => (0..session.materials.len()).map(Some).collect(),
        };
        document.materials = match scene {
            Some(_) => merged_materials(&document.materials, &session.materials, &places, &mut textures),
            None => session.materials.iter().map(|m| textures.material(m)).collect(),
        };
        document.added = added.len();
        document.materials.extend(added.iter().map(|m| textures.material(m)));
        document.textures = textures.entries;
        brdfs::read(&mut document.materials, scene.map_or(&[], |scene| &scene.materials), &mut warnings);
        // The session, not the bake, decides assignments.
        document.assigned.clear();
        let assigned = session.assigned.iter().map(|assignment| (assignment.object, &assignment.name));
        name_stand_ins(&mut document, assigned.chain(session.poses.iter().map(|pose| (pose.object, &pose.name))));
        take_assignments(&mut document, &session.assigned, own_count, &places);
        let ground = scene.and_then(|scene| scene.mesh.ground_object());
        take_poses(&mut document, &session.poses, ground, &mut warnings);
        document.clip_time = session.clip_time;
        (document.scene, document.scene_in_file) = (session.scene, session.scene_in_file);
        document.dataset = session.dataset;
        document.environment = session.environment;
        if let Some(lights) = session.lights {
            document.lights = lights;
        }
        (document.components, document.solution) = (session.components, session.solution);
        if let Some(camera) = &session.camera {
            document.camera = camera.into();
        }
        document.bookmarks = session.bookmarks.iter().map(Into::into).collect();
        document.view = session.view;
        document.bake = session.bake;
        (document, warnings)
    }
}

/// Names the objects of a document without a scene by the session.
fn name_stand_ins<'a>(document: &mut Document, named: impl Iterator<Item = (u32, &'a String)>) {
    if !document.objects.is_empty() {
        return;
    }
    for (object, name) in named.filter(|(object, _)| *object < MAX_STAND_INS) {
        let count = document.objects.len().max(object as usize + 1);
        document.objects.resize(count, String::new());
        document.objects[object as usize].clone_from(name);
    }
}

/// Applies a session's poses. Leaves out the ground and objects that the scene no longer has.
fn take_poses(document: &mut Document, poses: &[SessionPose], ground: Option<u32>, warnings: &mut Vec<String>) {
    for session in poses {
        let (pose, object) = (session.pose(), document.object_called(&session.name, session.object));
        let object = object.filter(|&object| Some(object) != ground);
        match pose.validate(&session.name) {
            Ok(()) => object.into_iter().for_each(|object| document.poses.set(object, pose)),
            Err(error) => warnings.push(format!("{error}; the object is placed as in the scene file")),
        }
    }
}

/// Applies a session's material assignments. The session has `own_count` materials besides the added ones, and material `i` of the
/// scene is its `places[i]`. Leaves out objects and materials that the scene no longer has.
fn take_assignments(
    document: &mut Document,
    assigned: &[SessionAssignment],
    own_count: usize,
    places: &[Option<usize>],
) {
    let own = document.own_materials();
    let own_index = |index: usize| places.iter().position(|place| *place == Some(index)).filter(|&found| found < own);
    let index = |index: usize| match index.checked_sub(own_count) {
        Some(added) => Some(own + added).filter(|&found| found < document.materials.len()),
        None => own_index(index),
    };
    let found = assigned.iter().filter_map(|assignment| {
        let object = document.object_called(&assignment.name, assignment.object)?;
        let part = Part { object, material: own_index(assignment.own)? as u32 };
        Some((part, index(assignment.material)?))
    });
    document.assigned = document.assigning(found);
}

/// Takes the ground's material from a session's materials, if the scene has no ground.
fn hidden_ground(scene: &Scene, session: &mut Vec<SessionMaterial>) -> Option<SessionMaterial> {
    let is_left = scene.mesh.ground.is_none() && session.len() == scene.materials.len() + 1;
    session.pop_if(|last| is_left && last.name == ground::NAME)
}

fn merged_materials(
    own: &[Material],
    session: &[SessionMaterial],
    places: &[Option<usize>],
    textures: &mut Textures,
) -> Vec<Material> {
    warn_of_differences(own, session, places, textures.warnings);
    let merge = |(own, place): (&Material, &Option<usize>)| match place {
        // The bake decides which sides reflect.
        Some(i) => Material { double_sided: own.double_sided, ..textures.material(&session[*i]) },
        None => own.clone(),
    };
    own.iter().zip(places).map(merge).collect()
}

/// For each material of the scene the session's material of the same name, preferably at the same index. In lists of the same
/// length, a remaining one at the same index counts too, because artists rename materials.
fn match_materials(own: &[Material], session: &[SessionMaterial]) -> Vec<Option<usize>> {
    let mut places = vec![None; own.len()];
    let mut free = vec![true; session.len()];
    let mut take = |i: usize, found: Option<usize>, places: &mut Vec<Option<usize>>| {
        if let Some(found) = found.filter(|&j| places[i].is_none() && std::mem::take(&mut free[j])) {
            places[i] = Some(found);
        }
    };
    for (i, material) in own.iter().enumerate() {
        let same = session.get(i).is_some_and(|s| s.name == material.name);
        take(i, same.then_some(i), &mut places);
    }
    let mut by_name: HashMap<&str, Vec<usize>> = HashMap::new();
    for (j, material) in session.iter().enumerate().rev().filter(|(j, _)| places.get(*j) != Some(&Some(*j))) {
        by_name.entry(&material.name).or_default().push(j);
    }
    for (i, material) in own.iter().enumerate() {
        if places[i].is_none() {
            take(i, by_name.get_mut(material.name.as_str()).and_then(Vec::pop), &mut places);
        }
    }
    if own.len() == session.len() {
        (0..own.len()).for_each(|i| take(i, Some(i), &mut places));
    }
    places
}

fn warn_of_differences(
    own: &[Material],
    session: &[SessionMaterial],
    places: &[Option<usize>],
    warnings: &mut Vec<String>,
) {
    let quoted = |names: Vec<&str>| names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    let used = |j: usize| places.contains(&Some(j));
    let lost: Vec<&str> = (0..session.len()).filter(|&j| !used(j)).map(|j| session[j].name.as_str()).collect();
    if !lost.is_empty() {
        warnings.push(format!(
            "the scene has no materials {}, so their edits are left out; save under another name to keep the session as \
             it was",
            quoted(lost)
        ));
    }
    let new: Vec<&str> = own.iter().zip(places).filter(|(_, p)| p.is_none()).map(|(m, _)| m.name.as_str()).collect();
    if !new.is_empty() {
        warnings.push(format!("the session has no materials {}; they are as in the scene", quoted(new)));
    }
    let same_names = own.iter().zip(places).any(|(m, p)| p.is_some_and(|j| session[j].name == m.name));
    if !same_names && places.iter().any(Option::is_some) {
        warnings.push(
            "no material of the scene has the name of one in the session, so they were matched by their order; check \
             that this is the scene of the session"
                .into(),
        );
    }
}

/// The textures of the document so far.
struct Textures<'a> {
    entries: Vec<TextureEntry>,
    /// Number of the scene's textures.
    of_scene: usize,
    by_file: HashMap<PathBuf, u32>,
    stand_ins: HashMap<String, u32>,
    /// Whether the scene's textures are known, so that a missing one deserves a warning.
    scene_known: bool,
    warnings: &'a mut Vec<String>,
}

impl<'a> Textures<'a> {
    /// With the textures of the scene, or, if unknown, stand-ins at the indices that the session names, so that saving it writes
    /// the same.
    fn new(
        of_scene: Vec<TextureEntry>,
        session: &mut Session,
        scene_known: bool,
        warnings: &'a mut Vec<String>,
    ) -> Self {
        let mut entries = of_scene;
        if !scene_known {
            for slot in session.materials.iter_mut().flat_map(|m| m.maps.slots_mut()) {
                let Some(TextureSource::Scene { index, name }) = &slot.texture else { continue };
                if *index < MAX_STAND_INS {
                    let length = entries.len().max(*index as usize + 1);
                    entries.resize_with(length, || stand_in("", None));
                    entries[*index as usize] = stand_in(name, None);
                }
            }
        }
        let of_scene = entries.len();
        Self { entries, of_scene, by_file: HashMap::new(), stand_ins: HashMap::new(), scene_known, warnings }
    }

    fn material(&mut self, material: &SessionMaterial) -> Material {
        document_material(material, |source| self.index_of(source))
    }

    fn index_of(&mut self, source: &TextureSource) -> u32 {
        match source {
            TextureSource::File(file) => self.file(file),
            TextureSource::Scene { index, name } => self.scene(*index as usize, name),
        }
    }

    fn file(&mut self, file: &Path) -> u32 {
        if let Some(&index) = self.by_file.get(file) {
            return index;
        }
        let entry = match image::read_texture(file) {
            Ok(texture) => TextureEntry { texture: texture.into(), file: Some(file.into()) },
            Err(error) => {
                self.warnings.push(format!("a texture is replaced by a magenta checkerboard: {error}"));
                let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
                stand_in(&name, Some(file))
            }
        };
        let index = self.push(entry);
        self.by_file.insert(file.into(), index);
        index
    }

    fn scene(&mut self, index: usize, name: &str) -> u32 {
        let of_scene = &self.entries[..self.of_scene];
        let has_name = |entry: &TextureEntry| entry.texture.name == name;
        let same = of_scene.get(index).is_some_and(has_name).then_some(index);
        if let Some(found) = same.or_else(|| of_scene.iter().position(has_name)) {
            return found as u32;
        }
        if let Some(&index) = self.stand_ins.get(name) {
            return index;
        }
        if self.scene_known {
            self.warnings.push(format!(
                "the scene has no texture \"{name}\", it is replaced by a magenta checkerboard; bake the scene again or \
                 choose another picture"
            ));
        }
        let index = self.push(stand_in(name, None));
        self.stand_ins.insert(name.into(), index);
        index
    }

    fn push(&mut self, entry: TextureEntry) -> u32 {
        self.entries.push(entry);
        (self.entries.len() - 1) as u32
    }
}

fn stand_in(name: &str, file: Option<&Path>) -> TextureEntry {
    TextureEntry { texture: Texture::missing(name).into(), file: file.map(Into::into) }
}
