//! What a pass writes at each texel, and its entry points: one for fragments, one for the invocations of a kernel.

use super::bindings::{Binding, GroupLayout};
use std::fmt::Write;

/// What the entry points of a pass write, as group 0 of its kernel: the frame, areas, and the textures. The name is the type that
/// `written_at` returns, those of the textures are `written` and a member of it.
pub type Output = GroupLayout;

/// What group 0 of a kernel begins with.
pub const FRAME: (&str, Binding) = ("frame", Binding::Uniform);
pub const AREAS: (&str, Binding) = ("areas", Binding::Uniform);

impl Output {
    /// Formats of the textures that it writes.
    pub fn formats(&self) -> impl Iterator<Item = wgpu::TextureFormat> {
        self.bindings.iter().filter_map(|(_, kind)| kind.format())
    }

    /// The entry points, from the text of `shaders/entries.wgsl`.
    pub fn entries(&self, template: &str) -> String {
        let (mut fragment, mut textures, mut stores) = (String::new(), String::new(), String::new());
        let location = if self.formats().count() == 1 { "@location(0) " } else { "" };
        write!(fragment, "fn fragment(@builtin(position) position: vec4<f32>) -> {location}{} {{", self.name)
            .expect("a string takes all");
        for (binding, (name, kind)) in self.bindings.iter().enumerate() {
            let Some(format) = kind.format() else { continue };
            let format = format!("{format:?}").to_lowercase();
            let member = name.replacen("written", "value", 1).replacen('_', ".", 1);
            writeln!(textures, "@group(0) @binding({binding}) var {name}: texture_storage_2d<{format}, write>;")
                .and_then(|()| writeln!(stores, "    textureStore({name}, texel, {member});"))
                .expect("a string takes all");
        }
        let filled = [("//= fragment", fragment), ("//= textures\n", textures), ("//= stores\n", stores)];
        filled.into_iter().fold(template.to_owned(), |text, (place, lines)| text.replacen(place, &lines, 1))
    }
}
