//! Turns a session and its scene into a document.

use super::{
    LoadedSession, Session, SessionAssignment, SessionHandling, SessionLight, SessionMaterial, SessionMaterials,
    SessionPose, TextureSource, brdfs, file::document_material,
};
use crate::document::{
    Document, TextureEntry,
    handling::{Handling, PlacedPivot},
    looks::{LightOfLook, LookState, MaterialsOfLook, NamedLook},
    parts::Assignment,
};
use lapidary_core::{ground, lights::Light, material::Material, parts::Part, scene::Scene, texture::Texture};
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
    /// material of the same name, or else in the same place. The same is done for the materials of looks.
    pub fn into_document(self, scene: Option<&Scene>) -> (Document, Vec<String>) {
        let Self { mut session, mut warnings, .. } = self;
        let mut document = match scene {
            Some(scene) => Document::of_scene(scene, None),
            None => Document::empty(),
        };
        name_stand_ins(&mut document, &session);
        let of_scene = std::mem::take(&mut document.textures);
        let mut textures = Textures::new(of_scene, &mut session, scene.is_some());
        let mut resolved = |materials: SessionMaterials, warnings: &mut Vec<String>| {
            let mut resolver = Materials { document: &document, scene, textures: &mut textures, warnings };
            resolver.resolve(materials)
        };
        let materials = resolved(session.materials, &mut warnings);
        let looks = session.looks.into_iter().map(|look| {
            // What differs from the scene is told once.
            let materials = look.materials.map(|materials| resolved(materials, &mut Vec::new()));
            let light = look.light.map(|light| light_of(light, &document.lights));
            let camera = look.camera.as_ref().map(Into::into);
            NamedLook { name: look.name, state: LookState { materials, light, camera, view: look.view } }
        });
        let looks = looks.collect();
        warnings.append(&mut textures.warnings);
        document.looks = looks;
        document.textures = textures.entries;
        let (light, camera) = (light_of(session.light, &document.lights), session.camera.as_ref().map(Into::into));
        let mut state = LookState { materials: Some(materials), light: Some(light), camera, view: Some(session.view) };
        state.swap(&mut document);
        let own = scene.map_or(&[][..], |scene| &scene.materials);
        brdfs::read(&mut document, own, &mut warnings);
        let ground = scene.and_then(|scene| scene.mesh.ground_object());
        take_poses(&mut document, &session.poses, ground, &mut warnings);
        take_handling(&mut document, &session.handling, ground, &mut warnings);
        document.clip_time = session.clip_time;
        (document.scene, document.scene_in_file) = (session.scene, session.scene_in_file);
        document.dataset = session.dataset;
        document.bookmarks = session.bookmarks.iter().map(Into::into).collect();
        document.bake = session.bake;
        (document, warnings)
    }
}

/// The light of a document or a look; without lights it has those of the scene.
fn light_of(
    SessionLight { environment, lights, components, solution }: SessionLight,
    of_scene: &[Light],
) -> LightOfLook {
    LightOfLook { environment, lights: lights.unwrap_or_else(|| of_scene.to_vec()), components, solution }
}

/// Finds the materials of a session in a scene.
struct Materials<'a> {
    /// With the scene's objects and materials, if there is one.
    document: &'a Document,
    scene: Option<&'a Scene>,
    textures: &'a mut Textures,
    warnings: &'a mut Vec<String>,
}

impl Materials<'_> {
    fn resolve(&mut self, session: SessionMaterials) -> MaterialsOfLook {
        let Self { document, scene, textures, warnings } = self;
        let SessionMaterials { materials: mut own, added, assigned } = session;
        let own_count = own.len().saturating_sub(added);
        let added = own.split_off(own_count);
        let hidden = scene.and_then(|scene| hidden_ground(scene, &mut own));
        let hidden_ground = hidden.map(|material| textures.material(&material));
        let (mut materials, places) = match scene {
            Some(scene) => {
                let places = match_materials(&scene.materials, &own);
                warn_of_differences(&scene.materials, &own, &places, warnings);
                (merged_materials(&document.materials, &own, &places, textures), places)
            }
            None => (own.iter().map(|m| textures.material(m)).collect(), (0..own.len()).map(Some).collect()),
        };
        let found =
            Numbers { own: materials.len(), own_in_session: own_count, all: materials.len() + added.len(), places };
        materials.extend(added.iter().map(|m| textures.material(m)));
        // The session, not the bake, decides assignments.
        let assigned = found.assigned(document, &assigned);
        MaterialsOfLook { materials, added: added.len(), assigned, hidden_ground }
    }
}

/// Names the objects of a document without a scene by the session.
fn name_stand_ins(document: &mut Document, session: &Session) {
    if !document.objects.is_empty() {
        return;
    }
    let assigned = session.assigned().map(|assignment| (assignment.object, &assignment.name));
    let posed = session.poses.iter().map(|pose| (pose.object, &pose.name));
    let handled = session.handling.iter().map(|handled| (handled.object, &handled.name));
    let named = assigned.chain(posed).chain(handled);
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

/// Applies how a session handles objects. Leaves out the ground and objects that the scene no longer has.
fn take_handling(
    document: &mut Document,
    handling: &[SessionHandling],
    ground: Option<u32>,
    warnings: &mut Vec<String>,
) {
    for SessionHandling { name, object, own } in handling {
        let Some(object) = document.object_called(name, *object).filter(|&object| Some(object) != ground) else {
            continue;
        };
        let pivot = own.pivot.filter(PlacedPivot::is_valid);
        if pivot != own.pivot {
            warnings.push(format!("the pivot of \"{name}\" is out of reach or its hinge has another length than 1; the object turns about its center"));
        }
        document.handling.insert(object, Handling { pivot, ..*own });
    }
}

/// Where the materials of a session are in a document.
struct Numbers {
    /// The scene's own in the document, and all.
    own: usize,
    all: usize,
    /// Those in the session that are not added.
    own_in_session: usize,
    /// For each of the scene's the one in the session.
    places: Vec<Option<usize>>,
}

impl Numbers {
    /// Material assignments of a session. Leaves out objects and materials that the scene no longer has.
    fn assigned(&self, document: &Document, assigned: &[SessionAssignment]) -> Assignment {
        let found = assigned.iter().filter_map(|assignment| {
            let object = document.object_called(&assignment.name, assignment.object)?;
            let own = self.of_own(assignment.own)?;
            let material = self.of(assignment.material).filter(|&material| material != own)?;
            Some((Part { object, material: own as u32 }, material))
        });
        found.collect()
    }

    fn of(&self, index: usize) -> Option<usize> {
        match index.checked_sub(self.own_in_session) {
            Some(added) => Some(self.own + added).filter(|&found| found < self.all),
            None => self.of_own(index),
        }
    }

    fn of_own(&self, index: usize) -> Option<usize> {
        self.places.iter().position(|place| *place == Some(index)).filter(|&found| found < self.own)
    }
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
struct Textures {
    entries: Vec<TextureEntry>,
    /// Number of the scene's textures.
    of_scene: usize,
    by_file: HashMap<PathBuf, u32>,
    stand_ins: HashMap<String, u32>,
    /// Whether the scene's textures are known, so that a missing one deserves a warning.
    scene_known: bool,
    warnings: Vec<String>,
}

impl Textures {
    /// With the textures of the scene, or, if unknown, stand-ins at the indices that the session names, so that saving it writes
    /// the same.
    fn new(of_scene: Vec<TextureEntry>, session: &mut Session, scene_known: bool) -> Self {
        let mut entries = of_scene;
        if !scene_known {
            for slot in session.materials_mut().flat_map(|m| m.maps.slots_mut()) {
                let Some(TextureSource::Scene { index, name }) = &slot.texture else { continue };
                if *index < MAX_STAND_INS {
                    let length = entries.len().max(*index as usize + 1);
                    entries.resize_with(length, || stand_in("", None));
                    entries[*index as usize] = stand_in(name, None);
                }
            }
        }
        let of_scene = entries.len();
        Self {
            entries,
            of_scene,
            by_file: HashMap::new(),
            stand_ins: HashMap::new(),
            scene_known,
            warnings: Vec::new(),
        }
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
