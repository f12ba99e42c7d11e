//! Where maps lie on a surface, what they show beyond their edges, and what they read of its vertices.

use super::*;
use lapidary_core::texture::{ColorSpace, UvSet, Wrap};

#[test]
fn placement_edits_scale_offset_rotation_and_channel() {
    let mut harness = harness(|app| app.document.materials[0].maps.set("roughness", Some(TextureSlot::default())));
    let slot = |h: &Harness<App>| h.state().material().maps.get("roughness").cloned().unwrap();
    click(&mut harness, "Roughness map placement");
    type_in(&mut harness, "Roughness map scale value", "4");
    assert_eq!(slot(&harness).scale, Vec2::splat(4.0));
    click(&mut harness, "Roughness map link x and y");
    type_in(&mut harness, "Roughness map scale y value", "2");
    assert_eq!(slot(&harness).scale, Vec2::new(4.0, 2.0));
    type_in(&mut harness, "Roughness map rotation value", "90");
    assert!((slot(&harness).rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    type_in(&mut harness, "Roughness map offset x value", "0.5");
    assert_eq!(slot(&harness).offset, Vec2::new(0.5, 0.0));
    click(&mut harness, "Roughness map channel: G");
    assert_eq!(slot(&harness).channel, Channel::G);
    let labels = vec!["Map scale", "Map scale", "Map rotation", "Map offset", "Map channel"];
    assert_eq!(harness.state().log(), (labels, 5));
    click(&mut harness, "Remove Roughness map");
    assert_eq!(harness.state().material().maps, MaterialMaps::default());
}

#[test]
fn edges_and_coordinates_are_chosen_and_patterns_have_no_edges() {
    let mut harness = harness(|app| app.document.materials[0].maps.set("roughness", Some(TextureSlot::default())));
    let slot = |h: &Harness<App>| h.state().material().maps.get("roughness").cloned().unwrap();
    click(&mut harness, "Roughness map placement");
    click(&mut harness, "Roughness map wrap x: Mirror");
    click(&mut harness, "Roughness map wrap y: Clamp");
    assert_eq!((slot(&harness).wrap, slot(&harness).uv_set), ([Wrap::Mirror, Wrap::Clamp], UvSet::First));
    click(&mut harness, "Roughness map uv set: Second");
    assert_eq!(slot(&harness).uv_set, UvSet::Second);
    assert_eq!(harness.state().log(), (vec!["Map wrap", "Map wrap", "Map UV set"], 3));
    let pattern = TextureSlot { procedural: Some(Procedural::default()), ..slot(&harness) };
    harness.state_mut().document.materials[0].maps.set("roughness", Some(pattern));
    harness.run();
    assert!(harness.query_by_label("Roughness map wrap x: Mirror").is_none());
    assert!(harness.query_by_label("Roughness map uv set: Second").is_some());
}

#[test]
fn primaries_are_given_to_colors_and_not_to_values() {
    let slot = Some(TextureSlot { color_space: ColorSpace::Srgb, ..TextureSlot::default() });
    let both = |app: &mut App| {
        for map in ["base_color", "roughness"] {
            app.document.materials[0].maps.set(map, slot.clone());
        }
    };
    let mut harness = harness(both);
    for map in ["Base color", "Roughness"] {
        click(&mut harness, &format!("{map} map placement"));
    }
    click(&mut harness, "Roughness map color space");
    assert!(harness.query_by_label("ACEScg").is_none(), "a value has no primaries");
    click(&mut harness, "Linear");
    click(&mut harness, "Base color map color space");
    click(&mut harness, "ACEScg");
    let space = |map| harness.state().material().maps.get(map).unwrap().color_space;
    assert_eq!((space("base_color"), space("roughness")), (ColorSpace::AcesCg, ColorSpace::Linear));
}

#[test]
fn a_given_color_space_of_a_map_of_values_is_shown() {
    let mut harness = harness(|app| {
        let slot = TextureSlot { color_space: ColorSpace::AcesCg, ..TextureSlot::default() };
        app.document.materials[0].maps.set("roughness", Some(slot));
    });
    click(&mut harness, "Roughness map placement");
    let row = harness.get_by_role_and_label(Role::ComboBox, "Roughness map color space");
    assert_eq!(row.accesskit_node().value().as_deref(), Some("ACEScg"));
    click(&mut harness, "Roughness map color space");
    assert!(harness.query_by_label("ACES2065-1").is_none(), "negative control: others are for colors");
}

#[test]
fn colors_of_vertices_have_a_switch_where_there_is_a_base_color() {
    let mut harness = harness(|app| app.document.materials[0].vertex_colors = true);
    click(&mut harness, "Vertex colors");
    assert!(!harness.state().material().vertex_colors);
    assert_eq!(harness.state().log(), (vec!["Vertex colors"], 1));
    let without = BrdfModel::ALL.iter().copied().find(|model| model.parameter_for("base_color").is_none());
    harness.state_mut().document.materials[0].model = without.expect("a measured model");
    harness.run();
    assert!(harness.query_by_label("Vertex colors").is_none());
}
