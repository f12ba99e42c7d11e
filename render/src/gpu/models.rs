//! The shaders' dispatch to the BRDF models that a scene uses, written from the models' declarations. Models that no material
//! has are not compiled.

use crate::appearance::Appearance;
use lapidary_core::brdf::{BrdfModel, MapUse, Parameter};
use std::fmt::Write;

/// The models that are compiled. The first is always there: a ground that catches shadows is diffuse.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelSet(Vec<BrdfModel>);

impl Default for ModelSet {
    fn default() -> Self {
        Self(vec![DIFFUSE])
    }
}

/// The model of a ground that catches shadows.
const DIFFUSE: BrdfModel = BrdfModel::Lambert;

impl ModelSet {
    /// Those that the materials have.
    pub fn of(appearance: &Appearance) -> Self {
        let is_used = |&model: &BrdfModel| model == DIFFUSE || appearance.materials.iter().any(|m| m.model == model);
        Self(BrdfModel::ALL.iter().copied().filter(is_used).collect())
    }

    /// All of them.
    #[cfg(test)]
    pub fn all() -> Self {
        Self(BrdfModel::ALL.to_vec())
    }

    /// In the order of their list.
    pub fn models(&self) -> &[BrdfModel] {
        &self.0
    }

    /// The parameters of each model, what all of them have in common, and the dispatch.
    pub fn text(&self) -> String {
        let mut text = String::from("// Written from the declarations of the models.\n");
        for (index, &model) in BrdfModel::ALL.iter().enumerate() {
            let name = constant(model);
            writeln!(text, "const {name}: u32 = {index}u;").expect("a string takes all");
        }
        self.0.iter().for_each(|&model| text += &parameters(model));
        text += &self.brdf();
        text
    }

    fn brdf(&self) -> String {
        let each = |f: &dyn Fn(&str, &str, &str) -> String| {
            let line = |&model: &BrdfModel| f(&constant(model), model.type_name(), &prefix(model));
            self.0.iter().map(line).collect::<String>()
        };
        let members = each(&|_, ty, prefix| format!("    {prefix}: {ty},\n"));
        let makes = each(&|name, _, prefix| {
            // What a file says does not stand among the parameters.
            let table = if name == constant(BrdfModel::Merl) { ", materials[material].table" } else { "" };
            format!("        case {name}: {{ brdf.{prefix} = {prefix}_of(read_{prefix}(material, uv){table}); }}\n")
        });
        let reflects = each(&|name, _, prefix| {
            format!("        case {name}: {{ return {prefix}_reflect(brdf.{prefix}, light, wo); }}\n")
        });
        let of = |what: &str| {
            each(&|name, _, prefix| format!("        case {name}: {{ return {prefix}_{what}(brdf.{prefix}); }}\n"))
        };
        let shown = each(&|name, _, prefix| {
            let model = self.0.iter().find(|&&m| constant(m) == name).expect("a model of the set");
            let field = |quantity, none: &str| {
                model.parameter_for(quantity).map_or(none.to_owned(), |p| format!("p.{}", p.name))
            };
            let (color, roughness) = (field("base_color", "vec3(0.0)"), field("roughness", "1.0"));
            format!(
                "        case {name}: {{\n            let p = read_{prefix}(material, uv);\n            \
                 return vec4({color}, {roughness});\n        }}\n"
            )
        });
        let (lobes, albedos) = (of("lobes"), of("albedo"));
        let diffuse = constant(DIFFUSE);
        format!(
            "
// Any of the models.
struct Brdf {{
    model: u32,
{members}}}

// That of a material.
fn brdf_of(material: u32, uv: vec2<f32>) -> Brdf {{
    var brdf: Brdf;
    brdf.model = materials[material].model;
    switch brdf.model {{
{makes}        default: {{}}
    }}
    return brdf;
}}

fn diffuse_brdf(reflectance: vec3<f32>) -> Brdf {{
    var brdf: Brdf;
    brdf.model = {diffuse};
    brdf.lambert = Lambert(reflectance);
    return brdf;
}}

// f_r times the cosine for a light.
fn reflection_of(brdf: Brdf, light: Light, wo: vec3<f32>) -> vec3<f32> {{
    if !(wo.z > 0.0) {{
        return vec3(0.0);
    }}
    switch brdf.model {{
{reflects}        default: {{ return vec3(0.0); }}
    }}
}}

// Widths of its lobes, 0 for none.
fn lobes_of(brdf: Brdf) -> vec3<f32> {{
    switch brdf.model {{
{lobes}        default: {{ return vec3(0.0); }}
    }}
}}

// Albedo for light from the normal.
fn albedo_of(brdf: Brdf) -> vec3<f32> {{
    switch brdf.model {{
{albedos}        default: {{ return vec3(0.0); }}
    }}
}}

// Base colour and roughness of a material, for the views that show them.
fn color_and_roughness(material: u32, uv: vec2<f32>) -> vec4<f32> {{
    switch materials[material].model {{
{shown}        default: {{ return vec4(0.0); }}
    }}
}}
"
        )
    }
}

/// `MODEL_OREN_NAYAR`.
fn constant(model: BrdfModel) -> String {
    format!("MODEL_{}", prefix(model).to_uppercase())
}

/// What the functions of a model begin with: `oren_nayar`.
fn prefix(model: BrdfModel) -> String {
    model.key().replace('-', "_")
}

/// The structure of a model's parameters, and how it is read.
fn parameters(model: BrdfModel) -> String {
    let (ty, prefix) = (model.type_name(), prefix(model));
    let field = |p: &Parameter| format!("    {}: {},\n", p.name, if p.is_color() { "vec3<f32>" } else { "f32" });
    let read = |(index, p): (usize, &Parameter)| {
        let function = if p.is_color() { "material_color" } else { "material_number" };
        let least = if p.map == MapUse::ScalesAboveOne { 1.0 } else { 0.0 };
        let [low, high] = p.range;
        format!("        {function}(material, {index}u, uv, vec2({low:?}, {high:?}), {least:?}),\n")
    };
    let fields: String = model.parameters().iter().map(field).collect();
    let reads: String = model.parameters().iter().enumerate().map(read).collect();
    format!(
        "
struct {ty}Parameters {{
{fields}}}

fn read_{prefix}(material: u32, uv: vec2<f32>) -> {ty}Parameters {{
    return {ty}Parameters(
{reads}    );
}}
"
    )
}
