mod layers;
mod placement;

use super::*;
use crate::{
    actions::{MaterialAction, SelectAction},
    document::TextureEntry,
};
use egui::{Key, accesskit::Role};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    light_tree::LightTree,
    material::{BrdfModel, MaterialMaps, PRESETS},
    texture::{Channel, Pattern, Procedural, Texels, Texture},
};
use lapidary_render::SceneLighting;
use std::{
    path::{Path, PathBuf},
    thread,
    time::{Duration, Instant},
};

struct App {
    document: Document,
    panel: MaterialPanel,
    selected: Option<usize>,
    part: Option<Part>,
    parts: Vec<Part>,
    ground: Option<usize>,
    lighting: Option<Arc<EnvironmentLight>>,
    actions: Vec<Action>,
}

impl App {
    fn material(&self) -> &Material {
        &self.document.materials[0]
    }

    /// The labels of the edits so far, and how many gestures ended.
    fn log(&self) -> (Vec<&'static str>, usize) {
        let label = |a: &Action| if let Action::Edit { label, .. } = a { Some(*label) } else { None };
        let ends = self.actions.iter().filter(|a| matches!(a, Action::EndGesture)).count();
        (self.actions.iter().filter_map(label).collect(), ends)
    }
}

/// The panel over a document of two materials and one texture. Edits are performed as in the window.
fn harness(edit: impl FnOnce(&mut App)) -> Harness<'static, App> {
    let named = |name: &str| Material { name: name.into(), ..Default::default() };
    let texels = Texels::U8(vec![[255, 0, 0, 255]]);
    let texture = Texture::new("red.png", [1, 1], texels);
    let textures = vec![TextureEntry { texture: texture.into(), file: Some(PathBuf::from("/maps/red.png")) }];
    let document = Document { materials: vec![named("Knob"), named("Door")], textures, ..Document::empty() };
    let mut app = App {
        document,
        panel: MaterialPanel::default(),
        selected: Some(0),
        part: None,
        parts: Vec::new(),
        ground: None,
        lighting: None,
        actions: Vec::new(),
    };
    edit(&mut app);
    let show = |ui: &mut Ui, app: &mut App| {
        let context = MaterialContext {
            document: &app.document,
            selected: app.selected,
            part: app.part,
            parts: &app.parts,
            ground: app.ground,
            has_second_uvs: true,
            has_vertex_colors: true,
            lighting: app.lighting.as_ref(),
            light_revision: 0,
        };
        let mut actions = Vec::new();
        super::show(ui, &mut app.panel, &context, &mut actions);
        for action in &actions {
            if let Action::Edit { edit, .. } = action {
                edit.clone().swap(&mut app.document);
            }
        }
        app.actions.extend(actions);
    };
    // The ball is rendered by a thread, which asks for a frame whenever it is done.
    let builder = Harness::builder().with_size(vec2(340.0, 1400.0)).with_max_steps(60);
    let mut harness = builder.build_ui_state(show, app);
    harness.run();
    harness
}

/// Clicks as a screen reader does, even out of sight.
fn click_hidden(harness: &mut Harness<App>, label: &str) {
    harness.get_by_label(label).click_accesskit();
    harness.run();
}

fn choose_model(harness: &mut Harness<App>, name: &str) {
    harness.get_by_role_and_label(Role::ComboBox, "Model").click();
    harness.run();
    click(harness, name);
}

fn click(harness: &mut Harness<App>, label: &str) {
    harness.get_by_label(label).click();
    harness.run();
}

fn type_in(harness: &mut Harness<App>, label: &str, text: &str) {
    click(harness, label);
    harness.get_by_label(label).type_text(text);
    harness.key_press(Key::Enter);
    harness.run();
}

#[test]
fn typing_a_roughness_is_one_edit_and_one_gesture() {
    let mut harness = harness(|_| {});
    type_in(&mut harness, "Roughness value", "0.25");
    assert_eq!(harness.state().material().parameters.number("roughness"), 0.25);
    assert_eq!(harness.state().log(), (vec!["Roughness"], 1));
    assert_eq!(harness.state().document.materials[1], Material { name: "Door".into(), ..Default::default() });
}

#[test]
fn dragging_the_slider_is_many_edits_and_one_gesture() {
    let mut harness = harness(|_| {});
    let rect = harness.get_by_label("Roughness").rect();
    harness.drag_at(rect.center());
    harness.step();
    for i in 1..6 {
        harness.hover_at(rect.center() + vec2(6.0 * i as f32, 0.0));
        harness.step();
    }
    harness.drop_at(rect.center() + vec2(30.0, 0.0));
    harness.run();
    let (labels, ends) = harness.state().log();
    assert!(labels.len() >= 3 && labels.iter().all(|l| *l == "Roughness"), "{labels:?}");
    assert_eq!(ends, 1);
    assert!(matches!(harness.state().actions.last(), Some(Action::EndGesture)));
    assert!(harness.state().material().parameters.number("roughness") > 0.55);
}

#[test]
fn doing_nothing_asks_for_nothing() {
    let mut harness = harness(|_| {});
    harness.run();
    click(&mut harness, "Roughness value");
    harness.key_press(Key::Escape);
    harness.run();
    assert!(harness.state().actions.is_empty(), "{:?}", harness.state().actions);
}

#[test]
fn reset_puts_the_default_back() {
    let mut harness = harness(|app| app.document.materials[0].parameters.set("ior", 2.4));
    assert!(harness.query_by_label("Reset Roughness").is_none());
    click(&mut harness, "Reset IOR");
    assert_eq!(harness.state().material().parameters.number("ior"), 1.5);
    assert_eq!(harness.state().log(), (vec!["IOR"], 1));
}

#[test]
fn the_model_shows_what_it_reads_and_grays_what_has_no_effect() {
    let mut harness = harness(|_| {});
    let disabled =
        |h: &Harness<App>, label: &str| h.get_by_role_and_label(Role::Slider, label).accesskit_node().is_disabled();
    assert!(!disabled(&harness, "Roughness"));
    choose_model(&mut harness, "Lambert");
    assert_eq!(harness.state().material().model, BrdfModel::Lambert);
    assert_eq!(harness.state().log(), (vec!["BRDF model"], 1));
    assert!(harness.query_by_role_and_label(Role::Slider, "Roughness").is_none());
    choose_model(&mut harness, "Ward");
    assert!(!disabled(&harness, "Roughness") && !disabled(&harness, "IOR"));
    harness.state_mut().document.materials[0].parameters.set("metalness", 1.0);
    harness.run();
    assert!(!disabled(&harness, "Roughness") && disabled(&harness, "IOR"));
}

#[test]
fn what_is_stored_and_not_rendered_has_a_folded_part_of_openpbr_alone() {
    const TITLE: &str = "Stored, not rendered";
    let mut harness = harness(|_| {});
    assert!(harness.query_by_label(TITLE).is_none(), "GGX stores nothing");
    choose_model(&mut harness, "OpenPBR");
    let has_row = |h: &Harness<App>| h.query_by_role_and_label(Role::Slider, "Transmission weight").is_some();
    assert!(!has_row(&harness), "it is folded");
    click_hidden(&mut harness, TITLE);
    harness.run();
    assert!(has_row(&harness));
    assert!(harness.query_by_label("Kept for other programs; the picture does not show them.").is_some());
    for p in BrdfModel::OpenPbr.stored_parameters() {
        assert!(harness.query_by_label(&format!("Load {} map", p.label)).is_some(), "{}", p.label);
    }
    let before = harness.state().material().plain_values().numbers().to_vec();
    harness.get_by_label("Transmission weight value").click_accesskit();
    harness.run();
    harness.get_by_label("Transmission weight value").type_text("0.25");
    harness.key_press(Key::Enter);
    harness.run();
    assert_eq!(harness.state().material().parameters.number("transmission_weight"), 0.25);
    assert_eq!(harness.state().material().plain_values().numbers(), before, "nothing that is rendered has changed");
    assert_eq!(harness.state().log(), (vec!["BRDF model", "Transmission weight"], 2));
    click_hidden(&mut harness, "Reset Transmission weight");
    assert_eq!(harness.state().material().parameters.number("transmission_weight"), 0.0);
}

#[test]
fn copy_and_paste_carry_values_and_maps_but_not_the_name() {
    let mut harness = harness(|app| {
        app.document.materials[0].parameters.set("roughness", 0.1);
        app.document.materials[0].maps.set("normal", Some(TextureSlot::default()));
    });
    click(&mut harness, "Copy");
    harness.state_mut().selected = Some(1);
    harness.run();
    click(&mut harness, "Paste");
    let pasted = harness.state().document.materials[1].clone();
    assert_eq!((pasted.name.as_str(), pasted.parameters.number("roughness")), ("Door", 0.1));
    assert_eq!(pasted.maps.get("normal"), Some(&TextureSlot::default()));
    assert_eq!(harness.state().log(), (vec!["Paste material"], 1));
}

#[test]
fn maps_of_another_document_are_not_pasted() {
    let mut harness = harness(|app| app.document.materials[0].maps.set("normal", Some(TextureSlot::default())));
    click(&mut harness, "Copy");
    let texture = &mut harness.state_mut().document.textures[0].texture;
    *texture = Arc::new(Texture::clone(texture));
    harness.state_mut().selected = Some(1);
    harness.run();
    click(&mut harness, "Paste");
    assert_eq!(harness.state().document.materials[1].maps, MaterialMaps::default());
}

#[test]
fn a_material_that_is_text_is_pasted() {
    let mut harness = harness(|_| {});
    harness.event(egui::Event::Paste("not a material".into()));
    harness.run();
    assert!(harness.state().actions.is_empty());
    harness.event(egui::Event::Paste(r#"{"model": "ward", "parameters": {"roughness": 0.75}}"#.into()));
    harness.run();
    let material = harness.state().material();
    assert_eq!((material.model, material.parameters.number("roughness")), (BrdfModel::Ward, 0.75));
}

#[test]
fn presets_keep_the_maps_unless_they_are_cleared() {
    let mut harness = harness(|app| app.document.materials[0].maps.set("bump", Some(TextureSlot::default())));
    click(&mut harness, "Presets");
    click_hidden(&mut harness, "Gold");
    assert_eq!(harness.state().material().parameters.number("metalness"), 1.0);
    assert!(harness.state().material().maps.get("bump").is_some());
    click(&mut harness, "Presets");
    click(&mut harness, "Clear maps");
    click_hidden(&mut harness, "Rubber");
    assert_eq!(harness.state().material().maps, MaterialMaps::default());
    let rubber = PRESETS.iter().find(|p| p.name == "Rubber").unwrap();
    assert_eq!(harness.state().material().parameters, rubber.parameters);
    assert_eq!(harness.state().log(), (vec!["Preset"; 2], 2));
}

#[test]
fn loading_saving_and_choosing_are_asked_for() {
    let mut harness = harness(|_| {});
    for label in ["Load Roughness map", "Load…", "Save…"] {
        click(&mut harness, label);
    }
    click(&mut harness, "Material");
    click(&mut harness, "Door");
    let actions = &harness.state().actions;
    assert!(matches!(
        actions[0],
        Action::Material(MaterialAction::LoadTexture { material: 0, map: "roughness", path: None })
    ));
    assert!(matches!(actions[1], Action::Material(MaterialAction::Load { material: 0, path: None })));
    assert!(matches!(actions[2], Action::Material(MaterialAction::Save { material: 0, path: None })));
    assert!(matches!(actions[3], Action::Select(SelectAction::Material(Some(1)))));
    assert_eq!(actions.len(), 4);
}

/// Drops a picture on the row with this button.
fn drop_picture_on(harness: &mut Harness<App>, label: &str) {
    #[derive(Debug)]
    struct Dropped;
    impl egui::DroppedFile for Dropped {
        fn path(&self) -> &Path {
            Path::new("/maps/wood.png")
        }
        fn bytes(&self) -> Result<Vec<u8>, String> {
            Err("not read here".into())
        }
    }
    let row = harness.get_by_label(label).rect();
    harness.hover_at(row.center());
    harness.run();
    harness.input_mut().dropped_files = vec![Arc::new(Dropped)];
    harness.run();
}

#[test]
fn every_parameter_takes_a_map_and_lambert_only_that_of_its_color() {
    let mut harness = harness(|_| {});
    let others = ["Roughness", "Metalness", "Specular", "IOR", "Anisotropy"];
    let loads = |h: &Harness<App>, name: &str| h.query_by_label(&format!("Load {name} map")).is_some();
    assert!(loads(&harness, "Base color") && others.iter().all(|name| loads(&harness, name)));
    choose_model(&mut harness, "Lambert");
    assert!(loads(&harness, "Base color") && !others.iter().any(|name| loads(&harness, name)));
}

#[test]
fn maps_of_ior_and_anisotropy_are_loaded_placed_and_removed() {
    let mut harness = harness(|_| {});
    assert!(harness.query_by_label("No IOR map").is_some() && harness.query_by_label("No anisotropy map").is_some());
    click(&mut harness, "Load IOR map");
    drop_picture_on(&mut harness, "Load Anisotropy map");
    let kind_of = |action: &Action| match action {
        Action::Material(MaterialAction::LoadTexture { material: 0, map, .. }) => *map,
        other => panic!("{other:?}"),
    };
    let wanted: Vec<&'static str> = harness.state().actions.iter().map(kind_of).collect();
    assert_eq!(wanted, ["ior", "anisotropy"]);
    // As the window does once a picture is read.
    for kind in wanted {
        harness.state_mut().document.materials[0].maps.set(kind, Some(new_slot(kind, 0)));
    }
    harness.state_mut().actions.clear();
    harness.run();
    let maps = harness.state().material().maps.clone();
    assert_eq!(maps.slots().count(), 2);
    assert_eq!(
        (maps.get("ior"), maps.get("anisotropy")),
        (Some(&TextureSlot::default()), Some(&TextureSlot::default()))
    );
    click(&mut harness, "IOR map placement");
    click(&mut harness, "IOR map channel: B");
    click(&mut harness, "Remove Anisotropy map");
    let ior = TextureSlot { channel: Channel::B, ..Default::default() };
    assert_eq!(harness.state().material().maps, MaterialMaps::from([("ior", ior)]));
    assert_eq!(harness.state().log(), (vec!["Map channel", "Remove map"], 2));
}

#[test]
fn a_pattern_is_chosen_changed_and_replaced_by_an_image() {
    let mut harness = harness(|_| {});
    click(&mut harness, "Kinds of Roughness map");
    click_hidden(&mut harness, "Noise");
    let slot = |h: &Harness<App>| h.state().material().maps.get("roughness").cloned().unwrap();
    let noise = Procedural { pattern: Pattern::Noise, ..Default::default() };
    assert_eq!(slot(&harness), TextureSlot { procedural: Some(noise), ..Default::default() });
    assert!(harness.query_all_by_label("Noise").next().is_some(), "its row says what it is");
    // The menu is still there: no pointer has clicked.
    click_hidden(&mut harness, "Checker");
    assert_eq!(slot(&harness).procedural.unwrap().pattern, Pattern::Checker);
    assert_eq!(harness.state().log(), (vec!["Pattern"; 2], 2));
    click_hidden(&mut harness, "Image…");
    let last = harness.state().actions.last().unwrap();
    assert!(
        matches!(last, Action::Material(MaterialAction::LoadTexture { material: 0, map: "roughness", path: None })),
        "{last:?}"
    );
}

#[test]
fn a_picture_dropped_on_a_row_is_loaded_there() {
    let mut harness = harness(|_| {});
    drop_picture_on(&mut harness, "Load Metalness map");
    let actions = &harness.state().actions;
    assert_eq!(actions.len(), 1);
    let Action::Material(MaterialAction::LoadTexture { material: 0, map: "metalness", path: Some(path) }) = &actions[0]
    else {
        panic!("{actions:?}")
    };
    assert_eq!(path, Path::new("/maps/wood.png"));
}

#[test]
fn nothing_removes_a_map_where_the_click_that_loaded_it_was() {
    let mut harness = harness(|_| {});
    let loaded_at = harness.get_by_label("Load Roughness map").rect();
    harness.state_mut().document.materials[0].maps.set("roughness", Some(TextureSlot::default()));
    harness.run();
    let remove = harness.get_by_label("Remove Roughness map").rect();
    assert!(!remove.expand(2.0).intersects(loaded_at), "{remove:?} {loaded_at:?}");
    let swap = harness.get_by_label("Swap Roughness map").rect();
    assert!(swap.contains(loaded_at.center()), "the button that loads stays: {swap:?} {loaded_at:?}");
}

#[test]
fn bumps_are_in_millimetres_and_can_be_inverted_and_normals_flipped() {
    let mut harness = harness(|app| {
        let maps = &mut app.document.materials[0].maps;
        maps.set("bump", Some(new_slot("bump", 0)));
        maps.set("normal", Some(new_slot("normal", 0)));
    });
    type_in(&mut harness, "Bump map height value", "2.5");
    click(&mut harness, "Bump map invert");
    let maps = &harness.state().material().maps;
    assert!((maps.get("bump").unwrap().strength + 0.0025).abs() < 1e-7);
    assert!(!maps.get("normal").unwrap().flip_y);
    click(&mut harness, "Normal map flip y (directx)");
    assert!(harness.state().material().maps.get("normal").unwrap().flip_y);
    assert_eq!(harness.state().log(), (vec!["Bump height", "Invert bumps", "Flip Y"], 3));
}

#[test]
fn a_slot_whose_texture_is_missing_is_shown_and_can_be_swapped() {
    let mut harness = harness(|app| {
        app.document.materials[0].maps.set("base_color", Some(TextureSlot { texture: 99, ..Default::default() }));
    });
    click(&mut harness, "Swap Base color map");
    assert!(matches!(
        harness.state().actions[0],
        Action::Material(MaterialAction::LoadTexture { map: "base_color", .. })
    ));
}

fn part(object: u32, material: u32) -> Part {
    Part { object, material }
}

#[test]
fn a_surface_is_given_another_material_or_one_of_its_own() {
    let objects = ["Left", "Right"].map(String::from).to_vec();
    let mut harness = harness(|app| {
        app.document.objects = objects;
        app.document.materials.push(Material { name: "Ground".into(), ..Default::default() });
        (app.part, app.ground) = (Some(part(1, 0)), Some(2));
        app.parts = vec![part(0, 0), part(1, 0), part(1, 1), part(2, 2)];
    });
    assert!(harness.query_by_label("Right, Knob").is_some(), "the surface is named");
    click(&mut harness, "Make unique");
    harness.get_by_role_and_label(Role::ComboBox, "Uses").click();
    harness.run();
    assert_eq!(harness.query_all_by_label("Ground").count(), 0, "a ground keeps its material to itself");
    click(&mut harness, "Door");
    let actions = &harness.state().actions;
    assert!(
        matches!(actions[0], Action::Material(MaterialAction::MakeUnique { part, material: None }) if part == self::part(1, 0))
    );
    assert!(
        matches!(actions[1], Action::Material(MaterialAction::Assign { part, material: 1 }) if part == self::part(1, 0))
    );
    harness.state_mut().document.assigned = [(part(0, 0), 1)].into();
    harness.run();
    click(&mut harness, "Make unique");
    assert_eq!(harness.state().actions.len(), 2, "no other surface has it any more");
}

#[test]
fn a_ground_and_no_surface_have_no_row() {
    for (selected, ground) in [(None, None), (Some(part(0, 1)), Some(1))] {
        let harness = harness(|app| (app.part, app.ground) = (selected, ground));
        assert!(harness.query_by_label("Make unique").is_none());
    }
}

#[test]
fn nothing_selected_and_nothing_open_are_no_errors() {
    let mut harness = harness(|app| (app.selected, app.document) = (Some(7), Document::empty()));
    assert!(harness.query_by_label("Roughness").is_none());
    harness.run();
    assert!(harness.state().actions.is_empty());
}

#[test]
fn the_preview_arrives_and_the_panel_comes_to_rest() {
    let tree = LightTree::geometric(64).unwrap();
    let lighting: Arc<EnvironmentLight> = SceneLighting::new(&tree, &[Vec3::ONE; 64], 16).into();
    for light in [Some(lighting), None] {
        let lit_by = light.as_ref().map_or("a studio", |_| "the environment");
        let mut harness = harness(|app| app.lighting = light);
        let start = Instant::now();
        while !harness.state().panel.preview.has_picture() {
            assert!(start.elapsed() < Duration::from_secs(90), "no preview under {lit_by}");
            thread::sleep(Duration::from_millis(5));
            harness.step();
        }
        harness.run();
    }
}
