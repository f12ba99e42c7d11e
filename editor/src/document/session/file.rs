//! Contents of a session file as plain data: degrees instead of radians, textures by their source.

use crate::document::{
    ComponentSettings, Document, EnvironmentSettings, ViewSettings,
    handling::Handling,
    looks::{LightOfLook, LookState, MaterialsOfLook, NamedLook},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    animation::ClipTime,
    camera::{Camera, Lens},
    dataset::BakeSettings,
    lights::Light,
    material::{Material, MaterialOf},
    parts::Part,
    scene::pose::Pose,
    texture::{Channel, ColorSpace, Procedural, TextureSlot, UvSet, Wrap, is_default},
};
use lapidary_render::Solution;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The parts of a document; paths are absolute in memory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Session {
    /// The scene file.
    pub scene: Option<PathBuf>,
    /// Which of the scenes in the file; `None` for its default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene_in_file: Option<String>,
    /// The dataset.
    pub dataset: Option<PathBuf>,
    /// The materials.
    #[serde(flatten)]
    pub materials: SessionMaterials,
    /// Objects moved from their place in the file.
    pub poses: Vec<SessionPose>,
    /// Objects that are handled otherwise than usual.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub handling: Vec<SessionHandling>,
    /// The shown time of an animation; `None` at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip_time: Option<ClipTime>,
    /// The light.
    #[serde(flatten)]
    pub light: SessionLight,
    /// The camera; `None` for the dataset's.
    pub camera: Option<SessionCamera>,
    /// Cameras to go back to.
    pub bookmarks: Vec<SessionCamera>,
    /// Looks to go back to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub looks: Vec<SessionLook>,
    /// How the picture is made and shown.
    pub view: ViewSettings,
    /// Settings of the next bake.
    pub bake: BakeSettings,
}

/// The materials of a document or a look.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SessionMaterials {
    /// In the order of the dataset, then the added ones.
    pub materials: Vec<SessionMaterial>,
    /// Number of added materials.
    pub added: usize,
    /// Parts with another material than the mesh's.
    pub assigned: Vec<SessionAssignment>,
}

/// The light of a document or a look.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionLight {
    /// The environment.
    pub environment: EnvironmentSettings,
    /// Local lights; `None`, in old files, for the scene's.
    pub lights: Option<Vec<Light>>,
    /// The parts of the light in the picture.
    pub components: ComponentSettings,
    /// How bounced light is computed.
    pub solution: Solution,
}

/// A look to go back to. What it lacks stays as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionLook {
    /// Its name.
    pub name: String,
    #[serde(flatten)]
    pub materials: Option<SessionMaterials>,
    #[serde(flatten)]
    pub light: Option<SessionLight>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<SessionCamera>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<ViewSettings>,
}

/// See [`Material`].
pub type SessionMaterial = MaterialOf<SessionSlot>;

/// The pose of an object, see [`Pose`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionPose {
    /// The object's name, which decides if another object has its index.
    pub name: String,
    /// Index of the object.
    pub object: u32,
    pub translate: Vec3,
    pub rotate_degrees: Vec3,
    pub scale: f32,
    /// Whether the object is hidden.
    pub hidden: bool,
}

impl Default for SessionPose {
    fn default() -> Self {
        Self::new(String::new(), 0, Pose::AS_BAKED)
    }
}

impl SessionPose {
    /// The pose of an object.
    pub fn new(name: String, object: u32, pose: Pose) -> Self {
        let Pose { translate, rotate_degrees, scale, hidden } = pose;
        Self { name, object, translate, rotate_degrees, scale, hidden }
    }

    /// The pose in a document.
    pub fn pose(&self) -> Pose {
        let Self { translate, rotate_degrees, scale, hidden, .. } = *self;
        Pose { translate, rotate_degrees, scale, hidden }
    }
}

/// How an object is handled, see [`Handling`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionHandling {
    /// The object's name, which decides if another object has its index.
    pub name: String,
    /// Index of the object.
    pub object: u32,
    #[serde(flatten)]
    pub own: Handling,
}

/// A part with another material than the mesh's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionAssignment {
    /// The object's name, which decides if another has its index.
    pub name: String,
    /// Index of the object.
    pub object: u32,
    /// The mesh's material, by index in the session.
    pub own: usize,
    /// Its material, by index in the session.
    pub material: usize,
}

/// See [`TextureSlot`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionSlot {
    /// Which picture.
    pub texture: Option<TextureSource>,
    /// Color space of 8-bit texels.
    pub color_space: ColorSpace,
    /// Component for scalar parameters.
    pub channel: Channel,
    /// Repetitions across the unit square.
    pub scale: Vec2,
    /// Added after scaling and rotating.
    pub offset: Vec2,
    /// Counter-clockwise rotation of the coordinates in degrees.
    pub rotation_degrees: f64,
    /// Scales normals and heights.
    pub strength: f32,
    /// Whether the green channel of normals points down.
    pub flip_y: bool,
    /// A pattern in place of a picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub procedural: Option<Procedural>,
    /// Along u and v.
    #[serde(skip_serializing_if = "is_default")]
    pub wrap: [Wrap; 2],
    /// The texture coordinates of the surface.
    #[serde(skip_serializing_if = "is_default")]
    pub uv_set: UvSet,
}

/// Origin of a texture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TextureSource {
    /// A picture that was loaded.
    File(PathBuf),
    /// A texture that came with the scene and lies in the dataset.
    Scene {
        /// Index among the scene's textures.
        index: u32,
        /// Its name there, which decides if another texture has the index.
        name: String,
    },
}

/// See [`Camera`], whose fields these are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionCamera {
    pub name: String,
    pub eye: Vec3,
    pub target: Vec3,
    pub up: Vec3,
    pub fov_y_degrees: f64,
    pub lens: Lens,
}

impl Session {
    /// The parts of `document`; no texels.
    pub fn of(document: &Document) -> Self {
        let pose = |object: u32| SessionPose::new(name_of(document, object), object, document.poses.of(object));
        let handling =
            |(&object, &own): (&u32, &Handling)| SessionHandling { name: name_of(document, object), object, own };
        Self {
            scene: document.scene.clone(),
            scene_in_file: document.scene_in_file.clone(),
            dataset: document.dataset.clone(),
            materials: SessionMaterials::of(&MaterialsOfLook::of(document), document),
            poses: document.poses.moved().map(pose).collect(),
            handling: document.handling.iter().map(handling).collect(),
            clip_time: document.clip_time.clone(),
            light: LightOfLook::of(document).into(),
            camera: Some((&document.camera).into()),
            bookmarks: document.bookmarks.iter().map(Into::into).collect(),
            looks: document.looks.iter().map(|look| SessionLook::of(look, document)).collect(),
            view: document.view.clone(),
            bake: document.bake.clone(),
        }
    }

    /// Calls `visit` with the kind and path of every file that the session names; it may change the path.
    pub fn visit_paths(&mut self, visit: &mut dyn FnMut(&'static str, &mut PathBuf)) {
        self.scene.iter_mut().for_each(|path| visit("scene", path));
        self.dataset.iter_mut().for_each(|path| visit("dataset", path));
        let views = [&mut self.view].into_iter().chain(self.looks.iter_mut().filter_map(|look| look.view.as_mut()));
        views.filter_map(|view| view.backplate.as_mut()).for_each(|path| visit("background picture", path));
        for light in self.lights_mut() {
            if let Some(mut path) = light.environment.file().map(PathBuf::from) {
                visit("environment", &mut path);
                light.environment.spec = path.to_string_lossy().into_owned();
            }
        }
        for material in self.materials_mut() {
            material.file.iter_mut().for_each(|file| visit("BRDF", &mut file.path));
            for slot in material.maps.slots_mut() {
                if let Some(TextureSource::File(path)) = &mut slot.texture {
                    visit("texture", path);
                }
            }
        }
    }

    /// The light of the document and of its looks.
    fn lights_mut(&mut self) -> impl Iterator<Item = &mut SessionLight> {
        [&mut self.light].into_iter().chain(self.looks.iter_mut().filter_map(|look| look.light.as_mut()))
    }

    /// All materials, also of its looks.
    pub fn materials_mut(&mut self) -> impl Iterator<Item = &mut SessionMaterial> {
        let of_looks = self.looks.iter_mut().filter_map(|look| look.materials.as_mut());
        [&mut self.materials].into_iter().chain(of_looks).flat_map(|of_look| &mut of_look.materials)
    }

    /// The assignments of the document and of its looks.
    pub fn assigned(&self) -> impl Iterator<Item = &SessionAssignment> {
        let of_looks = self.looks.iter().filter_map(|look| look.materials.as_ref());
        [&self.materials].into_iter().chain(of_looks).flat_map(|of_look| &of_look.assigned)
    }
}

impl SessionMaterials {
    /// The materials of a document, or of one of its looks.
    fn of(of_look: &MaterialsOfLook, document: &Document) -> Self {
        let MaterialsOfLook { materials, added, assigned, hidden_ground } = of_look;
        // The ground's material is the last of the scene.
        let (own, rest) = materials.split_at(materials.len().saturating_sub(*added));
        let hidden = usize::from(hidden_ground.is_some());
        let index = |index: usize| if index < own.len() { index } else { index + hidden };
        // Parts of a hidden ground or with a removed material are left out.
        let is_there = |(_, material): &(&Part, &usize)| **material < materials.len();
        let assignment = |(part, material): (&Part, &usize)| SessionAssignment {
            name: name_of(document, part.object),
            object: part.object,
            own: part.material as usize,
            material: index(*material),
        };
        let material = |material: &Material| session_material(material, document);
        Self {
            materials: own.iter().chain(hidden_ground).chain(rest).map(material).collect(),
            added: rest.len(),
            assigned: assigned.iter().filter(is_there).map(assignment).collect(),
        }
    }
}

impl From<LightOfLook> for SessionLight {
    fn from(LightOfLook { environment, lights, components, solution }: LightOfLook) -> Self {
        Self { environment, lights: Some(lights), components, solution }
    }
}

impl SessionLook {
    fn of(NamedLook { name, state }: &NamedLook, document: &Document) -> Self {
        let LookState { materials, light, camera, view } = state;
        Self {
            name: name.clone(),
            materials: materials.as_ref().map(|materials| SessionMaterials::of(materials, document)),
            light: light.clone().map(Into::into),
            camera: camera.as_ref().map(Into::into),
            view: view.clone(),
        }
    }
}

/// The name of an object, or nothing.
fn name_of(document: &Document, object: u32) -> String {
    document.objects.get(object as usize).cloned().unwrap_or_default()
}

/// A material of `document`, whose maps name pictures.
fn session_material(material: &Material, document: &Document) -> SessionMaterial {
    material.with_maps(material.maps.filter_map(|slot| SessionSlot::of(slot, document)))
}

/// The material, with the textures that `index_of` finds.
pub(super) fn document_material(
    material: &SessionMaterial,
    mut index_of: impl FnMut(&TextureSource) -> u32,
) -> Material {
    let slot = |slot: &SessionSlot| match &slot.texture {
        Some(source) => Some(slot.texture_slot(index_of(source))),
        None => slot.procedural.is_some().then(|| slot.texture_slot(0)),
    };
    material.with_maps(material.maps.filter_map(slot))
}

impl SessionSlot {
    /// `None` if the document does not have the texture.
    fn of(slot: &TextureSlot, document: &Document) -> Option<Self> {
        let Some(image) = slot.image() else { return Some(slot.into()) };
        let entry = document.textures.get(image)?;
        let source = match &entry.file {
            Some(file) => TextureSource::File(file.clone()),
            None => TextureSource::Scene { index: slot.texture, name: entry.texture.name.clone() },
        };
        Some(Self { texture: Some(source), ..slot.into() })
    }

    fn texture_slot(&self, texture: u32) -> TextureSlot {
        TextureSlot {
            texture,
            color_space: self.color_space,
            channel: self.channel,
            scale: self.scale,
            offset: self.offset,
            rotation: self.rotation_degrees.to_radians() as f32,
            strength: self.strength,
            flip_y: self.flip_y,
            procedural: self.procedural.map(Procedural::sanitized),
            wrap: self.wrap,
            uv_set: self.uv_set,
        }
    }
}

/// All but the texture.
impl From<&TextureSlot> for SessionSlot {
    fn from(slot: &TextureSlot) -> Self {
        Self {
            texture: None,
            color_space: slot.color_space,
            channel: slot.channel,
            scale: slot.scale,
            offset: slot.offset,
            rotation_degrees: degrees(slot.rotation),
            strength: slot.strength,
            flip_y: slot.flip_y,
            procedural: slot.procedural,
            wrap: slot.wrap,
            uv_set: slot.uv_set,
        }
    }
}

impl Default for SessionSlot {
    fn default() -> Self {
        (&TextureSlot::default()).into()
    }
}

impl From<&Camera> for SessionCamera {
    fn from(camera: &Camera) -> Self {
        Self {
            name: camera.name.clone(),
            eye: camera.eye,
            target: camera.target,
            up: camera.up,
            fov_y_degrees: degrees(camera.fov_y),
            lens: camera.lens,
        }
    }
}

impl From<&SessionCamera> for Camera {
    fn from(camera: &SessionCamera) -> Self {
        Self {
            name: camera.name.clone(),
            eye: camera.eye,
            target: camera.target,
            up: camera.up,
            fov_y: camera.fov_y_degrees.to_radians() as f32,
            lens: camera.lens,
        }
    }
}

impl Default for SessionCamera {
    fn default() -> Self {
        (&Document::empty().camera).into()
    }
}

/// Degrees that convert back to exactly the same radians, with few digits if possible.
fn degrees(radians: f32) -> f64 {
    let short = f64::from(radians.to_degrees());
    if short.to_radians() as f32 == radians { short } else { f64::from(radians).to_degrees() }
}
