//! The shaders' dispatch to the BRDF models that a scene uses, written from the models' declarations. Models and parts that no
//! material has are not compiled, nor lookups in maps that none has.

use super::written;
use crate::appearance::Appearance;
use lapidary_core::{
    brdf::{BrdfModel, Content, MapUse, Parameter, Written},
    material::{Material, MaterialPart},
};
use std::{collections::BTreeSet, fmt::Write, sync::Arc};

/// The models that are compiled. The first is always there: a ground that catches shadows is diffuse.
#[derive(Clone, Debug)]
pub struct ModelSet {
    models: Vec<BrdfModel>,
    /// Those that users wrote, each once.
    written: Vec<Arc<Written>>,
    parts: Vec<MaterialPart>,
    /// The parameters, by number of their model and by name, that have maps or colors of vertices.
    mapped: BTreeSet<(u32, String)>,
}

impl Default for ModelSet {
    fn default() -> Self {
        Self { models: vec![DIFFUSE], written: Vec::new(), parts: Vec::new(), mapped: BTreeSet::new() }
    }
}

/// What the text needs of a model.
struct Entry<'a> {
    /// `MODEL_OREN_NAYAR`.
    constant: String,
    /// Name of its structure.
    type_name: String,
    /// Name of the structure of its parameters.
    parameters_name: String,
    /// What its functions begin with: `oren_nayar`.
    prefix: String,
    list: &'static [Parameter],
    /// Those of them that have maps.
    mapped: Vec<&'a str>,
    /// What else it takes of a material than its parameters.
    more: &'static str,
    /// Whether the structure of the parameters is in the text of the model.
    has_structure: bool,
}

/// The model of a ground that catches shadows.
const DIFFUSE: BrdfModel = BrdfModel::Lambert;

impl ModelSet {
    /// Those that the materials have.
    pub fn of(appearance: &Appearance) -> Self {
        let mut written: Vec<Arc<Written>> = Vec::new();
        for found in appearance.materials.iter().filter_map(written_of) {
            if !written.iter().any(|known| known.hash() == found.hash()) {
                written.push(found.clone());
            }
        }
        let has = |material: &Material, model| material.model == model && written_of(material).is_none();
        let is_used = |&model: &BrdfModel| model == DIFFUSE || appearance.materials.iter().any(|m| has(m, model));
        let models = BrdfModel::ALL.iter().copied().filter(is_used).collect();
        // What users write may use any part.
        let is_there = |part: &MaterialPart| !written.is_empty() || appearance.materials.iter().any(|m| part.is_in(m));
        let parts = MaterialPart::ALL.into_iter().filter(is_there).collect();
        let set = Self { models, written, parts, mapped: BTreeSet::new() };
        let mapped = appearance.materials.iter().flat_map(|material| {
            let number = set.number(material);
            let colored = material.vertex_colored().map(|p| p.name);
            let varies = move |p: &&Parameter| material.maps.get(p.name).is_some() || colored == Some(p.name);
            let own = material.own_parameters().iter().filter(varies);
            own.map(move |p| (number, p.name.to_owned()))
        });
        Self { mapped: mapped.collect(), ..set }
    }

    /// With what another also has, unless that has other models of users: their numbers are by place.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        if self.hashes() != other.hashes() {
            return self.clone();
        }
        let in_either = |model: &BrdfModel| self.models.contains(model) || other.models.contains(model);
        let part_in_either = |part: &MaterialPart| self.parts.contains(part) || other.parts.contains(part);
        Self {
            models: BrdfModel::ALL.iter().copied().filter(in_either).collect(),
            written: self.written.clone(),
            parts: MaterialPart::ALL.into_iter().filter(part_in_either).collect(),
            mapped: &self.mapped | &other.mapped,
        }
    }

    /// Without maps, and without models of files.
    #[must_use]
    pub fn without_maps(&self) -> Self {
        let models = self.models.iter().copied().filter(|model| !model.has_file()).collect();
        Self { models, written: Vec::new(), parts: self.parts.clone(), mapped: BTreeSet::new() }
    }

    fn hashes(&self) -> Vec<[u8; 32]> {
        self.written.iter().map(|written| written.hash()).collect()
    }

    /// Whether what is compiled for it also renders another.
    pub fn covers(&self, other: &Self) -> bool {
        other.models.iter().all(|model| self.models.contains(model))
            && other.parts.iter().all(|part| self.parts.contains(part))
            && other.mapped.is_subset(&self.mapped)
            && self.hashes() == other.hashes()
    }

    /// All of them, and one that a user wrote.
    #[cfg(test)]
    pub fn all() -> Self {
        let example = lapidary_core::brdf::example_file(BrdfModel::Wgsl).and_then(|file| file.content);
        let written: Vec<Arc<Written>> = example.as_ref().and_then(Content::written).cloned().into_iter().collect();
        let models = BrdfModel::ALL.to_vec();
        let own =
            |(number, list): (usize, &'static [Parameter])| list.iter().map(move |p| (number as u32, p.name.into()));
        let lists = models.iter().map(|model| model.own_parameters()).chain(written.iter().map(|of| of.parameters()));
        let mapped = lists.enumerate().flat_map(own).collect();
        Self { models, written, parts: MaterialPart::ALL.to_vec(), mapped }
    }

    /// Whether users wrote any.
    pub fn has_written(&self) -> bool {
        !self.written.is_empty()
    }

    /// In the order of their list.
    pub fn models(&self) -> &[BrdfModel] {
        &self.models
    }

    /// The number of a material's model in shaders.
    pub fn number(&self, material: &Material) -> u32 {
        let place = written_of(material).and_then(|of| self.written.iter().position(|known| known.hash() == of.hash()));
        place.map_or(material.model as u32, |index| (BrdfModel::ALL.len() + index) as u32)
    }

    /// The parameters of each model, what all of them have in common, and the dispatch, from the texts of
    /// [`ShaderSource::templates`](super::shaders::ShaderSource::templates).
    pub fn text(&self, [dispatch, of_written]: [&str; 2]) -> String {
        let mut text = String::from("// Written from the declarations of the models.\n");
        let all = BrdfModel::ALL.iter().map(|&model| constant(model));
        let written = (0..self.written.len()).map(|index| format!("MODEL_WRITTEN_{index}"));
        for (index, name) in all.chain(written).enumerate() {
            writeln!(text, "const {name}: u32 = {index}u;").expect("a string takes all");
        }
        for part in MaterialPart::ALL {
            let is_there = self.parts.contains(&part);
            writeln!(text, "const {}: bool = {is_there};", part.constant()).expect("a string takes all");
        }
        self.written.iter().enumerate().for_each(|(index, of)| text += &written::text(of, index, of_written));
        let entries = self.entries();
        entries.iter().for_each(|entry| text += &parameters(entry));
        text += &brdf(&entries, dispatch);
        text
    }

    fn mapped_of(&self, model: u32) -> Vec<&str> {
        self.mapped.iter().filter(|(of, _)| *of == model).map(|(_, name)| name.as_str()).collect()
    }

    fn entries(&self) -> Vec<Entry<'_>> {
        let of_model = |&model: &BrdfModel| Entry {
            constant: constant(model),
            type_name: model.type_name().into(),
            parameters_name: format!("{}Parameters", model.type_name()),
            prefix: prefix(model),
            list: model.own_parameters(),
            mapped: self.mapped_of(model as u32),
            more: if model == BrdfModel::Merl {
                ", materials[material].table, materials[material].estimate"
            } else {
                ""
            },
            has_structure: false,
        };
        let of_written = |(index, of): (usize, &Arc<Written>)| Entry {
            constant: format!("MODEL_WRITTEN_{index}"),
            type_name: format!("Written{index}"),
            parameters_name: format!("{}Parameters", written::prefix(index)),
            prefix: format!("written_{index}"),
            list: of.parameters(),
            mapped: self.mapped_of((BrdfModel::ALL.len() + index) as u32),
            more: ", materials[material].estimate",
            has_structure: true,
        };
        self.models.iter().map(of_model).chain(self.written.iter().enumerate().map(of_written)).collect()
    }
}

/// What a user wrote for a material.
fn written_of(material: &Material) -> Option<&Arc<Written>> {
    let file = material.file.as_ref().filter(|_| material.model == BrdfModel::Wgsl)?;
    file.content.as_ref().and_then(Content::written)
}

/// Any of the models, and the dispatch to them: `shaders/brdf_dispatch.wgsl` with the lines of each model at their places.
fn brdf(entries: &[Entry], dispatch: &str) -> String {
    let of_all = |place: &str| entries.iter().map(|entry| lines_at(place, entry)).collect();
    let filled = |line: &str| line.strip_prefix("//= ").map_or_else(|| format!("{line}\n"), of_all);
    dispatch.lines().map(filled).collect()
}

/// The lines of a model at a place of the dispatch.
fn lines_at(place: &str, entry: &Entry) -> String {
    let Entry { constant, prefix, type_name, list, more, .. } = entry;
    match place {
        "members" => format!("    {prefix}: {type_name},\n"),
        "makes" => {
            let read = if list.is_empty() { String::new() } else { format!("read_{prefix}(material, at){more}") };
            format!("        case {constant}: {{ brdf.{prefix} = {prefix}_of({read}); }}\n")
        }
        "reflects" => format!("        case {constant}: {{ return {prefix}_reflect(brdf.{prefix}, light, wo); }}\n"),
        "shown" => shown_by(entry),
        function => format!("        case {constant}: {{ return {prefix}_{function}(brdf.{prefix}); }}\n"),
    }
}

/// The case of a model where base color and roughness are shown.
fn shown_by(Entry { constant, prefix, list, .. }: &Entry) -> String {
    let field = |quantity, none: &str| {
        let parameter = list.iter().find(|p| p.quantity == quantity);
        parameter.map_or(none.to_owned(), |p| format!("p.{}", p.name))
    };
    let (color, roughness) = (field("base_color", "vec3(0.0)"), field("roughness", "1.0"));
    if list.is_empty() {
        return format!("        case {constant}: {{ return vec4({color}, {roughness}); }}\n");
    }
    format!(
        "        case {constant}: {{\n            let p = read_{prefix}(material, at);\n            \
             return vec4({color}, {roughness});\n        }}\n"
    )
}

/// `MODEL_OREN_NAYAR`.
fn constant(model: BrdfModel) -> String {
    format!("MODEL_{}", model.key().replace('-', "_").to_uppercase())
}

/// What the functions of a model begin with: `oren_nayar`.
fn prefix(model: BrdfModel) -> String {
    match model {
        // The name of the language is none in it.
        BrdfModel::Wgsl => "unwritten".into(),
        _ => model.key().replace('-', "_"),
    }
}

/// The structure of a model's parameters, and how it is read.
fn parameters(entry: &Entry) -> String {
    let Entry { parameters_name, prefix, list, mapped, has_structure, .. } = entry;
    if list.is_empty() {
        return String::new();
    }
    let field = |p: &Parameter| format!("    {}: {},\n", p.name, if p.is_color() { "vec3<f32>" } else { "f32" });
    let read = |(index, p): (usize, &Parameter)| {
        let quantity = if p.is_color() { "color" } else { "number" };
        let least = if p.map == MapUse::ScalesAboveOne { 1.0 } else { 0.0 };
        let [low, high] = p.range;
        match mapped.contains(&p.name) {
            true => {
                format!("        material_{quantity}(material, {index}u, at, vec2({low:?}, {high:?}), {least:?}),\n")
            }
            false => format!("        plain_{quantity}(material, {index}u, vec2({low:?}, {high:?})),\n"),
        }
    };
    let fields: String = list.iter().map(field).collect();
    let reads: String = list.iter().enumerate().map(read).collect();
    let structure = if *has_structure { String::new() } else { format!("\nstruct {parameters_name} {{\n{fields}}}\n") };
    format!(
        "{structure}
fn read_{prefix}(material: u32, at: SurfaceAttributes) -> {parameters_name} {{
    return {parameters_name}(
{reads}    );
}}
"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::shaders::ShaderSource;
    use lapidary_core::material::BUMP;

    fn text(set: &ModelSet) -> String {
        let [dispatch, written] = ShaderSource::Embedded.templates().unwrap();
        set.text([&dispatch, &written])
    }

    /// The text and what lays out its materials follow from the lists of what is rendered.
    #[test]
    fn shaders_know_nothing_of_what_is_only_stored() {
        let text = text(&ModelSet::all());
        let has = |p: &Parameter| [&text, BrdfModel::OpenPbr.wgsl()].iter().any(|text| text.contains(p.name));
        assert!(!BrdfModel::OpenPbr.stored_parameters().iter().any(has));
        assert!(BrdfModel::OpenPbr.own_parameters().iter().all(has), "negative control");
    }

    fn set_of(material: Material) -> ModelSet {
        ModelSet::of(&Appearance { materials: vec![material], textures: Vec::new(), assigned: None })
    }

    #[test]
    fn shaders_look_up_only_the_maps_and_have_only_the_parts_that_materials_have() {
        let plain = Material { model: BrdfModel::OpenPbr, ..Default::default() };
        let mut rich = plain.clone();
        rich.parameters.set("coat_weight", 0.5);
        rich.parameters.set("base_metalness", 1.0);
        rich.maps.set("base_color", Some(Default::default()));
        let [plain, rich] = [plain, rich].map(set_of);
        let (bare, full) = (text(&plain), text(&rich));
        assert!(bare.contains("plain_color(material, ") && !bare.contains("material_color("));
        assert!(bare.contains("const HAS_COAT: bool = false;") && bare.contains("const HAS_METAL: bool = false;"));
        assert!(full.contains("const HAS_COAT: bool = true;") && full.contains("const HAS_METAL: bool = true;"));
        assert_eq!(full.matches("material_color(").count(), 1, "of one parameter alone");
        assert!(rich.covers(&plain) && !plain.covers(&rich));
        let other = set_of(Material { model: BrdfModel::Ggx, ..Default::default() });
        assert!(!rich.covers(&other) && rich.joined(&other).covers(&other) && rich.joined(&other).covers(&rich));
        let mut bumped = Material { model: BrdfModel::OpenPbr, ..Default::default() };
        bumped.maps.set(BUMP, Some(Default::default()));
        assert!(plain.covers(&set_of(bumped.clone())), "bumps have passes of their own");
        bumped.parameters.set("fuzz_weight", 0.1);
        assert!(!plain.covers(&set_of(bumped)), "a part alone");
    }

    #[test]
    fn a_material_that_stores_more_has_the_same_shaders() {
        let text = |material: Material| text(&set_of(material));
        let plain = Material { model: BrdfModel::OpenPbr, ..Default::default() };
        let mut glass = plain.clone();
        glass.parameters.set("transmission_weight", 1.0);
        assert_eq!(text(glass), text(plain.clone()));
        assert_ne!(text(Material { model: BrdfModel::Ggx, ..plain.clone() }), text(plain), "negative control");
    }
}
