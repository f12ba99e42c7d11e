//! The keyboard map: a window with all keys and pointer gestures.

use super::keys::{BINDINGS, written};
use egui::{Context, Grid, Key, Modal, Modifiers, RichText, ScrollArea, Ui};

/// Width of the keyboard map in points.
const WIDTH: f32 = 1040.0;

/// Pointer gestures, for the keyboard map.
const POINTER: [(&str, &str); 17] = [
    ("Drag", "Orbit (also: middle drag)"),
    ("Shift + drag", "Pan (also: Shift + middle drag)"),
    ("Wheel", "Move closer or away (also: Alt + right drag)"),
    ("Right drag", "Look around; W A S D Q E fly, Shift faster"),
    ("Shift + right drag", "Turn the environment"),
    ("[ ]", "Turn the environment by 5 degrees (Shift: 1)"),
    ("Alt + 1 to 9", "Show a look"),
    ("Click", "Select"),
    ("Ctrl + click", "Add or remove an object from the selection"),
    ("Double click", "Orbit about this point"),
    ("Drop a material", "Apply its values there (Shift: to that surface only)"),
    ("Drag a handle", "Move a light or pose objects (Esc: cancel)"),
    ("Ctrl + handle", "Snap poses to steps"),
    ("Shift + slider", "Fine steps"),
    ("Hold R", "Show the reference while comparing"),
    ("Double click label", "Reset to default"),
    ("Drop a file", "Open it, or apply it to the object under it"),
];

/// Shows the keyboard map. Returns whether it stays open.
pub fn show(ctx: &Context) -> bool {
    let room = ctx.content_rect().size() - egui::vec2(80.0, 160.0);
    let modal = Modal::new(egui::Id::unique("keyboard map")).show(ctx, |ui| {
        ui.set_width(room.x.min(WIDTH));
        // An area has room for some twenty lines at first.
        ui.set_max_height(room.y + 80.0);
        ui.heading("Keyboard and pointer");
        ui.add_space(6.0);
        ScrollArea::both().max_height(room.y).show(ui, |ui| {
            ui.horizontal_top(|ui| {
                for groups in [&["File", "Edit", "Bake", "Window"][..], &["View", "View modes"]] {
                    ui.vertical(|ui| groups.iter().for_each(|group| show_group(ui, group)));
                    ui.add_space(20.0);
                }
                ui.vertical(|ui| table(ui, "Viewport", POINTER.map(|(keys, what)| (keys.to_owned(), what))));
            });
        });
        ui.add_space(6.0);
        ui.button("Close").clicked()
    });
    !(modal.inner || modal.should_close())
}

fn show_group(ui: &mut Ui, group: &'static str) {
    let write = |&(modifiers, key): &(Modifiers, Key)| written(ui.ctx(), modifiers, key);
    let bindings = BINDINGS.iter().filter(|b| b.group == group);
    let rows = bindings.map(|b| (b.keys.iter().map(write).collect::<Vec<_>>().join(", "), b.label));
    let rows: Vec<_> = rows.collect();
    table(ui, group, rows);
}

fn table(ui: &mut Ui, title: &str, rows: impl IntoIterator<Item = (String, &'static str)>) {
    ui.label(RichText::new(title).strong());
    Grid::new(title).num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
        for (keys, what) in rows {
            ui.label(RichText::new(keys).monospace());
            ui.label(what);
            ui.end_row();
        }
    });
    ui.add_space(8.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::keys::Command;
    use egui_kittest::{Harness, kittest::Queryable};

    #[test]
    fn the_map_lists_all_commands() {
        let mut harness = Harness::builder().with_size([1200.0, 800.0]).build_ui(|ui| {
            show(ui.ctx());
        });
        harness.run_steps(3);
        assert!(harness.query_all_by_label("Show a look").next().is_some());
        // Looks are listed together.
        for binding in BINDINGS.iter().filter(|binding| !matches!(binding.command, Command::Look(_))) {
            assert!(harness.query_all_by_label(binding.label).next().is_some(), "{}", binding.label);
        }
    }
}
