//! A session survives the disk, moves, other versions and other datasets; damage is refused or reported.

mod brdfs;
mod broken_writes;
mod damage;
mod looks;

use super::*;
use crate::{
    document::{
        BackgroundKind, Component, ComponentSettings, Document, EnvironmentSettings, TextureEntry, ViewSettings,
        handling::{Handling, PlacedPivot},
        lights::LightKind,
    },
    test_support::write_picture,
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::GgxParameters,
    dataset::{BakeSettings, Dataset},
    lights::Light,
    material::{BrdfModel, Material, MaterialMaps},
    opacity::PartOpacity,
    parts::Part,
    scene::{Object, pose::Pose},
    test_scenes::{camera, dataset, light},
    texture::{Channel, ColorSpace, Procedural, Texture, TextureSlot, UvSet, Wrap},
};
use lapidary_interchange::image;
use lapidary_render::{Post, Solution, ToneMap};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A folder with a scene, its dataset, an environment and a picture, and a place for sessions.
struct Project {
    folder: tempfile::TempDir,
    dataset: Dataset,
}

impl Project {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["sessions", "maps"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
        }
        for name in ["a.gltf", "a.cuts", "maps/room.hdr"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        write_picture(&folder.path().join("maps/linen.png"));
        Self { folder, dataset: dataset(&["glaze", "cloth", "wood"], &["own.png", "own.png", "grain.png"]) }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn file(&self) -> PathBuf {
        self.path("sessions/evening.lapidary")
    }

    /// A document without any default value.
    fn document(&self) -> Document {
        let mut document = Document::of_dataset(&self.dataset, self.path("a.cuts"), Some(self.path("a.gltf")));
        let picture = self.path("maps/linen.png");
        let texture = image::read_texture(&picture).unwrap().into();
        document.textures.push(TextureEntry { texture, file: Some(picture) });
        document.materials[1] = Material {
            file: None,
            name: "cloth".into(),
            model: BrdfModel::Ward,
            parameters: GgxParameters { base_color: Vec3::new(0.8, 0.1, 0.3), roughness: 0.35, ..Default::default() }
                .into(),
            maps: MaterialMaps::from([
                ("base_color", TextureSlot { color_space: ColorSpace::Srgb, uv_set: UvSet::Second, ..slot(3) }),
                ("bump", TextureSlot { channel: Channel::G, rotation: 0.3, strength: 0.002, ..slot(1) }),
                ("anisotropy", TextureSlot { channel: Channel::B, ..slot(3) }),
                (
                    "ior",
                    TextureSlot { channel: Channel::A, wrap: [Wrap::Clamp, Wrap::Mirror], offset: Vec2::X, ..slot(1) },
                ),
                ("roughness", TextureSlot { procedural: Some(Procedural::default()), ..slot(0) }),
            ]),
            double_sided: false,
            vertex_colors: true,
        };
        document.environment = EnvironmentSettings {
            spec: self.path("maps/room.hdr").to_string_lossy().into_owned(),
            color_space: ColorSpace::AcesCg,
            rotation_degrees: 12.5,
            intensity: 0.7,
            orientation: crate::document::Orientation::Blender,
            sun: crate::document::SunChoice { enabled: false, threshold: 50.0, largest_degrees: 3.0 },
        };
        document.lights = LightKind::ALL.map(|kind| Light { emission: kind.emission(0.3), ..light() }).into();
        document.lights[1].enabled = false;
        document.components =
            ComponentSettings { direct: false, solo: Some(Component::Indirect), ..ComponentSettings::default() };
        document.solution = Solution::CutsMeshless;
        document.camera = camera("");
        document.bookmarks = vec![camera("front"), camera("back")];
        document.view = ViewSettings {
            post: Post { exposure: -0.3, tone_map: ToneMap::AgX, vignette: 0.4 },
            background: BackgroundKind::Blurred,
            aspect: Some(2.0),
            illum_cut: 400,
            tau: 0.02,
            ..Default::default()
        };
        let shots = vec![lapidary_core::shot::Shot { camera: document.camera.clone(), aspect: 1.5 }];
        document.bake = BakeSettings { max_bytes: Some(1 << 30), beta: 0.3, shots, ..document.bake };
        document
    }

    /// Saves and reads back.
    fn reloaded(&self, document: &Document) -> LoadedSession {
        save(document, &Unknown::default(), &self.file()).unwrap();
        load(&self.file()).unwrap()
    }

    fn json(&self) -> Value {
        serde_json::from_slice(&std::fs::read(self.file()).unwrap()).unwrap()
    }

    /// Reads the saved document after `change` to its file.
    fn changed(&self, change: impl FnOnce(&mut Value)) -> LoadedSession {
        save(&self.document(), &Unknown::default(), &self.file()).unwrap();
        let mut json = self.json();
        change(&mut json);
        std::fs::write(self.file(), json.to_string()).unwrap();
        load(&self.file()).unwrap()
    }
}

fn slot(texture: u32) -> TextureSlot {
    TextureSlot { texture, scale: Vec2::new(2.0, 3.0), ..Default::default() }
}

fn assert_same(a: &Document, b: &Document) {
    assert_eq!((&a.scene, &a.dataset), (&b.scene, &b.dataset));
    assert_eq!(a.materials, b.materials);
    assert_eq!((a.added, &a.assigned, &a.objects), (b.added, &b.assigned, &b.objects));
    assert_eq!(a.poses, b.poses);
    assert_eq!((&a.environment, &a.view, &a.bake), (&b.environment, &b.view, &b.bake));
    assert_eq!((&a.lights, a.components, a.solution), (&b.lights, b.components, b.solution));
    assert_eq!((&a.camera, &a.bookmarks, &a.looks), (&b.camera, &b.bookmarks, &b.looks));
    let files = |d: &Document| d.textures.iter().map(|t| (t.texture.name.clone(), t.file.clone())).collect::<Vec<_>>();
    assert_eq!(files(a), files(b));
}

#[test]
fn everything_survives_the_disk() {
    let project = Project::new();
    let document = project.document();
    let loaded = project.reloaded(&document);
    assert_eq!((&loaded.missing, &loaded.unknown), (&Vec::new(), &Unknown::default()));
    let (read, warnings) = loaded.into_document(Some(&project.dataset.scene));
    assert_eq!(warnings, Vec::<String>::new());
    assert_same(&read, &document);
    let mut other = document.clone();
    other.materials[1].parameters.set("roughness", 0.350_001);
    assert_ne!(read.materials, other.materials);
}

#[test]
fn what_is_stored_and_not_rendered_survives_the_disk() {
    let project = Project::new();
    let mut document = project.document();
    let cloth = &mut document.materials[1];
    cloth.model = BrdfModel::OpenPbr;
    cloth.parameters.set("subsurface_radius_scale", Vec3::new(0.5, 0.25, 0.125));
    cloth.parameters.set("transmission_weight", 0.625);
    cloth.maps.set("thin_film_thickness", Some(TextureSlot { channel: Channel::G, ..slot(3) }));
    let (read, warnings) = project.reloaded(&document).into_document(Some(&project.dataset.scene));
    assert_eq!(warnings, Vec::<String>::new());
    assert_same(&read, &document);
    document.materials[1].parameters.set("transmission_weight", 0.0);
    assert_ne!(read.materials, document.materials, "negative control");

    document.materials[1].parameters.set("transmission_weight", 0.625);
    save(&document, &Unknown::default(), &project.file()).unwrap();
    let mut json = project.json();
    json["materials"][1]["parameters"]["transmission_weight"] = 7.into();
    std::fs::write(project.file(), json.to_string()).unwrap();
    let loaded = load(&project.file()).unwrap();
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    let (read, _) = loaded.into_document(Some(&project.dataset.scene));
    assert_eq!(read.materials[1].parameters.number("transmission_weight"), 1.0);
}

/// A document with an added material on one of two objects.
fn with_a_part(project: &mut Project) -> Document {
    project.dataset.scene.objects = ["lid", "pot"].map(|name| Object { name: name.into() }).to_vec();
    let mut document = project.document();
    document.materials.push(Material { name: "glaze 2".into(), ..Default::default() });
    (document.added, document.assigned) = (1, [(Part { object: 1, material: 0 }, 3)].into());
    document
}

#[test]
fn materials_of_parts_survive_the_disk_with_and_without_a_scene_and_a_ground() {
    let mut project = Project::new();
    let mut document = with_a_part(&mut project);
    for hidden in [None, Some(Material { name: "Ground".into(), ..Default::default() })] {
        document.hidden_ground = hidden;
        let loaded = project.reloaded(&document);
        let written = project.json();
        assert_eq!(written["assigned"][0]["name"], "pot");
        let (read, warnings) = loaded.clone().into_document(Some(&project.dataset.scene));
        assert_eq!(warnings, Vec::<String>::new());
        assert_same(&read, &document);
        assert_eq!(read.hidden_ground, document.hidden_ground);
        let (alone, _) = loaded.into_document(None);
        save(&alone, &Unknown::default(), &project.file()).unwrap();
        assert_eq!((&project.json()["assigned"], &project.json()["added"]), (&written["assigned"], &written["added"]));
    }
}

#[test]
fn a_session_finds_parts_by_the_name_of_their_object_and_drops_what_is_not_there() {
    let mut project = Project::new();
    let document = with_a_part(&mut project);
    let loaded = project.reloaded(&document);
    let found = |objects: &[&str], change: &dyn Fn(&mut Session)| {
        let mut scene = project.dataset.scene.clone();
        scene.objects = objects.iter().map(|&name| Object { name: name.into() }).collect();
        scene.materials.swap(0, 2);
        let mut loaded = loaded.clone();
        change(&mut loaded.session);
        loaded.into_document(Some(&scene)).0.assigned
    };
    let moved = [(Part { object: 0, material: 2 }, 3)].into();
    assert_eq!(found(&["pot", "lid"], &|_| ()), moved, "objects and materials in another order");
    assert!(found(&["lid"], &|_| ()).is_empty());
    assert!(found(&["pot"], &|session| session.materials.assigned[0].material = 4).is_empty());
    assert!(
        found(&["pot"], &|session| session.materials.assigned[0].own = 3).is_empty(),
        "an added one is none of the mesh"
    );
    let none = project.changed(|json| json["added"] = json!(1_000));
    assert_eq!(none.session.materials.added, none.session.materials.materials.len());
}

#[test]
fn a_session_says_which_parts_have_other_materials_whatever_was_baked() {
    let mut project = Project::new();
    let document = project.document();
    project.dataset.scene.objects = vec![Object { name: "pot".into() }];
    let mut glass = Material::default();
    glass.parameters.set("geometry_opacity", 0.5);
    let part = Part { object: 0, material: 0 };
    project.dataset.scene.part_opacities = vec![PartOpacity { parts: vec![part], material: glass }];
    assert_eq!(Document::of_scene(&project.dataset.scene, None).material_of(part), 3, "without a session");
    let (read, _) = project.reloaded(&document).into_document(Some(&project.dataset.scene));
    assert_eq!((read.material_of(part), read.added, read.materials.len()), (0, 0, 3));
}

#[test]
fn poses_survive_the_disk_and_follow_their_objects() {
    let mut project = Project::new();
    let mut document = with_a_part(&mut project);
    let pose = Pose { translate: Vec3::X, rotate_degrees: Vec3::Y * 30.0, scale: 1.5, ..Pose::AS_BAKED };
    document.poses.set(1, pose);
    let loaded = project.reloaded(&document);
    let (read, warnings) = loaded.clone().into_document(Some(&project.dataset.scene));
    assert_eq!(warnings, Vec::<String>::new());
    assert_same(&read, &document);
    let (alone, _) = loaded.clone().into_document(None);
    assert_eq!((alone.poses.of(1), alone.objects[1].as_str()), (pose, "pot"));
    project.dataset.scene.objects.swap(0, 1);
    let (read, _) = loaded.into_document(Some(&project.dataset.scene));
    assert_eq!([0, 1].map(|object| read.poses.of(object)), [pose, Pose::AS_BAKED]);
    let refused = project.changed(|json| json["poses"] = json!([{ "name": "pot", "scale": 0 }]));
    let (read, warnings) = refused.into_document(Some(&project.dataset.scene));
    assert!(read.poses.is_empty() && warnings[0].contains("must be above 0"), "{warnings:?}");
}

#[test]
fn locks_and_pivots_survive_the_disk_and_follow_their_objects() {
    let mut project = Project::new();
    let mut document = with_a_part(&mut project);
    let pivot = PlacedPivot { point: Vec3::new(0.1, -2.0, 0.3), hinge: Some(Vec3::Z) };
    document.handling = [(1, Handling { locked: true, pivot: Some(pivot) })].into();
    let loaded = project.reloaded(&document);
    project.dataset.scene.objects.swap(0, 1);
    let (read, warnings) = loaded.into_document(Some(&project.dataset.scene));
    assert_eq!((read.handling_of(0), warnings.len()), (document.handling_of(1), 0), "{warnings:?}");
    assert_eq!(read.handling_of(1), Handling::default());
    let bad = json!([{ "name": "pot", "locked": true, "pivot": { "point": [0, 0, 0], "hinge": [0, 0, 3] } }]);
    let refused = project.changed(|json| json["handling"] = bad);
    let (read, warnings) = refused.into_document(Some(&project.dataset.scene));
    assert!(read.handling_of(0) == Handling { locked: true, pivot: None }, "{read:?}");
    assert!(warnings[0].contains("\"pot\"") && warnings[0].contains("turns about its center"), "{warnings:?}");
}

#[test]
fn the_file_has_relative_paths_degrees_and_short_numbers() {
    let project = Project::new();
    let mut document = project.document();
    document.view.backplate = Some(project.path("maps/linen.png"));
    let (read, _) = project.reloaded(&document).into_document(Some(&project.dataset.scene));
    assert_eq!(read.view, document.view);
    let json = project.json();
    assert_eq!((&json["lapidary_session"], &json["scene"]), (&json!(2), &json!("../a.gltf")));
    assert_eq!(json["environment"]["spec"], "../maps/room.hdr");
    assert_eq!(json["camera"]["fov_y_degrees"], 35.0);
    assert_eq!(json["view"]["backplate"], "../maps/linen.png");
    let maps = &json["materials"][1]["maps"];
    assert_eq!(maps["base_color"]["texture"], json!({"file": "../maps/linen.png"}));
    assert_eq!(maps["bump"]["texture"], json!({"scene": {"index": 1, "name": "own.png"}}));
    assert_eq!(json["materials"][1]["parameters"]["base_color"], json!([0.8, 0.1, 0.3]));
    assert!(!json.to_string().contains(&*project.folder.path().to_string_lossy()));
}

#[test]
fn a_project_can_move_as_a_whole() {
    let project = Project::new();
    project.reloaded(&project.document());
    let moved = tempfile::tempdir().unwrap();
    let target = moved.path().join("moved");
    std::fs::rename(project.folder.path(), &target).unwrap();
    let loaded = load(&target.join("sessions/evening.lapidary")).unwrap();
    assert_eq!(loaded.missing, []);
    assert_eq!(loaded.session.scene, Some(target.join("a.gltf")));
}

#[test]
fn what_later_versions_add_is_written_back() {
    let project = Project::new();
    let loaded = project.changed(|json| {
        json["fog"] = json!([{"density": 1}]);
        json["lights"][1]["gobo"] = json!("leaves.png");
        json["environment"]["moon"] = json!({"size": 1});
        json["view"]["post"]["grain"] = json!(0.1);
        json["materials"][1]["parameters"]["sheen"] = json!(0.5);
        json["materials"][1]["maps"]["bump"]["blur"] = json!(2);
        json["bake"]["bounces"] = json!(3);
        json["bookmarks"][1]["f_stop"] = json!(8);
    });
    assert_eq!(loaded.warnings, Vec::<String>::new());
    let unknown = loaded.unknown.clone();
    let (mut document, _) = loaded.into_document(Some(&project.dataset.scene));
    document.bookmarks.remove(0);
    save(&document, &unknown, &project.file()).unwrap();
    let json = project.json();
    assert_eq!(json["fog"], json!([{"density": 1}]));
    assert_eq!(json["lights"][1]["gobo"], "leaves.png");
    assert_eq!(json["environment"]["moon"], json!({"size": 1}));
    assert_eq!(json["view"]["post"]["grain"], 0.1);
    assert_eq!(json["materials"][1]["parameters"]["sheen"], 0.5);
    assert_eq!(json["materials"][1]["maps"]["bump"]["blur"], 2);
    assert_eq!(json["bake"]["bounces"], 3);
    assert_eq!(json["bookmarks"][0]["f_stop"], 8);
    assert_eq!(json["materials"][0].get("sheen"), None);
}

#[test]
fn a_session_from_before_some_maps_existed_is_read_without_them() {
    let project = Project::new();
    let loaded = project.changed(|json| {
        let maps = json["materials"][1]["maps"].as_object_mut().unwrap();
        assert!(["anisotropy", "ior"].iter().all(|key| maps.remove(*key).is_some_and(|slot| slot.is_object())));
    });
    assert_eq!((&loaded.warnings, &loaded.unknown), (&Vec::new(), &Unknown::default()));
    let read = loaded.into_document(Some(&project.dataset.scene)).0;
    let mut expected = project.document();
    assert_ne!(read.materials, expected.materials);
    expected.materials[1].maps.retain(|name, _| name != "anisotropy" && name != "ior");
    assert_same(&read, &expected);
}

#[test]
fn a_session_from_before_there_were_lights_has_those_of_the_scene() {
    let mut project = Project::new();
    project.dataset.scene.lights = vec![light()];
    let without = |json: &mut Value| {
        let json = json.as_object_mut().unwrap();
        assert!(["lights", "components", "solution"].iter().all(|key| json.remove(*key).is_some()));
    };
    let loaded = project.changed(without);
    assert_eq!((&loaded.warnings, &loaded.unknown), (&Vec::new(), &Unknown::default()));
    let read = loaded.into_document(Some(&project.dataset.scene)).0;
    assert_eq!((read.lights, read.solution), (vec![light()], Solution::Cuts));
    assert_eq!(read.components, ComponentSettings::default());
    let deleted = project.changed(|json| json["lights"] = json!([]));
    let read = deleted.into_document(Some(&project.dataset.scene)).0;
    assert!(read.lights.is_empty(), "negative control: lights that were deleted stay deleted");
}

#[test]
fn lights_are_written_as_in_a_lights_file_and_damaged_ones_are_said() {
    let project = Project::new();
    project.reloaded(&project.document());
    let spot = &project.json()["lights"][1];
    assert_eq!((&spot["kind"], &spot["cone_degrees"]), (&json!("spot"), &json!(35.0)));
    assert_eq!(spot["intensity"], json!([3.0, 2.0, 1.0]));
    let loaded = project.changed(|json| {
        json["lights"][0]["intensity"] = json!([1, -2, 1]);
        json["lights"][1]["cone_degrees"] = json!(200);
        json["lights"][2]["target"] = json["lights"][2]["position"].clone();
        json["lights"][3]["kind"] = json!("laser");
    });
    let lights = loaded.session.light.lights.as_ref().unwrap();
    assert_eq!((lights[0].intensity, lights.len()), (Vec3::new(1.0, 0.0, 1.0), 3), "{lights:?}");
    assert!(matches!(lights[1].emission, lapidary_core::lights::Emission::Spot { cone_degrees: 90.0, .. }));
    let said = loaded.warnings.join("\n");
    for part in ["the intensity of the light", "the cone of the light", "was left out", "lights[3].kind"] {
        assert!(said.contains(part), "{said}");
    }
    assert_eq!(loaded.warnings.len(), 4, "{said}");
}

#[test]
fn a_missing_texture_is_shown_said_and_not_lost() {
    let project = Project::new();
    project.reloaded(&project.document());
    std::fs::remove_file(project.path("maps/linen.png")).unwrap();
    let loaded = load(&project.file()).unwrap();
    assert_eq!(loaded.missing, [MissingFile { what: "texture", path: project.path("maps/linen.png") }]);
    let (document, warnings) = loaded.into_document(Some(&project.dataset.scene));
    assert!(warnings.len() == 1 && warnings[0].contains("linen.png"), "{warnings:?}");
    assert_eq!(document.textures[3].texture.texels, Texture::missing("").texels);
    let again = project.reloaded(&document);
    assert_eq!(again.missing.len(), 1, "saving again keeps the path");
}

#[test]
fn files_that_moved_are_found_by_name() {
    let project = Project::new();
    project.reloaded(&project.document());
    for name in ["new/maps", "new/old maps", "new/a/b/c/d/e"] {
        std::fs::create_dir_all(project.path(name)).unwrap();
    }
    std::fs::copy(project.path("maps/linen.png"), project.path("new/old maps/linen.png")).unwrap();
    std::fs::rename(project.path("maps/linen.png"), project.path("new/maps/Linen.PNG")).unwrap();
    std::fs::rename(project.path("maps/room.hdr"), project.path("new/old maps/room.hdr")).unwrap();
    std::fs::rename(project.path("a.gltf"), project.path("new/a/b/c/d/e/a.gltf")).unwrap();
    let mut loaded = load(&project.file()).unwrap();
    assert_eq!(loaded.missing.iter().map(|m| m.what).collect::<Vec<_>>(), ["scene", "environment", "texture"]);
    assert_eq!(loaded.relink(&project.path("sessions")), 0);
    assert_eq!(loaded.relink(&project.path("new")), 2);
    assert_eq!(loaded.missing, [MissingFile { what: "scene", path: project.path("a.gltf") }], "too deep");
    let (document, warnings) = loaded.into_document(Some(&project.dataset.scene));
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(document.textures[3].file, Some(project.path("new/maps/Linen.PNG")), "the folder decides");
    assert_eq!(document.environment.file(), Some(&*project.path("new/old maps/room.hdr")));
}

#[test]
fn names_of_another_system_are_found_too() {
    let project = Project::new();
    let mut loaded = project.changed(|json| json["scene"] = json!("C:\\work\\a.gltf"));
    assert_eq!(loaded.missing.len(), 1);
    assert_eq!(loaded.relink(project.folder.path()), 1);
    assert_eq!(loaded.session.scene, Some(project.path("a.gltf")));
}

#[test]
fn without_its_dataset_a_session_loses_nothing() {
    let project = Project::new();
    let document = project.document();
    let (read, warnings) = project.reloaded(&document).into_document(None);
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(read.materials[1].name, "cloth");
    project.reloaded(&read);
    let (back, warnings) = load(&project.file()).unwrap().into_document(Some(&project.dataset.scene));
    assert_eq!(warnings, Vec::<String>::new());
    assert_same(&back, &document);
}

#[test]
fn materials_are_found_by_name_in_another_bake_and_the_rest_is_said() {
    let project = Project::new();
    let session = project.reloaded(&project.document());
    let other = dataset(&["new", "glaze", "stone", "cloth"], &["grain.png"]);
    let (document, warnings) = session.into_document(Some(&other.scene));
    let roughness: Vec<f32> = document.materials.iter().map(|m| m.parameters.number("roughness")).collect();
    assert_eq!(roughness, [0.5, 0.5, 0.5, 0.35]);
    assert_eq!(document.materials.iter().map(|m| &*m.name).collect::<Vec<_>>(), ["new", "glaze", "stone", "cloth"]);
    let said = warnings.join("\n");
    for part in ["no materials \"wood\"", "no materials \"new\", \"stone\"", "no texture \"own.png\""] {
        assert!(said.contains(part), "{said}");
    }
    assert_eq!(warnings.len(), 3);
}

#[test]
fn renamed_materials_keep_their_place() {
    let project = Project::new();
    let mut document = project.document();
    document.materials[1].name = "velvet".into();
    let session = project.reloaded(&document);
    let (read, warnings) = session.clone().into_document(Some(&project.dataset.scene));
    assert_eq!((read.materials[1].name.as_str(), warnings.len()), ("velvet", 0));
    let (_, warnings) = session.into_document(Some(&dataset(&["x", "y", "z"], &["own.png", "own.png"]).scene));
    assert!(warnings.len() == 1 && warnings[0].contains("by their order"), "{warnings:?}");
}

#[test]
fn an_empty_session_is_an_empty_document() {
    let project = Project::new();
    std::fs::write(project.file(), br#"{"lapidary_session": 1}"#).unwrap();
    let loaded = load(&project.file()).unwrap();
    assert_eq!(loaded.warnings, Vec::<String>::new());
    assert_same(&loaded.into_document(None).0, &Document::empty());
}

#[test]
fn angles_come_back_to_the_bit() {
    for i in 0..20_000 {
        let radians = f32::from_bits(0x3c00_0000 + i * 1999);
        let slot = TextureSlot { rotation: radians, ..Default::default() };
        let degrees = SessionSlot::from(&slot).rotation_degrees;
        assert_eq!(degrees.to_radians() as f32, radians);
    }
    let forty = SessionSlot::from(&TextureSlot { rotation: 40f32.to_radians(), ..Default::default() });
    assert_eq!(forty.rotation_degrees, 40.0);
}
