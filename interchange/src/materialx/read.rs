//! Converts a document to a material.

mod lost;
mod resolve;

use super::{
    candidates::{Candidate, category, choose},
    graph::{Found, Graph, Picture, Relief, Unread},
    include::Expanded,
    placement::{Placement, is_turned},
    places::Places,
    surface::{Row, Surface},
};
use crate::material_file::{MaterialFile, SlotFile};
use glam::Vec3;
use lapidary_core::{
    brdf::{BrdfModel, MapUse, Parameter, Value},
    material::{BUMP, NORMAL},
    texture::Channel,
};
use roxmltree::{Document, Node, ParsingOptions};
use std::{borrow::Cow, rc::Rc};
use thiserror::Error;

/// Largest number of elements, comments and texts in a document. MaterialX's own libraries have 50,000.
const MOST_NODES: u32 = 1_000_000;

/// Longest document in bytes.
pub(super) const MOST_BYTES: usize = 64 << 20;

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
    #[error("{place}: {reason}")]
    Contents {
        /// The line, and the document if another one includes it.
        place: String,
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
    read_expanded(Expanded::of(text.into()), wanted)
}

/// Reads a material as [`read`] does, of a document with all that it includes.
pub(crate) fn read_expanded(document: Expanded, wanted: Option<&str>) -> Result<ReadMaterial, MaterialXError> {
    let Expanded { text, remarks, places } = document;
    with_graph(&text, places, |graph, root| {
        let all = Candidate::all(graph, root);
        let chosen = choose(&all, wanted, || graph.place(root))?;
        let mut reader = Reader { graph, remarks };
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
    with_graph(text, Rc::default(), |graph, root| {
        let all = Candidate::all(graph, root);
        Ok(all.iter().filter(|candidate| candidate.surface().is_some()).map(|c| c.name.to_owned()).collect())
    })
}

/// Parses a document, and calls a function with its graph and its root element.
fn with_graph<R>(
    text: &str,
    places: Rc<Places>,
    make: impl for<'a> FnOnce(&Graph<'a>, Node<'a, 'a>) -> Result<R, MaterialXError>,
) -> Result<R, MaterialXError> {
    parsed(text, |document| {
        let root = document.root_element();
        let graph = Graph::new(document, places);
        if !root.has_tag_name("materialx") {
            let reason = format!("it begins with \"{}\", not with \"materialx\"", root.tag_name().name());
            return Err(MaterialXError::Contents { place: graph.place(root), reason });
        }
        make(&graph, root)
    })
}

/// Largest number of prefixes of names that are used without being declared.
const MOST_PREFIXES: usize = 8;

/// Parses a document, and calls a function with it. Prefixes as in `xi:include` need not be declared: MaterialX's own reader
/// does not ask for it.
pub(super) fn parsed<R>(
    text: &str,
    make: impl for<'a> FnOnce(&'a Document<'a>) -> Result<R, MaterialXError>,
) -> Result<R, MaterialXError> {
    if text.len() > MOST_BYTES {
        return Err(MaterialXError::TooLong { found: text.len() >> 20, limit: MOST_BYTES >> 20 });
    }
    let mut text = Cow::Borrowed(text);
    let mut prefixes = 0;
    loop {
        let error = match document_of(&text) {
            Ok(document) => return make(&document),
            Err(error) => error,
        };
        let declared = match &error {
            roxmltree::Error::UnknownNamespace(prefix, _) if prefixes < MOST_PREFIXES => {
                text.replacen("<materialx", &format!("<materialx xmlns:{prefix}=\"urn:{prefix}\""), 1)
            }
            _ => return Err(malformed(&error)),
        };
        (text, prefixes) = (declared.into(), prefixes + 1);
    }
}

fn document_of(text: &str) -> Result<Document<'_>, roxmltree::Error> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..Default::default() };
    Document::parse_with_options(text, options)
}

fn malformed(error: &roxmltree::Error) -> MaterialXError {
    let (text, position) = (error.to_string(), error.pos());
    let reason = text.strip_suffix(&format!(" at {position}")).unwrap_or(&text);
    MaterialXError::Xml(format!("line {}: it is not well-formed XML: {reason}", position.row))
}

struct Reader<'g, 'a> {
    graph: &'g Graph<'a>,
    remarks: Vec<String>,
}

/// An input: its number or color, and its map.
struct Told {
    value: Value,
    slot: Option<SlotFile>,
    /// Added to the map; of a number to all three.
    added: Vec3,
}

impl<'a> Reader<'_, 'a> {
    fn material(&mut self, of: &Candidate<'a>) -> Result<MaterialFile, MaterialXError> {
        let Some((shader, surface)) = of.surface() else {
            let found = of.shader.map_or("missing", category);
            let known = Surface::ALL.map(Surface::node).join(", ");
            let reason = format!("the surface of \"{}\" is {found}, and only {known} are read", of.name);
            return Err(MaterialXError::Contents { place: self.graph.place(of.node), reason });
        };
        let mut material = MaterialFile { name: of.label.into(), model: BrdfModel::OpenPbr, ..Default::default() };
        for row in surface.rows() {
            self.take(&mut material, shader, row, surface)?;
        }
        self.take_stored(&mut material, shader, surface)?;
        self.finish(&mut material, shader, surface)?;
        self.take_reliefs(&mut material, shader, surface)?;
        self.tell_of_lost(of, shader, surface);
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
        let told = told.unwrap_or(Told { value: default, slot: None, added: Vec3::ZERO });
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
        if added != Vec3::splat(base) {
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
                if !is_color && numbers.iter().any(|x| *x != numbers[0]) {
                    self.remarks.push(format!("of the color of \"{}\" only the red is taken", row.input));
                }
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
                Some(Told { value, slot: None, added: Vec3::ZERO })
            }
            Found::Picture(picture) => {
                if is_color && (picture.channel.is_some() || !picture.is_color) {
                    self.remarks.push(format!("the map of \"{}\" is taken for one of colors", row.input));
                }
                let value = if is_color { Value::Color(picture.factor) } else { Value::Number(picture.factor.x) };
                let added = if is_color { picture.added } else { Vec3::splat(picture.added.x) };
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
            wrap: picture.wrap,
            uv_set: picture.uv_set,
        })
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
            let Some(Relief { picture, strength, turns }) = relief else { continue };
            // An inverted green channel is DirectX's convention.
            let flip_y = name == NORMAL && picture.factor.y < 0.0;
            let slot = self.slot(&picture, surface.normal());
            if slot.as_ref().is_some_and(|slot| name == NORMAL && !turns && is_turned(slot)) {
                self.remarks
                    .push("the normals turn with their picture, whose coordinates are turned or mirrored".into());
            }
            material.maps.set(name, slot.map(|slot| SlotFile { strength, flip_y, ..slot }));
        }
        Ok(())
    }
}
