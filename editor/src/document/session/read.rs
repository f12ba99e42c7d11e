//! Reading of a session file.

use super::{
    AUTOSAVE_KEY, Session, SessionAssignment, SessionCamera, SessionError, SessionHandling, SessionLight, SessionLook,
    SessionMaterial, SessionMaterials, SessionPose, SessionSlot, Unknown, VERSION, VERSION_KEY, checks,
    lenient::{read_leniently, refusal},
};
use crate::document::{
    lights::LightKind,
    relative::{folder_of, resolve},
};
use glam::Vec3;
use lapidary_core::{
    animation::ClipTime,
    brdf::BrdfFile,
    input,
    lights::{Emission, Light},
    material::{BrdfModel, map_names},
    texture::{Procedural, UvSet, Wrap},
};
use lapidary_interchange::image::file_and_layer;
use lapidary_precompute::Preset;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// More than this is no session: a material takes about 2 kB.
const MAX_BYTES: u64 = 64 << 20;

/// A session as read, before its files are opened.
#[derive(Clone, Debug)]
pub struct LoadedSession {
    /// Its parts; paths are absolute.
    pub session: Session,
    /// Missing files, each once.
    pub missing: Vec<MissingFile>,
    /// Replacements and omissions, in sentences.
    pub warnings: Vec<String>,
    /// Unknown keys, for writing back.
    pub unknown: Unknown,
}

/// A missing file of a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingFile {
    /// `scene`, `dataset`, `environment`, `BRDF` or `texture`.
    pub what: &'static str,
    /// Where it should be.
    pub path: PathBuf,
}

/// Reads the session in a file.
///
/// # Errors
/// A file that cannot be read, is no session, or was written by a newer version.
pub fn load(path: &Path) -> Result<LoadedSession, SessionError> {
    let root = read_json(path)?;
    let mut reader = Reader::default();
    let mut session = reader.session(&root);
    if root.get(VERSION_KEY).and_then(Value::as_u64) == Some(1) {
        session.materials_mut().for_each(SessionMaterial::with_ward_of_before);
    }
    checks::sanitize(&mut session, &mut reader.warnings);
    reader.rename_unknown(&session.looks);
    let folder = folder_of(path);
    session.visit_paths(&mut |_, path| *path = resolve(path, &folder));
    let missing = missing_files(&mut session);
    Ok(LoadedSession { session, missing, warnings: reader.warnings, unknown: Unknown(reader.unknown) })
}

/// The top-level object of a session file, if its version can be read.
pub fn read_json(path: &Path) -> Result<Map<String, Value>, SessionError> {
    let io_error = |source| SessionError::Io { action: "read", path: path.into(), source };
    let bytes = std::fs::metadata(path).map_err(io_error)?.len();
    if bytes > MAX_BYTES {
        return Err(SessionError::TooLarge { path: path.into(), bytes, limit: MAX_BYTES });
    }
    let bytes = input::read(path).map_err(io_error)?;
    let text = input::text(&bytes).map_err(io_error)?;
    let root = serde_json::from_slice(&text).map_err(|source| SessionError::Damaged { path: path.into(), source })?;
    let Value::Object(root) = root else { return Err(SessionError::Foreign { path: path.into() }) };
    match root.get(VERSION_KEY).and_then(Value::as_u64) {
        Some(found) if found > VERSION => Err(SessionError::Newer { path: path.into(), found }),
        Some(1..) => Ok(root),
        _ => Err(SessionError::Foreign { path: path.into() }),
    }
}

/// Missing files of the session.
fn missing_files(session: &mut Session) -> Vec<MissingFile> {
    let mut missing: Vec<MissingFile> = Vec::new();
    session.visit_paths(&mut |what, path| {
        if !file_and_layer(path).0.is_file() && !missing.iter().any(|m| m.path == *path) {
            missing.push(MissingFile { what, path: path.clone() });
        }
    });
    forget_what_can_be_baked(session, &mut missing);
    missing
}

/// Drops a missing dataset whose scene is there: it can be baked again, and a session may be saved before the first bake.
pub fn forget_what_can_be_baked(session: &Session, missing: &mut Vec<MissingFile>) {
    if session.scene.as_deref().is_some_and(Path::is_file) {
        missing.retain(|file| file.what != "dataset");
    }
}

#[derive(Default)]
struct Reader {
    warnings: Vec<String>,
    unknown: Map<String, Value>,
}

impl Reader {
    fn session(&mut self, root: &Map<String, Value>) -> Session {
        let session = Session {
            scene: self.path(root, "scene"),
            scene_in_file: self.choice(root, "scene_in_file"),
            dataset: self.path(root, "dataset"),
            materials: self.materials(root),
            poses: self.list(root, "poses", |_| SessionPose::default()),
            handling: self.list(root, "handling", |_| SessionHandling::default()),
            clip_time: root.get("clip_time").map(|_| self.part(root, "clip_time", ClipTime::default())),
            light: self.light(root),
            camera: self.camera(root),
            bookmarks: self.list(root, "bookmarks", |_| SessionCamera::default()),
            looks: self.looks(root),
            view: self.part(root, "view", Default::default()),
            bake: self.part(root, "bake", Preset::Normal.settings()),
        };
        self.keep_unknown(root, &session, &[VERSION_KEY, AUTOSAVE_KEY, "looks"]);
        session
    }

    /// Keeps the keys that neither what was read has nor `others`.
    fn keep_unknown(&mut self, root: &Map<String, Value>, read: &impl Serialize, others: &[&str]) {
        let known = serde_json::to_value(read).expect("paths of JSON are text");
        let unknown = |key: &str| known.get(key).is_none() && !others.contains(&key);
        self.unknown.extend(root.iter().filter(|(key, _)| unknown(key)).map(|(k, v)| (k.clone(), v.clone())));
    }

    fn materials(&mut self, root: &Map<String, Value>) -> SessionMaterials {
        SessionMaterials {
            materials: self.list(root, "materials", material_template),
            added: self.choice(root, "added"),
            assigned: self.list(root, "assigned", |_| SessionAssignment::default()),
        }
    }

    fn light(&mut self, root: &Map<String, Value>) -> SessionLight {
        SessionLight {
            environment: self.part(root, "environment", Default::default()),
            lights: root.get("lights").map(|_| self.list(root, "lights", light_template)),
            components: self.part(root, "components", Default::default()),
            solution: self.choice(root, "solution"),
        }
    }

    fn camera(&mut self, root: &Map<String, Value>) -> Option<SessionCamera> {
        root.get("camera").map(|_| self.part(root, "camera", SessionCamera::default()))
    }

    /// The looks. Each is read as the session is, with the keys that it has.
    fn looks(&mut self, root: &Map<String, Value>) -> Vec<SessionLook> {
        let Some(given) = root.get("looks") else { return Vec::new() };
        let Value::Array(given) = given else {
            self.warnings.push(refusal("looks", given));
            return Vec::new();
        };
        let (mut looks, mut unknown) = (Vec::new(), Vec::new());
        for (i, given) in given.iter().enumerate() {
            let Value::Object(given) = given else {
                self.warnings.push(format!("looks[{i}] is no object; it is left out"));
                continue;
            };
            let mut reader = Self::default();
            looks.push(reader.look(given));
            self.warnings.extend(reader.warnings.into_iter().map(|warning| format!("looks[{i}]: {warning}")));
            reader.unknown.insert("name".into(), looks.last().map_or("", |look| &look.name).into());
            unknown.push(Value::from(reader.unknown));
        }
        if unknown.iter().any(|kept| kept.as_object().is_some_and(|kept| kept.len() > 1)) {
            self.unknown.insert("looks".into(), unknown.into());
        }
        looks
    }

    /// What is unknown of looks goes by the names that they have got.
    fn rename_unknown(&mut self, looks: &[SessionLook]) {
        let Some(Value::Array(unknown)) = self.unknown.get_mut("looks") else { return };
        unknown.iter_mut().zip(looks).for_each(|(unknown, look)| unknown["name"] = look.name.clone().into());
    }

    fn look(&mut self, given: &Map<String, Value>) -> SessionLook {
        let look = SessionLook {
            name: self.choice(given, "name"),
            materials: given.contains_key("materials").then(|| self.materials(given)),
            light: given.contains_key("environment").then(|| self.light(given)),
            camera: self.camera(given),
            view: given.get("view").map(|_| self.part(given, "view", Default::default())),
        };
        self.keep_unknown(given, &look, &[]);
        look
    }

    fn path(&mut self, root: &Map<String, Value>, key: &str) -> Option<PathBuf> {
        match root.get(key)? {
            Value::Null => None,
            Value::String(path) => Some(path.into()),
            other => {
                self.warnings.push(refusal(key, other));
                None
            }
        }
    }

    fn choice<T: DeserializeOwned + Default>(&mut self, root: &Map<String, Value>, key: &str) -> T {
        let Some(given) = root.get(key) else { return T::default() };
        T::deserialize(given).unwrap_or_else(|_| {
            self.warnings.push(refusal(key, given));
            T::default()
        })
    }

    fn part<T: Serialize + DeserializeOwned>(&mut self, root: &Map<String, Value>, key: &str, template: T) -> T {
        let Some(given) = root.get(key) else { return template };
        let (part, unknown) = read_leniently(given, template, key, &mut self.warnings);
        if !unknown.is_empty() {
            self.unknown.insert(key.into(), unknown.into());
        }
        part
    }

    /// Entries with unknown keys keep their names beside the keys, to match them when writing back.
    fn list<T: Serialize + DeserializeOwned>(
        &mut self,
        root: &Map<String, Value>,
        key: &str,
        template: impl Fn(&Value) -> T,
    ) -> Vec<T> {
        let Some(given) = root.get(key) else { return Vec::new() };
        let Value::Array(given) = given else {
            self.warnings.push(refusal(key, given));
            return Vec::new();
        };
        let (mut read, mut unknown) = (Vec::new(), Vec::new());
        for (i, entry) in given.iter().enumerate() {
            let (part, mut kept) = read_leniently(entry, template(entry), &format!("{key}[{i}]"), &mut self.warnings);
            read.push(part);
            kept.insert("name".into(), entry.get("name").cloned().unwrap_or_default());
            unknown.push(Value::from(kept));
        }
        if unknown.iter().any(|kept| kept.as_object().is_some_and(|kept| kept.len() > 1)) {
            self.unknown.insert(key.into(), unknown.into());
        }
        read
    }
}

/// A material with the parameters and slots of `given`, so that their values are read one by one too.
fn material_template(given: &Value) -> SessionMaterial {
    let file = given.get("file").map(|_| BrdfFile::unread(""));
    let vertex_colors = given.get("vertex_colors").is_some();
    let mut template = SessionMaterial { file, vertex_colors, ..Default::default() };
    let named = |key| given.get(key).and_then(Value::as_object).into_iter().flatten();
    // The parameters of a BRDF file are known only once it is read.
    let may_declare = given.get("file").and_then(Value::as_str).is_some_and(|file| file.ends_with(".wgsl"));
    for (name, value) in named("parameters") {
        match BrdfModel::declared(name) {
            Some(parameter) => template.parameters.set(parameter.name, parameter.default),
            None if may_declare && value.is_number() => template.parameters.set(name.clone(), 0.0),
            None if may_declare && value.is_array() => template.parameters.set(name.clone(), Vec3::ZERO),
            None => {}
        }
    }
    let known = || BrdfModel::ALL.iter().flat_map(|&model| map_names(model));
    for (name, slot) in named("maps").filter(|(_, slot)| slot.is_object()) {
        if may_declare || known().any(|known| known == name) {
            template.maps.set(name.clone(), Some(slot_template(slot)));
        }
    }
    template
}

/// A slot with all that `given` has: what is as by default is not written, and so has no place.
fn slot_template(given: &Value) -> SessionSlot {
    let procedural = given.get("procedural").filter(|pattern| pattern.is_object()).map(|_| Procedural::default());
    let wrap = if given.get("wrap").is_some() { [Wrap::Mirror; 2] } else { Default::default() };
    let uv_set = if given.get("uv_set").is_some() { UvSet::Second } else { UvSet::First };
    SessionSlot { procedural, wrap, uv_set, ..Default::default() }
}

/// A light with the fields of its kind.
fn light_template(given: &Value) -> Light {
    let kind = given.get("kind").and_then(Value::as_str);
    let kind = LightKind::ALL.into_iter().find(|k| kind == Some(&k.label().to_lowercase()));
    Light {
        emission: kind.map_or(Emission::Point, |kind| kind.emission(1.0)),
        target: Vec3::NEG_Y,
        ..Default::default()
    }
}
