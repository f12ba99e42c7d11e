//! What is done with the selection of objects and materials.

use super::state::{EditorState, interface::Inspector};
use lapidary_core::parts::Part;

impl EditorState {
    /// Selects an object alone, and with it the part and the material of its first triangle.
    pub(super) fn select_object(&mut self, object: Option<u32>) {
        self.selection.set_object(object);
        self.show_active_object();
    }

    /// Adds an object to the selection, or takes it away. A ground, which cannot be moved, is only selected alone.
    pub(super) fn toggle_object(&mut self, object: u32) {
        let ground = self.ground_object();
        if ground == Some(object) {
            self.messages.remark("The ground stays where it is, and is only selected alone");
            return;
        }
        self.selection.retain_objects(|selected| Some(selected) != ground);
        self.selection.toggle_object(object);
        self.show_active_object();
    }

    /// Selects the part and the material of the active object's first triangle.
    fn show_active_object(&mut self) {
        (self.selection.part, self.selection.light) = (None, None);
        let Some((object, baked)) = self.selection.object.zip(self.scene.rendered()) else { return };
        let mesh = &baked.dataset.scene.mesh;
        let first = mesh.triangle_object.iter().position(|&o| o == object);
        if let Some(part) = first.and_then(|triangle| Part::of_triangle(mesh, triangle)) {
            self.selection.part = Some(part);
            self.selection.material = Some(self.document.material_of(part));
            self.interface.inspector = Inspector::Material;
        }
    }

    pub(super) fn select_material(&mut self, material: Option<usize>) {
        self.selection.material = material;
        if material.is_some() {
            self.interface.inspector = Inspector::Material;
        }
    }

    /// Index of the object that a ground is, if one is shown.
    pub(super) fn ground_object(&self) -> Option<u32> {
        self.scene.rendered()?.dataset.scene.mesh.ground_object()
    }
}
