//! Converts a document to a material.

use super::{
    candidates::{Candidate, category, choose},
    graph::{Found, Graph, Picture, Relief, Unread},
    placement::Placement,
    stretch,
    surface::{OPACITY_CUTOFF, Row, Surface},
};
use crate::material_file::{MaterialFile, SlotFile};
use glam::Vec3;
use lapidary_core::{
    brdf::{BrdfModel, MapUse, Parameter, Value},
    material::{BUMP, NORMAL},
    texture::Channel,
};
use roxmltree::{Document, Node, ParsingOptions};
use thiserror::Error;

/// Largest number of elements, comments and texts in a document. MaterialX's own libraries have 50,000.
const MOST_NODES: u32 = 1_000_000;

/// Longest document in bytes.
const MOST_BYTES: usize = 64 << 20;

/// Why a document yields no material.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MaterialXError {
    /// It is not XML, or refers to entities, which are not supported.
    #[error("{0}")]
    Xml(String),
    /// It is too long.
    #[error("it has {found} MB, more than the {limit} MB that are read; split it up")]
    TooLong {
        /// Its length in megabytes.
        found: usize,
        /// The largest length in megabytes.
        limit: usize,
    },
    /// It is not MaterialX, or has no supported material.
    #[error("line {line}: {reason}")]
    Contents {
        /// The line.
        line: u32,
        /// The problem.
        reason: String,
    },
    /// An invalid value; the text gives its line.
    #[error("{0}")]
    Value(String),
    /// No material has the requested name.
    #[error("it has no material \"{name}\", but {}", crate::names::listed(known))]
    NoSuchMaterial {
        /// The requested name.
        name: String,
        /// The existing names.
        known: Vec<String>,
    },
}

/// A material of a document.
#[derive(Clone, Debug)]
pub struct ReadMaterial {
    /// The material; its maps name pictures relative to the document.
    pub material: MaterialFile,
    /// Omissions and approximations, in sentences.
    pub remarks: Vec<String>,
}

/// Reads the material called `wanted`, or else the first of a supported surface.
///
/// # Errors
/// A document that is not MaterialX, lacks the material, or has an invalid value. The error gives the line.
pub fn read(text: &str, wanted: Option<&str>) -> Result<ReadMaterial, MaterialXError> {
    with_graph(text, |graph, root| {
        let all = Candidate::all(graph, root);
        let chosen = choose(&all, wanted, graph.line(root))?;
        let mut reader = Reader { graph, remarks: Vec::new() };
        reader.tell_of_others(&all, chosen, wanted.is_some(), root);
        let material = reader.material(chosen)?;
        let mut remarks = reader.remarks;
        remarks.extend(graph.take_remarks());
        Ok(ReadMaterial { material, remarks })
    })
}

/// The names of the materials that [`read`] supports, in the order of the document.
///
/// # Errors
/// A document that is not MaterialX.
pub fn names(text: &str) -> Result<Vec<String>, MaterialXError> {
    with_graph(text, |graph, root| {
        let all = Candidate::all(graph, root);
        Ok(all.iter().filter(|candidate| candidate.surface().is_some()).map(|c| c.name.to_owned()).collect())
    })
}

/// Parses a document, and calls a function with its graph and its root element.
fn with_graph<R>(
    text: &str,
    make: impl for<'a> FnOnce(&Graph<'a>, Node<'a, 'a>) -> Result<R, MaterialXError>,
) -> Result<R, MaterialXError> {
    if text.len() > MOST_BYTES {
        return Err(MaterialXError::TooLong { found: text.len() >> 20, limit: MOST_BYTES >> 20 });
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..Default::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| MaterialXError::Xml(e.to_string()))?;
    let root = document.root_element();
    let graph = Graph::new(&document);
    if !root.has_tag_name("materialx") {
        let reason = format!("it begins with \"{}\", not with \"materialx\"", root.tag_name().name());
        return Err(MaterialXError::Contents { line: graph.line(root), reason });
    }
    make(&graph, root)
}

struct Reader<'g, 'a> {
    graph: &'g Graph<'a>,
    remarks: Vec<String>,
}

/// An input: its number or color, and its map.
struct Told {
    value: Value,
    slot: Option<SlotFile>,
    /// Added to the map.
    added: f32,
}

impl<'a> Reader<'_, 'a> {
    fn tell_of_others(&mut self, all: &[Candidate], chosen: &Candidate, was_asked: bool, root: Node<'a, 'a>) {
        let others: Vec<String> =
            all.iter().filter(|other| other.name != chosen.name).map(|other| other.name.into()).collect();
        if !was_asked && !others.is_empty() {
            self.remarks.push(format!(
                "it has {} materials, of which \"{}\" was read; add #NAME to the file's name for another: {}",
                all.len(),
                chosen.name,
                crate::names::listed(&others)
            ));
        }
        if root.children().any(|node| node.tag_name().name() == "include") {
            self.remarks.push("it includes other documents, which were not read".into());
        }
    }

    fn material(&mut self, of: &Candidate<'a>) -> Result<MaterialFile, MaterialXError> {
        let Some((shader, surface)) = of.surface() else {
            let found = of.shader.map_or("missing", category);
            let known = Surface::ALL.map(Surface::node).join(", ");
            let reason = format!("the surface of \"{}\" is {found}, and only {known} are read", of.name);
            return Err(MaterialXError::Contents { line: of.line, reason });
        };
        let mut material = MaterialFile { name: of.label.into(), model: BrdfModel::OpenPbr, ..Default::default() };
        for row in surface.rows() {
            self.take(&mut material, shader, row, surface)?;
        }
        self.take_stored(&mut material, shader, surface)?;
        self.finish(&mut material, shader, surface)?;
        self.take_reliefs(&mut material, shader, surface)?;
        self.tell_of_lost(shader, surface);
        let stored: Vec<String> = material.stored().map(|p| p.label.to_lowercase()).collect();
        if !stored.is_empty() {
            self.remarks.push(format!("stored but not rendered: {}", stored.join(", ")));
        }
        Ok(material)
    }

    /// Adds a remark on an input that is valid but not supported.
    fn tell(&mut self, input: &str, unread: Unread) -> Result<(), MaterialXError> {
        match unread {
            Unread::Wrong(text) => Err(MaterialXError::Value(text)),
            Unread::Beyond(text) => {
                self.remarks.push(format!("{text}; \"{input}\" has its default"));
                Ok(())
            }
        }
    }

    /// The value of an input, if it is read.
    fn said(&mut self, shader: Node<'a, 'a>, row: Row) -> Result<Option<Told>, MaterialXError> {
        match self.graph.child(shader, row.input).map(|input| self.graph.input(input)) {
            Some(Ok(found)) => Ok(self.told(found, row)),
            Some(Err(unread)) => self.tell(row.input, unread).map(|()| None),
            None => Ok(None),
        }
    }

    /// Keeps inputs that are stored but not rendered.
    fn take_stored(
        &mut self,
        material: &mut MaterialFile,
        shader: Node<'a, 'a>,
        surface: Surface,
    ) -> Result<(), MaterialXError> {
        for row in surface.stored_rows() {
            let told = self.said(shader, row)?.filter(|told| told.slot.is_some() || told.value != row.default);
            if let (Some(told), Some(parameter)) = (told, BrdfModel::OpenPbr.stored_parameter(row.parameter)) {
                self.set(material, parameter, row, told);
            }
        }
        Ok(())
    }

    /// Assigns an input to its parameter.
    fn take(
        &mut self,
        material: &mut MaterialFile,
        shader: Node<'a, 'a>,
        row: Row,
        surface: Surface,
    ) -> Result<(), MaterialXError> {
        let told = self.said(shader, row)?;
        let is_version_1 = surface == Surface::StandardSurface && shader.attribute("version") == Some("1.0.0");
        let default = match row.input {
            "base" if is_version_1 => Value::Number(0.8),
            "base_color" if is_version_1 => Value::Color(Vec3::ONE),
            _ => row.default,
        };
        let Some(parameter) = BrdfModel::OpenPbr.parameter(row.parameter) else {
            if told.as_ref().is_some_and(|told| told.slot.is_some() || told.value != row.default) {
                self.remarks.push(format!("its {} is left out", row.input.replace('_', " ")));
            }
            return Ok(());
        };
        let told = told.unwrap_or(Told { value: default, slot: None, added: 0.0 });
        self.set(material, parameter, row, told);
        Ok(())
    }

    fn set(&mut self, material: &mut MaterialFile, parameter: &Parameter, row: Row, told: Told) {
        let Told { value, slot, added } = told;
        let base = if slot.is_some() && parameter.map == MapUse::ScalesAboveOne { 1.0 } else { 0.0 };
        let powered = |value: Value, base: f32| match value {
            Value::Number(x) if row.power == 1.0 => Value::Number(base + x),
            Value::Number(x) => Value::Number(base + x.max(0.0).powf(row.power)),
            color => color,
        };
        if added != base {
            self.remarks.push(format!("the map of \"{}\" cannot be shifted so, and is left out", row.input));
            // A factor alone is misleading without the added part, such as -1 for an inverted map.
            material.parameters.set(parameter.name, powered(row.default, 0.0));
            return;
        }
        let value = powered(value, base);
        if slot.is_some() && row.power != 1.0 {
            self.remarks.push(format!("the map of \"{}\" is taken as it is, without a change of its scale", row.input));
        }
        material.parameters.set(parameter.name, value);
        material.maps.set(parameter.name, slot);
    }

    /// Converts an input to the kind of its parameter.
    fn told(&mut self, found: Found, row: Row) -> Option<Told> {
        let is_color = matches!(row.default, Value::Color(_));
        match found {
            Found::Constant(numbers) => {
                let value = match (numbers.as_slice(), is_color) {
                    ([x, y, z, ..], true) => Value::Color(Vec3::new(*x, *y, *z)),
                    ([x], true) => Value::Color(Vec3::splat(*x)),
                    ([x, ..], false) => Value::Number(*x),
                    _ => {
                        self.remarks.push(format!(
                            "\"{}\" has {} numbers, and has its default",
                            row.input,
                            numbers.len()
                        ));
                        return None;
                    }
                };
                Some(Told { value, slot: None, added: 0.0 })
            }
            Found::Picture(picture) => {
                if is_color && (picture.channel.is_some() || !picture.is_color) {
                    self.remarks.push(format!("the map of \"{}\" is taken for one of colors", row.input));
                }
                let value = if is_color { Value::Color(picture.factor) } else { Value::Number(picture.factor.x) };
                let added = picture.added.x;
                Some(Told { value, slot: self.slot(&picture, row.input)?.into(), added })
            }
        }
    }

    fn slot(&mut self, picture: &Picture, input: &str) -> Option<SlotFile> {
        let Some(Placement { scale, offset, rotation_degrees }) = Placement::of_document(picture.transform) else {
            self.remarks.push(format!("the map of \"{input}\" is skewed, and is left out"));
            return None;
        };
        Some(SlotFile {
            file: picture.file.clone(),
            color_space: Some(picture.color_space),
            channel: picture.channel.unwrap_or(Channel::R),
            scale,
            offset,
            rotation_degrees,
            strength: 1.0,
            flip_y: false,
            procedural: None,
            wrap: Default::default(),
            uv_set: Default::default(),
        })
    }

    /// Resolves inputs that depend on each other.
    fn finish(
        &mut self,
        material: &mut MaterialFile,
        shader: Node<'a, 'a>,
        surface: Surface,
    ) -> Result<(), MaterialXError> {
        match surface {
            Surface::OpenPbr => {}
            Surface::StandardSurface => {
                let is_metal =
                    material.parameters.number("base_metalness") > 0.0 && material.maps.get("base_metalness").is_none();
                if is_metal {
                    // There the weight belongs to the tint at the edge, here to the metal.
                    material.parameters.set("specular_weight", 1.0);
                }
                stretched(material, stretch::of_burley);
                stretched_coat(material);
            }
            Surface::GltfPbr => {
                let has_sheen = material.parameters.color("fuzz_color").max_element() > 0.0
                    || material.maps.get("fuzz_color").is_some();
                material.parameters.set("fuzz_weight", if has_sheen { 1.0 } else { 0.0 });
                material.parameters.set("coat_ior", 1.5);
                material.parameters.set("coat_darkening", 0.0);
                stretched(material, stretch::of_gltf);
                self.alpha(material, shader)?;
            }
        }
        if let Some(input) = surface.thin_walled().and_then(|name| self.graph.child(shader, name)) {
            material.double_sided = input.attribute("value") == Some("true");
        }
        Ok(())
    }

    /// Cutout as in glTF.
    fn alpha(&mut self, material: &mut MaterialFile, shader: Node<'a, 'a>) -> Result<(), MaterialXError> {
        const OPACITY: &str = "geometry_opacity";
        let [mode, cutoff] = [("alpha_mode", 0.0), ("alpha_cutoff", 0.5)]
            .map(|(name, default)| self.graph.constant(shader, name, &[default]).map(|numbers| numbers[0]));
        let unread = |unread| match unread {
            Unread::Wrong(text) | Unread::Beyond(text) => MaterialXError::Value(text),
        };
        let (mode, cutoff) = (mode.map_err(unread)?, cutoff.map_err(unread)?);
        if mode == 0.0 {
            material.parameters.set(OPACITY, 1.0);
            material.maps.set(OPACITY, None);
        }
        if mode == 1.0 {
            material.parameters.set(OPACITY_CUTOFF, cutoff);
        }
        Ok(())
    }

    fn take_reliefs(
        &mut self,
        material: &mut MaterialFile,
        shader: Node<'a, 'a>,
        surface: Surface,
    ) -> Result<(), MaterialXError> {
        let Some(input) = self.graph.child(shader, surface.normal()) else { return Ok(()) };
        let reliefs = match self.graph.reliefs(input) {
            Ok(reliefs) => reliefs,
            Err(unread) => return self.tell(surface.normal(), unread),
        };
        for (name, relief) in [NORMAL, BUMP].into_iter().zip(reliefs) {
            let Some(Relief { picture, strength }) = relief else { continue };
            // An inverted green channel is DirectX's convention.
            let flip_y = name == NORMAL && picture.factor.y < 0.0;
            let slot = self.slot(&picture, surface.normal());
            material.maps.set(name, slot.map(|slot| SlotFile { strength, flip_y, ..slot }));
        }
        Ok(())
    }

    /// Adds remarks on inputs without effect, and on unknown ones.
    fn tell_of_lost(&mut self, shader: Node<'a, 'a>, surface: Surface) {
        let lost: Vec<&str> = surface
            .lost()
            .iter()
            .filter(|(name, _)| self.graph.child(shader, name).is_some_and(|input| self.shows(input)))
            .map(|(_, what)| *what)
            .collect();
        if !lost.is_empty() {
            self.remarks.push(format!("left out: {}", lost.join(", ")));
        }
        for input in shader.children().filter(|node| ["input", "bindinput"].contains(&node.tag_name().name())) {
            let name = input.attribute("name").unwrap_or_default();
            if !surface.knows(name) {
                let line = self.graph.line(input);
                self.remarks
                    .push(format!("line {line}: {} has no input \"{name}\", which is left out", surface.node()));
            }
        }
    }

    /// Whether an input has an effect: it is connected, or a number other than 0. A normal's value is its default.
    fn shows(&self, input: Node<'a, 'a>) -> bool {
        match self.graph.input(input) {
            Ok(Found::Constant(numbers)) => numbers.len() == 1 && numbers[0] != 0.0,
            Ok(Found::Picture(_)) => true,
            Err(_) => input.attribute("value").is_none(),
        }
    }
}

/// Sets OpenPBR's roughness and anisotropy for the lobe whose widths `widths` computes from the input.
fn stretched(material: &mut MaterialFile, widths: impl Fn(f32, f32) -> stretch::Widths) {
    change_stretch(material, ["specular_roughness", "specular_roughness_anisotropy"], widths);
}

fn stretched_coat(material: &mut MaterialFile) {
    change_stretch(material, ["coat_roughness", "coat_roughness_anisotropy"], stretch::of_burley);
}

fn change_stretch(material: &mut MaterialFile, names: [&'static str; 2], widths: impl Fn(f32, f32) -> stretch::Widths) {
    let [roughness, anisotropy] = names.map(|name| material.parameters.number(name));
    let is_mapped = names.iter().any(|name| material.maps.get(name).is_some());
    if anisotropy > 0.0 && !is_mapped {
        let lobe = stretch::to_openpbr(widths(roughness, anisotropy));
        names.into_iter().zip(lobe).for_each(|(name, number)| material.parameters.set(name, number));
    }
}
