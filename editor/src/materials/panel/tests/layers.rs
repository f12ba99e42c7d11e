//! The row that chooses a layer of a map's picture.

use super::*;
use lapidary_core::image::Image;
use lapidary_interchange::image::{Layer, LayeredImage, Metadata, read_texture, with_layer};

/// The name of the row.
const ROW: &str = "Base color map layer";

/// The panel over a material whose base color is a file of these layers.
fn harness_of(layers: Vec<Layer>, chosen: Option<&str>) -> (tempfile::TempDir, PathBuf, Harness<'static, App>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    LayeredImage { size: [2, 1], layers, metadata: Metadata::default() }.write(&path).unwrap();
    let file = chosen.map_or(path.clone(), |layer| with_layer(&path, layer));
    let panel = harness(|app| {
        let texture = read_texture(&file).unwrap().into();
        app.document.textures = vec![TextureEntry { texture, file: Some(file) }];
        app.document.materials[0].maps.set("base_color", Some(TextureSlot::default()));
    });
    (folder, path, panel)
}

fn colors(name: &str) -> Layer {
    Layer::color(name, &Image::filled([2, 1], Vec3::ONE))
}

fn loads(panel: &Harness<App>) -> Vec<PathBuf> {
    let path = |action: &Action| match action {
        Action::Material(MaterialAction::LoadTexture { material: 0, map: "base_color", path }) => path.clone(),
        _ => None,
    };
    panel.state().actions.iter().filter_map(path).collect()
}

#[test]
fn a_layer_of_a_map_is_chosen_from_those_of_its_file() {
    for (chosen, shown, other) in [(None, "RGBA", "depth"), (Some("DEPTH"), "depth", "RGBA")] {
        let (_folder, path, mut panel) =
            harness_of(vec![colors(""), Layer::scalar("depth", "Z", vec![3.0; 2])], chosen);
        let row = panel.get_by_role_and_label(Role::ComboBox, ROW);
        assert_eq!(row.accesskit_node().value().as_deref(), Some(shown));
        row.click();
        panel.run();
        assert!(loads(&panel).is_empty(), "negative control: showing the list loads nothing");
        click(&mut panel, other);
        assert_eq!(loads(&panel), [with_layer(&path, other)]);
    }
}

#[test]
fn a_picture_of_one_layer_has_no_such_row() {
    let (_folder, _, panel) = harness_of(vec![colors("")], None);
    assert!(panel.query_by_role_and_label(Role::ComboBox, ROW).is_none());
}
