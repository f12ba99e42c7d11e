//! The data that an artist edits and a session file stores, changed only by [`Edit`]s.

pub mod autosave;
mod components;
mod edit;
mod environment;
pub mod fitting;
pub mod handling;
mod history;
pub mod library;
pub mod lights;
pub mod looks;
pub mod objects;
pub mod parts;
mod path_list;
pub mod recent;
mod relative;
pub mod session;
mod view;

pub use components::{Component, ComponentSettings, Unlit};
pub use edit::Edit;
pub use environment::{EnvironmentSettings, Orientation, SunChoice};
pub use history::History;
pub use path_list::write_setting;
pub use relative::{absolute, folder_of};
pub use view::{ASPECTS, BackgroundKind, ShownMaterials, ViewSettings};

use glam::Vec3;
use handling::HandlingOfObjects;
use lapidary_core::{
    animation::ClipTime,
    camera::Camera,
    dataset::{BakeParts, BakeSettings, Dataset},
    ground::Ground,
    lights::Light,
    material::Material,
    scene::{Scene, pose::Poses},
    texture::Texture,
};
use lapidary_precompute::Preset;
use lapidary_render::{Appearance, Solution};
use looks::NamedLook;
use objects::ObjectNumbers;
use parts::Assignment;
use std::{path::PathBuf, sync::Arc};

/// Everything that is edited, as it is now. Copying it copies no texels.
#[derive(Clone, Debug)]
pub struct Document {
    /// The scene file that is baked; `None` for a dataset opened by itself.
    pub scene: Option<PathBuf>,
    /// Which of the scenes in the file, by name or number; `None` for its default.
    pub scene_in_file: Option<String>,
    /// The dataset that is shown; `None` until there is a bake.
    pub dataset: Option<PathBuf>,
    /// One for each material index of the mesh, then the added ones.
    pub materials: Vec<Material>,
    /// Number of added materials, which come last.
    pub added: usize,
    /// Parts with another material than the mesh's.
    pub assigned: Assignment,
    /// Names of the scene's objects.
    pub objects: Vec<String>,
    /// Objects moved from their place in the file.
    pub poses: Poses,
    /// How objects are handled otherwise than usual.
    pub handling: HandlingOfObjects,
    /// The shown time of an animation; `None` at rest.
    pub clip_time: Option<ClipTime>,
    /// The material of the ground while none is shown.
    pub hidden_ground: Option<Material>,
    /// Textures that the materials' maps refer to by index. The list only grows while a document is open, so that undoing an edit
    /// finds its texture again; sessions keep the textures in use.
    pub textures: Vec<TextureEntry>,
    /// The environment.
    pub environment: EnvironmentSettings,
    /// Local lights.
    pub lights: Vec<Light>,
    /// Which parts of the light are in the picture.
    pub components: ComponentSettings,
    /// How bounced light is computed, if the dataset has it.
    pub solution: Solution,
    /// The camera. Moving it is not a step of undo, as in other tools.
    pub camera: Camera,
    /// Cameras to go back to, by name.
    pub bookmarks: Vec<Camera>,
    /// Looks to go back to, each with its own name.
    pub looks: Vec<NamedLook>,
    /// How the picture is made and shown.
    pub view: ViewSettings,
    /// Settings of the next bake.
    pub bake: BakeSettings,
}

/// A texture and its origin.
#[derive(Clone, Debug)]
pub struct TextureEntry {
    /// The texels.
    pub texture: Arc<Texture>,
    /// The file it was loaded from; `None` if it came with the scene.
    pub file: Option<PathBuf>,
}

impl Document {
    /// An empty document: nothing is open.
    pub fn empty() -> Self {
        Self {
            scene: None,
            scene_in_file: None,
            dataset: None,
            materials: Vec::new(),
            added: 0,
            assigned: Assignment::new(),
            objects: Vec::new(),
            poses: Poses::default(),
            handling: HandlingOfObjects::new(),
            clip_time: None,
            hidden_ground: None,
            textures: Vec::new(),
            environment: EnvironmentSettings::default(),
            lights: Vec::new(),
            components: ComponentSettings::default(),
            solution: Solution::default(),
            camera: Camera::look_at(Vec3::new(0.0, 0.5, 2.0), Vec3::ZERO, 40.0),
            bookmarks: Vec::new(),
            looks: Vec::new(),
            view: ViewSettings::default(),
            bake: Preset::Normal.settings(),
        }
    }

    /// The name of a material, or its number if it has none.
    pub fn material_name(&self, index: usize) -> String {
        match self.materials.get(index) {
            Some(material) if !material.name.is_empty() => material.name.clone(),
            _ => format!("Material {}", index + 1),
        }
    }

    /// The name of an object, or "object" if it has none.
    pub fn object_name(&self, object: u32) -> &str {
        let name = self.objects.get(object as usize).filter(|name| !name.is_empty());
        name.map_or("object", String::as_str)
    }

    /// The file of a texture: its own, or a file of its name beside the scene. It need not exist: pictures inside a scene's file
    /// have names too.
    pub fn file_of(&self, entry: &TextureEntry) -> Option<PathBuf> {
        let beside_scene = || Some(folder_of(self.scene.as_deref()?).join(&entry.texture.name));
        entry.file.clone().or_else(beside_scene)
    }

    /// A document for a new scene, with its own lights, the settings of the fastest useful bake, and all its cameras
    /// bookmarked. The view is that of its first camera, or of the whole scene.
    pub fn of_scene(scene: &Scene, path: Option<PathBuf>) -> Self {
        let entry = |texture: &Arc<Texture>| TextureEntry { texture: texture.clone(), file: None };
        let document = Self {
            scene: path,
            materials: scene.materials.clone(),
            objects: objects::names_of(scene),
            textures: scene.textures.iter().map(entry).collect(),
            lights: scene.lights.clone(),
            bake: proposed_bake(scene),
            camera: scene.first_view(),
            bookmarks: scene.cameras.clone(),
            ..Self::empty()
        };
        document.with_opacities_of_parts(scene)
    }

    /// A document for a dataset, with the settings of its bake. If it was for shots, the first is the view, and all are bookmarked.
    pub fn of_dataset(dataset: &Dataset, dataset_path: PathBuf, scene_path: Option<PathBuf>) -> Self {
        let mut document = Self::of_scene(&dataset.scene, scene_path);
        let views = dataset.shot_views();
        document.camera = views.first().cloned().unwrap_or(document.camera);
        document.bookmarks.extend(views.into_iter().filter(|view| !dataset.scene.cameras.contains(view)));
        Self { dataset: Some(dataset_path), ..document.with_bake(dataset) }
    }

    /// With the settings, the poses and the time of a bake of its scene.
    pub fn with_bake(self, dataset: &Dataset) -> Self {
        let numbers = ObjectNumbers::between(&objects::names_of(&dataset.scene), &self.objects);
        Self {
            bake: dataset.settings.clone(),
            poses: dataset.scene.placed_poses().renumbered(|object| numbers.of(object)),
            clip_time: dataset.scene.clip_time.clone(),
            ..self
        }
    }

    /// Materials and textures for the renderers, as the view shows them.
    pub fn appearance(&self) -> Appearance {
        // If another bake lacks the solo material, all show their own.
        let materials = match self.view.materials {
            ShownMaterials::Solo(index) if index >= self.materials.len() => ShownMaterials::Own,
            shown => shown,
        };
        // Opacity stays in any shown material.
        let shown = |(index, own): (usize, &Material)| {
            let mut shown = materials.instead_of(index, own);
            shown.take_opacity(own, |slot| Some(slot.clone()));
            shown
        };
        Appearance {
            materials: self.materials.iter().enumerate().map(shown).collect(),
            textures: self.shared_textures(),
            assigned: None,
        }
    }

    /// Its textures, which materials refer to by index.
    pub fn shared_textures(&self) -> Vec<Arc<Texture>> {
        self.textures.iter().map(|entry| entry.texture.clone()).collect()
    }
}

/// `material` in place of `target`, which keeps its name and its sides: which sides reflect was baked.
pub fn in_place_of(target: &Material, material: Material) -> Material {
    Material { name: target.name.clone(), double_sided: target.double_sided, ..material }
}

/// The fastest useful bake: surface sources for a scene with its own lights, the environment for other scenes, and a ground
/// that catches shadows under a lone object. More can be chosen.
pub fn proposed_bake(scene: &Scene) -> BakeSettings {
    let mode = if scene.lights.is_empty() { BakeParts::ENVIRONMENT } else { BakeParts::INDIRECT };
    let ground = Ground::suiting(&scene.mesh);
    BakeSettings { mode, ground, ..Preset::Normal.settings_for(scene.mesh.positions.len()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{
        brdf::Parameters,
        shot::Shot,
        test_scenes::{self, camera, dataset},
    };

    #[test]
    fn materials_are_shown_as_others_and_stay_as_they_are() {
        let own = |name: &str, double_sided| Material {
            name: name.into(),
            parameters: Parameters::default().with("base_color", Vec3::X),
            double_sided,
            ..Default::default()
        };
        let mut document = Document { materials: vec![own("a", false), own("b", true)], ..Document::empty() };
        let colors = |document: &Document| {
            document.appearance().materials.iter().map(|m| m.parameters.color("base_color")).collect::<Vec<_>>()
        };
        assert_eq!(colors(&document), [Vec3::X; 2]);
        for (shown, expected) in [
            (ShownMaterials::Gray, [Vec3::splat(0.18); 2]),
            (ShownMaterials::Clay, [Vec3::splat(0.5); 2]),
            (ShownMaterials::Chrome, [Vec3::splat(0.65); 2]),
            (ShownMaterials::Solo(1), [Vec3::splat(0.5), Vec3::X]),
            (ShownMaterials::Solo(7), [Vec3::X; 2]),
        ] {
            document.view.materials = shown;
            assert_eq!(colors(&document), expected, "{shown:?}");
            let sides: Vec<bool> = document.appearance().materials.iter().map(|m| m.double_sided).collect();
            assert_eq!(sides, [false, true], "sides are baked");
        }
        assert_eq!(document.materials[0], own("a", false));
        let text = serde_json::to_string(&document.view).unwrap();
        assert_eq!(serde_json::from_str::<ViewSettings>(&text).unwrap(), document.view);
    }

    #[test]
    fn a_scene_with_lights_is_proposed_a_bake_of_their_bounce() {
        let mut scene = dataset(&["a"], &[]).scene;
        assert_eq!(Document::of_scene(&scene, None).bake, Preset::Normal.settings());
        scene.lights = vec![test_scenes::light()];
        let bake = Document::of_scene(&scene, None).bake;
        assert_eq!(bake, BakeSettings { mode: BakeParts::INDIRECT, ..Preset::Normal.settings() });
    }

    #[test]
    fn a_dataset_opens_at_its_first_camera_with_all_of_them_bookmarked() {
        let mut dataset = dataset(&["a", "b"], &["wood.png"]);
        dataset.scene.cameras = vec![camera("front"), camera("back")];
        let document = Document::of_dataset(&dataset, "a.cuts".into(), Some("a.gltf".into()));
        assert_eq!(document.camera.name, "front");
        assert_eq!(document.bookmarks, dataset.scene.cameras);
        assert_eq!((document.materials.len(), document.textures.len()), (2, 1));
        assert_eq!(document.bake, dataset.settings);
        assert_eq!((document.scene, document.dataset), (Some("a.gltf".into()), Some("a.cuts".into())));
    }

    #[test]
    fn a_dataset_baked_for_shots_opens_at_the_first_with_all_of_them_bookmarked() {
        let mut dataset = dataset(&["a"], &[]);
        dataset.scene.cameras = vec![camera("front"), camera("back")];
        let shot = |camera: Camera| Shot { camera, aspect: 1.5 };
        let unnamed = Camera { eye: Vec3::splat(7.0), ..camera("") };
        dataset.settings.shots = vec![shot(unnamed.clone()), shot(camera("back"))];
        let document = Document::of_dataset(&dataset, "a.cuts".into(), None);
        let first = Camera { name: "Shot 1".into(), ..unnamed };
        assert_eq!(document.camera, first);
        assert_eq!(document.bookmarks, [camera("front"), camera("back"), first]);
    }

    #[test]
    fn without_cameras_the_whole_scene_is_framed() {
        let dataset = dataset(&["a"], &[]);
        let document = Document::of_dataset(&dataset, "a.cuts".into(), None);
        assert!((document.camera.target - dataset.scene.mesh.bounds().center()).length() < 1e-6);
        assert!(document.bookmarks.is_empty());
    }

    #[test]
    fn formulas_are_told_from_files() {
        let file = |spec: &str| EnvironmentSettings { spec: spec.into(), ..Default::default() }.file().is_some();
        assert!(!["studio", "sun-sky:30", "constant:1,1,1", "orientation"].into_iter().any(file));
        assert!(["studio.hdr", "C:\\maps\\a.exr", "/maps/constant"].into_iter().all(file));
    }
}
