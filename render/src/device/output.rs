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
        writeln!(fragment, "fn fragment(@builtin(position) position: vec4<f32>) -> {location}{} {{", self.name)
            .expect("a string takes all");
        for (binding, (name, kind)) in self.bindings.iter().enumerate() {
            let Some(format) = kind.format() else { continue };
            let format = format!("{format:?}").to_lowercase();
            let member = name.replacen("written", "value", 1).replacen('_', ".", 1);
            writeln!(textures, "@group(0) @binding({binding}) var {name}: texture_storage_2d<{format}, write>;")
                .and_then(|()| writeln!(stores, "    textureStore({name}, texel, {member});"))
                .expect("a string takes all");
        }
        let line = |line: &str| match line {
            "//= fragment" => fragment.clone(),
            "//= textures" => textures.clone(),
            "//= stores" => stores.clone(),
            other => format!("{other}\n"),
        };
        template.lines().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_write_each_texture_and_lines_end_as_they_like() {
        let numbers = Output { name: "vec4<f32>", bindings: &[FRAME, AREAS, ("written", Binding::WrittenFloats)] };
        let template = "//= fragment\r\n}\r\n//= textures\r\n//= stores\r\n";
        let expected = "fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {\n}\n\
                        @group(0) @binding(2) var written: texture_storage_2d<rgba32float, write>;\n    \
                        textureStore(written, texel, value);\n";
        assert_eq!(numbers.entries(template), expected);
        let bindings = &[FRAME, AREAS, ("written_a", Binding::WrittenFloats), ("written_b", Binding::WrittenUints)];
        let two = Output { name: "Two", bindings }.entries("//= stores\n");
        assert_eq!(two, "    textureStore(written_a, texel, value.a);\n    textureStore(written_b, texel, value.b);\n");
    }
}
