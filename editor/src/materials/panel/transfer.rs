//! Transfers materials: presets, copy and paste, files.

use super::{Changes, MaterialPanel};
use crate::{
    actions::{Action, MaterialAction},
    document::{Document, Edit, ShownMaterials, ViewSettings, in_place_of},
};
use egui::{
    Event, PopupCloseBehavior, Ui, ViewportCommand,
    containers::menu::{MenuButton, MenuConfig},
};
use lapidary_core::{
    material::{Material, MaterialMaps},
    texture::Texture,
};
use lapidary_interchange::import::MaterialFile;
use std::sync::{Arc, Weak};

/// A copied material, and the textures of its maps.
pub struct Copied {
    material: Material,
    textures: Vec<(u32, Weak<Texture>)>,
}

impl Copied {
    fn new(material: &Material, document: &Document) -> Self {
        let texture = |i: u32| Some((i, Arc::downgrade(&document.textures.get(i as usize)?.texture)));
        let textures = material.maps.slots().filter_map(|slot| texture(slot.texture)).collect();
        Self { material: material.clone(), textures }
    }

    /// `target` with the copied values; its name and sides stay. Maps of another document are left out.
    fn pasted_on(&self, target: &Material, document: &Document) -> Material {
        let same = |index: u32| {
            let now = document.textures.get(index as usize).map(|t| Arc::as_ptr(&t.texture));
            self.textures.iter().any(|(i, texture)| *i == index && now == Some(texture.as_ptr()))
        };
        let maps = self
            .material
            .maps
            .filter_map(|slot| (slot.procedural.is_some() || same(slot.texture)).then(|| slot.clone()));
        in_place_of(target, self.material.with_maps(maps))
    }
}

/// The row of buttons.
pub fn show(
    ui: &mut Ui,
    state: &mut MaterialPanel,
    document: &Document,
    index: usize,
    changes: &mut Changes,
    actions: &mut Vec<Action>,
) {
    ui.horizontal_wrapped(|ui| {
        // A click on its check box must not close the menu.
        let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
        MenuButton::new("Presets").config(config).ui(ui, |ui| {
            let MaterialPanel { presets, clear_maps, .. } = state;
            presets.show(ui, clear_maps, changes);
        });
        if ui.button("Copy").on_hover_text("Copy this material, also as text without maps").clicked() {
            ui.ctx().copy_text(text_of(&changes.material));
            state.copied = Some(Copied::new(&changes.material, document));
        }
        let hint = "Paste the copied material onto this one. Ctrl+V pastes material text from the clipboard.";
        if ui.button("Paste").on_hover_text(hint).clicked() {
            match &state.copied {
                Some(copied) => changes.replace("Paste material", copied.pasted_on(&changes.material, document)),
                None => ui.ctx().send_viewport_cmd(ViewportCommand::RequestPaste),
            }
        }
        if ui.button("Load…").on_hover_text("Replace this material with one from a file").clicked() {
            actions.push(Action::Material(MaterialAction::Load { material: index, path: None }));
        }
        if ui.button("Save…").on_hover_text("Write this material to a file").clicked() {
            actions.push(Action::Material(MaterialAction::Save { material: index, path: None }));
        }
    });
    if let Some(material) = pasted_text(ui).and_then(|text| material_of(&text, &changes.material)) {
        changes.replace("Paste material", material);
    }
}

/// Shows this material alone, the others as clay.
pub fn solo(ui: &mut Ui, document: &Document, index: usize, actions: &mut Vec<Action>) {
    let alone = ShownMaterials::Solo(index);
    let mut is_alone = document.view.materials == alone;
    let hint = "Show this material and render the others as clay, without changing them.";
    if ui.toggle_value(&mut is_alone, "Solo").on_hover_text(hint).clicked() {
        let materials = if is_alone { alone } else { ShownMaterials::Own };
        let edit = Edit::View(ViewSettings { materials, ..document.view.clone() });
        actions.push(Action::Edit { edit, label: "Shown materials" });
        actions.push(Action::EndGesture);
    }
}

/// A material as text, which is also a valid material file. Maps are indices into a document, and are left out.
fn text_of(material: &Material) -> String {
    let portable = Material { maps: MaterialMaps::default(), ..material.clone() };
    serde_json::to_string_pretty(&portable).unwrap_or_default()
}

/// `target` with the model and values in `text`, if it describes a material.
fn material_of(text: &str, target: &Material) -> Option<Material> {
    let object: serde_json::Map<String, serde_json::Value> = serde_json::from_str(text).ok()?;
    // Every field has a default; without this, any empty object would be a material.
    object.get("parameters").or(object.get("model"))?;
    let file: MaterialFile = serde_json::from_value(object.into()).ok()?;
    let mut pasted = target.clone();
    pasted.change_model(file.model);
    Some(Material { parameters: file.parameters.sanitized(), ..pasted })
}

/// Text that was pasted while no field was edited.
fn pasted_text(ui: &Ui) -> Option<String> {
    if ui.memory(|m| m.focused().is_some()) {
        return None;
    }
    let text = |event: &Event| if let Event::Paste(text) = event { Some(text.clone()) } else { None };
    ui.input(|i| i.events.iter().find_map(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{brdf::GgxParameters, material::BrdfModel};

    #[test]
    fn materials_survive_as_text_but_for_maps_and_name() {
        let parameters = GgxParameters { roughness: 0.125, ..Default::default() };
        let source =
            Material { name: "A".into(), model: BrdfModel::Ward, parameters: parameters.into(), ..Default::default() };
        let target = Material { name: "B".into(), ..Default::default() };
        let pasted = material_of(&text_of(&source), &target).unwrap();
        assert_eq!(pasted, Material { name: "B".into(), ..source });
    }

    #[test]
    fn other_text_is_no_material() {
        for text in ["", "roughness", "{}", "[1]", r#"{"position": [0, 0, 1]}"#, r#"{"model": "phong"}"#] {
            assert!(material_of(text, &Material::default()).is_none(), "{text}");
        }
        let beyond = material_of(r#"{"parameters": {"roughness": 7}}"#, &Material::default()).unwrap();
        assert_eq!(beyond.parameters.number("roughness"), 1.0);
    }
}
