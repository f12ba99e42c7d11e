//! Converts materials to a document.

use super::{
    color_spaces,
    estimate::leave_out_patterns,
    nearest::nearest,
    placement::{Placement, is_turned},
    surface::{OPACITY_CUTOFF, Row, Surface},
};
use crate::{
    image::split,
    material_file::{MaterialFile, SlotFile},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{MapUse, Parameter, Value},
    material::{BUMP, NORMAL},
    texture::{Channel, ColorSpace, UvSet, Wrap},
};
use quick_xml::{
    Writer,
    events::{BytesDecl, BytesEnd, BytesStart, Event},
};
use std::{collections::BTreeSet, fmt::Display, io};

/// A document.
#[derive(Clone, Debug)]
pub struct Written {
    /// Its text.
    pub text: String,
    /// Features that it lacks, in sentences.
    pub remarks: Vec<String>,
}

/// Writes materials as one document of a surface. Maps name their pictures relative to the document.
///
/// # Errors
/// Only errors of writing to memory.
pub fn write(materials: &[MaterialFile], surface: Surface) -> io::Result<Written> {
    let mut document = DocumentWriter {
        xml: Writer::new_with_indent(Vec::new(), b' ', 2),
        surface,
        names: BTreeSet::new(),
        remarks: Vec::new(),
    };
    document.xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)))?;
    document.open("materialx", &[("version", "1.39".into()), ("colorspace", "lin_rec709".into())])?;
    materials.iter().try_for_each(|material| document.material(material))?;
    document.close("materialx")?;
    let mut bytes = document.xml.into_inner();
    bytes.push(b'\n');
    let text = String::from_utf8(bytes).map_err(io::Error::other)?;
    Ok(Written { text, remarks: document.remarks })
}

type Attribute = (&'static str, String);

struct DocumentWriter {
    xml: Writer<Vec<u8>>,
    surface: Surface,
    /// Names in use.
    names: BTreeSet<String>,
    remarks: Vec<String>,
}

/// The connection of an input, or its value.
enum End {
    Value(String),
    Output { graph: String, output: String },
}

/// A map of an input: the conversion of its texels to the value.
struct Mapped<'a> {
    slot: &'a SlotFile,
    is_color: bool,
    factor: Value,
    added: f32,
}

impl DocumentWriter {
    fn element(name: &'static str, attributes: &[Attribute]) -> BytesStart<'static> {
        let mut start = BytesStart::new(name);
        attributes.iter().for_each(|(name, value)| start.push_attribute((*name, value.as_str())));
        start
    }

    fn open(&mut self, name: &'static str, attributes: &[Attribute]) -> io::Result<()> {
        self.xml.write_event(Event::Start(Self::element(name, attributes)))
    }

    fn empty(&mut self, name: &'static str, attributes: &[Attribute]) -> io::Result<()> {
        self.xml.write_event(Event::Empty(Self::element(name, attributes)))
    }

    fn close(&mut self, name: &'static str) -> io::Result<()> {
        self.xml.write_event(Event::End(BytesEnd::new(name)))
    }

    fn input(&mut self, name: &str, kind: &str, value: impl Display) -> io::Result<()> {
        self.empty("input", &[("name", name.into()), ("type", kind.into()), ("value", value.to_string())])
    }

    fn connected(&mut self, name: &str, kind: &str, node: &str) -> io::Result<()> {
        self.empty("input", &[("name", name.into()), ("type", kind.into()), ("nodename", node.into())])
    }

    /// A unique name of letters, digits and underscores. It also stays unique with the prefix of a surface or graph.
    fn name_like(&mut self, wanted: &str) -> String {
        let letters: String = wanted.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let stem = if letters.starts_with(|c: char| c.is_ascii_alphabetic()) {
            letters
        } else {
            format!("material_{letters}")
        };
        let mut name = stem.clone();
        let all = |name: &str| ["", "SR_", "NG_"].map(|prefix| format!("{prefix}{name}"));
        let mut count = 1;
        while all(&name).iter().any(|name| self.names.contains(name)) {
            count += 1;
            name = format!("{stem}_{count}");
        }
        self.names.extend(all(&name));
        name
    }

    fn material(&mut self, material: &MaterialFile) -> io::Result<()> {
        let name = self.name_like(&material.name);
        let mut remarks = Vec::new();
        let mut nearest = nearest(material, self.surface, &mut remarks);
        if material.double_sided && self.surface.thin_walled().is_none() {
            remarks.push("its surface cannot say that both sides reflect".into());
        }
        if nearest.maps.get(NORMAL).is_some_and(is_turned) {
            remarks.push("its normals turn with their picture here, and with the surface in MaterialX".into());
        }
        leave_out_patterns(&mut nearest.maps, &mut remarks);
        let graph = format!("NG_{name}");
        let mut ends: Vec<(Row, End)> = Vec::new();
        let rendered = self.surface.rows().into_iter().filter_map(|row| Some((row, nearest.parameter(row.parameter)?)));
        let is_stored = |row: Row| nearest.stored().find(|p| p.name == row.parameter).map(|p| (row, p));
        let stored = self.surface.stored_rows().into_iter().filter_map(is_stored);
        let rows: Vec<(Row, &Parameter)> = rendered.chain(stored).collect();
        let reliefs = [NORMAL, BUMP].map(|map| nearest.maps.get(map));
        let has_graph = rows.iter().any(|(row, _)| nearest.maps.get(row.parameter).is_some())
            || reliefs.iter().any(Option::is_some);
        if has_graph {
            self.open("nodegraph", &[("name", graph.clone())])?;
        }
        for (row, parameter) in rows {
            let end = self.end(&nearest, row, parameter, &graph)?;
            ends.push((row, end));
        }
        let normal = self.reliefs(reliefs)?;
        if has_graph {
            self.close("nodegraph")?;
        }
        self.surface_of(&name, &nearest, ends, normal.map(|output| End::Output { graph, output }))?;
        let label = if name == material.name { Vec::new() } else { vec![("uiname", material.name.clone())] };
        let attributes = [vec![("name", name.clone()), ("type", "material".into())], label].concat();
        self.open("surfacematerial", &attributes)?;
        self.connected("surfaceshader", "surfaceshader", &format!("SR_{name}"))?;
        self.close("surfacematerial")?;
        let colors = material.vertex_colors.then(|| "the colors of its vertices are left out".to_owned());
        self.remarks.extend(
            remarks.into_iter().chain(colors).map(|remark| format!("material \"{}\": {remark}", material.name)),
        );
        Ok(())
    }

    fn surface_of(
        &mut self,
        name: &str,
        nearest: &MaterialFile,
        ends: Vec<(Row, End)>,
        normal: Option<End>,
    ) -> io::Result<()> {
        let node = self.surface.node();
        self.open(node, &[("name", format!("SR_{name}")), ("type", "surfaceshader".into())])?;
        for (row, end) in ends {
            // Opacity is a number here and in OpenPBR, and a color in the others.
            let is_color = matches!(row.default, Value::Color(_)) || row.input == "opacity";
            self.end_of(row.input, if is_color { "color3" } else { "float" }, end)?;
        }
        if let Some(end) = normal {
            self.end_of(self.surface.normal(), "vector3", end)?;
        }
        if let Some(input) = self.surface.thin_walled().filter(|_| nearest.double_sided) {
            self.input(input, "boolean", true)?;
        }
        if self.surface == Surface::GltfPbr {
            self.alpha(nearest)?;
        }
        self.close(node)
    }

    fn alpha(&mut self, nearest: &MaterialFile) -> io::Result<()> {
        let cutoff = nearest.parameters.number(OPACITY_CUTOFF);
        let shows =
            nearest.maps.get("geometry_opacity").is_some() || nearest.parameters.number("geometry_opacity") < 1.0;
        let mode = match (cutoff > 0.0, shows) {
            (true, _) => 1,
            (false, true) => 2,
            (false, false) => 0,
        };
        self.input("alpha_mode", "integer", mode)?;
        if mode == 1 {
            self.input("alpha_cutoff", "float", cutoff)?;
        }
        Ok(())
    }

    fn end_of(&mut self, input: &str, kind: &str, end: End) -> io::Result<()> {
        match end {
            End::Value(value) if kind == "color3" && !value.contains(',') => {
                self.input(input, kind, format!("{value}, {value}, {value}"))
            }
            End::Value(value) => self.input(input, kind, value),
            End::Output { graph, output } => {
                let connection = [("nodegraph", graph), ("output", output)];
                let attributes = [[("name", input.to_owned()), ("type", kind.into())], connection].concat();
                self.empty("input", &attributes)
            }
        }
    }

    /// The value of an input, or the output of the nodes written for its map.
    fn end(&mut self, nearest: &MaterialFile, row: Row, parameter: &Parameter, graph: &str) -> io::Result<End> {
        let value = nearest.parameters.value(parameter);
        let unpowered = |x: f32| if row.power == 1.0 { x } else { x.max(0.0).powf(1.0 / row.power) };
        let Some(slot) = nearest.maps.get(row.parameter) else {
            return Ok(End::Value(match value {
                Value::Number(x) => unpowered(x).to_string(),
                Value::Color(c) => triple(c),
            }));
        };
        let added = if parameter.map == MapUse::ScalesAboveOne { 1.0 } else { 0.0 };
        let factor = match value {
            Value::Number(x) => Value::Number(unpowered(x - added)),
            color => color,
        };
        let mapped = Mapped { slot, is_color: parameter.is_color(), factor, added };
        let mut node = self.mapped(row.input, &mapped)?;
        if row.input == "opacity" {
            node = self.node("convert", &format!("{node}_color"), "color3", &[("in", "float", node.clone())])?;
        }
        let output = format!("out_{}", row.input);
        let kind = if parameter.is_color() || row.input == "opacity" { "color3" } else { "float" };
        self.empty("output", &[("name", output.clone()), ("type", kind.into()), ("nodename", node)])?;
        Ok(End::Output { graph: graph.into(), output })
    }

    /// A node with connected inputs; returns its name.
    fn node(
        &mut self,
        category: &'static str,
        name: &str,
        kind: &str,
        inputs: &[(&str, &str, String)],
    ) -> io::Result<String> {
        self.open(category, &[("name", name.into()), ("type", kind.into())])?;
        for (input, kind, node) in inputs {
            self.connected(input, kind, node)?;
        }
        self.close(category)?;
        Ok(name.into())
    }

    /// `multiply` or `add` of a node and a value; returns its name.
    fn combined(
        &mut self,
        category: &'static str,
        name: &str,
        kind: &str,
        node: String,
        value: String,
    ) -> io::Result<String> {
        self.open(category, &[("name", name.into()), ("type", kind.into())])?;
        self.connected("in1", kind, &node)?;
        self.input("in2", kind, value)?;
        self.close(category)?;
        Ok(name.into())
    }

    /// The nodes of a map; returns the name of the last.
    fn mapped(&mut self, input: &str, mapped: &Mapped) -> io::Result<String> {
        let Mapped { slot, is_color, factor, added } = *mapped;
        let kind = if is_color { "color3" } else { "float" };
        let mut node = if is_color { self.image(input, slot, "color3")? } else { self.component(input, slot)? };
        let is_one = factor == Value::Number(1.0) || factor == Value::Color(Vec3::ONE);
        if !is_one {
            let value = match factor {
                Value::Number(x) => x.to_string(),
                Value::Color(c) => triple(c),
            };
            node = self.combined("multiply", &format!("{input}_scaled"), kind, node, value)?;
        }
        if added != 0.0 {
            node = self.combined("add", &format!("{input}_shifted"), kind, node, added.to_string())?;
        }
        Ok(node)
    }

    /// One component of a picture.
    fn component(&mut self, input: &str, slot: &SlotFile) -> io::Result<String> {
        let is_encoded = slot.color_space.is_some_and(|space| space != ColorSpace::Linear);
        let kind = match (slot.channel, is_encoded) {
            (Channel::R, false) => return self.image(input, slot, "float"),
            (Channel::A, true) => "color4",
            (Channel::A, false) => "vector4",
            (_, true) => "color3",
            (_, false) => "vector3",
        };
        let image = self.image(input, slot, kind)?;
        let name = format!("{input}_component");
        self.open("extract", &[("name", name.clone()), ("type", "float".into())])?;
        self.connected("in", kind, &image)?;
        self.input("index", "integer", slot.channel as usize)?;
        self.close("extract")?;
        Ok(name)
    }

    /// A picture; returns the name of its node.
    fn image(&mut self, input: &str, slot: &SlotFile, kind: &str) -> io::Result<String> {
        let placement = Placement { scale: slot.scale, offset: slot.offset, rotation_degrees: slot.rotation_degrees };
        // Tiles repeat and have the first set of coordinates.
        let repeats = slot.wrap == [Wrap::Repeat; 2] && slot.uv_set == UvSet::First;
        let tiling = placement.tiling().filter(|_| repeats);
        let category = if tiling.is_some() { "tiledimage" } else { "image" };
        let name = format!("{input}_picture");
        if tiling.is_none() {
            self.place2d(&format!("{name}_place"), &placement, slot.uv_set)?;
        }
        self.open(category, &[("name", name.clone()), ("type", kind.into())])?;
        let (file, layer) = split(&slot.file).unwrap_or((&slot.file, ""));
        let mut file: Vec<Attribute> =
            vec![("name", "file".into()), ("type", "filename".into()), ("value", file.into())];
        if kind.starts_with("color")
            && let Some(space) = slot.color_space.and_then(|space| color_spaces::written(space, &slot.file))
        {
            file.push(("colorspace", space.into()));
        }
        self.empty("input", &file)?;
        if !layer.is_empty() {
            self.input("layer", "string", layer)?;
        }
        match tiling {
            Some([tiling, offset]) => {
                self.input("uvtiling", "vector2", pair(tiling))?;
                self.input("uvoffset", "vector2", pair(offset))?;
            }
            None => {
                self.connected("texcoord", "vector2", &format!("{name}_place"))?;
                for (input, wrap) in ["uaddressmode", "vaddressmode"].into_iter().zip(slot.wrap) {
                    let mode = match wrap {
                        Wrap::Repeat => "periodic",
                        Wrap::Mirror => "mirror",
                        Wrap::Clamp => "clamp",
                    };
                    self.input(input, "string", mode)?;
                }
            }
        }
        self.close(category)?;
        Ok(name)
    }

    fn place2d(&mut self, name: &str, placement: &Placement, uv_set: UvSet) -> io::Result<()> {
        let coordinates = format!("{name}_texcoord");
        self.open("texcoord", &[("name", coordinates.clone()), ("type", "vector2".into())])?;
        if uv_set == UvSet::Second {
            self.input("index", "integer", 1)?;
        }
        self.close("texcoord")?;
        let (scale, degrees, offset) = placement.place2d();
        self.open("place2d", &[("name", name.into()), ("type", "vector2".into())])?;
        self.connected("texcoord", "vector2", &coordinates)?;
        self.input("pivot", "vector2", pair(Vec2::Y))?;
        self.input("scale", "vector2", pair(scale))?;
        self.input("rotate", "float", degrees)?;
        self.input("offset", "vector2", pair(offset))?;
        self.close("place2d")
    }

    /// The nodes of normals and heights; returns the name of their output.
    fn reliefs(&mut self, [normal, bump]: [Option<&SlotFile>; 2]) -> io::Result<Option<String>> {
        let below = normal.map(|slot| self.normals(slot)).transpose()?;
        let above = match bump {
            Some(slot) => Some(self.heights(slot, below.as_deref())?),
            None => below,
        };
        let Some(node) = above else { return Ok(None) };
        let output = "out_normal".to_owned();
        self.empty("output", &[("name", output.clone()), ("type", "vector3".into()), ("nodename", node)])?;
        Ok(Some(output))
    }

    fn normals(&mut self, slot: &SlotFile) -> io::Result<String> {
        const KIND: &str = "vector3";
        let mut node = self.image("normal", slot, KIND)?;
        if slot.flip_y {
            node = self.combined("multiply", "normal_turned", KIND, node, "1, -1, 1".into())?;
            node = self.combined("add", "normal_flipped", KIND, node, "0, 1, 0".into())?;
        }
        self.open("normalmap", &[("name", "normal_map".into()), ("type", KIND.into())])?;
        self.connected("in", KIND, &node)?;
        self.input("scale", "float", slot.strength)?;
        self.close("normalmap")?;
        Ok("normal_map".into())
    }

    fn heights(&mut self, slot: &SlotFile, below: Option<&str>) -> io::Result<String> {
        let height = self.component("height", slot)?;
        self.open("bump", &[("name", "height_map".into()), ("type", "vector3".into())])?;
        self.connected("height", "float", &height)?;
        self.input("scale", "float", slot.strength)?;
        if let Some(normal) = below {
            self.connected("normal", "vector3", normal)?;
        }
        self.close("bump")?;
        Ok("height_map".into())
    }
}

fn triple(Vec3 { x, y, z }: Vec3) -> String {
    format!("{x}, {y}, {z}")
}

fn pair(Vec2 { x, y }: Vec2) -> String {
    format!("{x}, {y}")
}
