//! Stanford PLY, ascii and binary, parsed by `ply-rs-bw`. Textures are named by comments, as MeshLab writes them.

use super::{
    files::{Files, Trouble},
    polygon::Polygons,
    recenter,
    repair::RawMesh,
    textures::TextureLibrary,
};
use crate::import::{
    report::ImportError,
    source::{Source, check_count},
};
use glam::{DVec3, Vec2, Vec3, Vec4};
use lapidary_core::{
    color::linear_from_srgb,
    material::Material,
    scene::Object,
    texture::{ColorSpace, TextureSlot},
};
use lost::Lost;
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType},
};
use std::{io::ErrorKind, path::Path};
use wedges::Wedges;

mod lost;
mod wedges;

pub(super) fn read(bytes: &[u8], path: &Path, mut files: Files) -> Result<Source, ImportError> {
    let parse_error = |reason: String| Trouble::from(reason).at(path, "PLY");
    let mut reader = Reader::new(bytes);
    let header = Parser::<Vertex>::new().read_header(&mut reader);
    let mut header = header.map_err(|error| parse_error(told(&error, "its header", "is not as PLY defines it")))?;
    read_positions_as_doubles(&mut header);
    for element in header.elements.values() {
        check_count("elements", element.count as u64, path)?;
        // A property takes at least a byte, in ascii and binary.
        let least = (element.count as u64).saturating_mul(element.properties.len() as u64);
        if element.properties.is_empty() || least > bytes.len() as u64 {
            return Err(parse_error(format!("it ends before its {} elements \"{}\"", element.count, element.name)));
        }
    }
    // The corners of faces, at four bytes for one of the file.
    files.budget.take(4 * bytes.len() as u64).map_err(|over| over.at(path))?;
    let count = |name: &str| header.elements.get(name).map_or(0, |element| element.count as u64);
    files.budget.take_mesh(count("vertex"), count("face")).map_err(|over| over.at(path))?;
    let (mut vertices, mut faces): (Vec<Vertex>, Vec<Face>) = Default::default();
    for element in header.elements.values() {
        let result = match element.name.as_str() {
            "vertex" => Parser::new().read_payload_for_element(&mut reader, element, &header).map(|v| vertices = v),
            "face" => Parser::new().read_payload_for_element(&mut reader, element, &header).map(|f| faces = f),
            _ => Parser::<Ignored>::new().read_payload_for_element(&mut reader, element, &header).map(drop),
        };
        let part = format!("its elements \"{}\"", element.name);
        result.map_err(|error| parse_error(told(&error, &part, "does not fit the header")))?;
    }
    let triangles: u64 = faces.iter().map(|face| face.corners.len().saturating_sub(2) as u64).sum();
    check_count("triangles", triangles, path)?;
    files.budget.take_mesh(0, triangles.saturating_sub(faces.len() as u64)).map_err(|over| over.at(path))?;
    let lost = Lost::of(&header, &vertices, &faces);
    if let Some(reason) = lost.in_place_of_faces().filter(|_| triangles == 0) {
        return Err(parse_error(reason));
    }
    let are_split = shows_colors_of_faces(&vertices, &faces) || faces.iter().any(|face| !face.uvs.is_empty());
    let corners: u64 = if are_split { faces.iter().map(|face| face.corners.len() as u64).sum() } else { 0 };
    files.budget.take_mesh(corners, 0).map_err(|over| over.at(path))?;
    let mut source = source(&vertices, &faces, path);
    source.warnings.extend(lost.warnings());
    add_textures(&mut source, &header, files).map_err(|trouble| trouble.at(path, "PLY"))?;
    if !source.mesh.colors.is_empty() {
        (0..source.materials.len()).for_each(|material| source.color_by_vertices(material));
    }
    Ok(source)
}

/// Texts may have more digits than `f32` holds, whatever type their header names.
fn read_positions_as_doubles(header: &mut Header) {
    if header.encoding != Encoding::Ascii {
        return;
    }
    let Some(vertex) = header.elements.get_mut("vertex") else { return };
    for name in ["x", "y", "z"] {
        match vertex.properties.get_mut(name) {
            Some(property) if property.data_type == PropertyType::Scalar(ScalarType::Float) => {
                property.data_type = PropertyType::Scalar(ScalarType::Double);
            }
            _ => {}
        }
    }
}

/// What is wrong with a part of the file.
fn told(error: &ParseError, part: &str, wrong: &str) -> String {
    let place = error.line().map_or_else(|| format!("something in {part}"), |line| format!("line {line} in {part}"));
    match error.kind() {
        ErrorKind::UnexpectedEof => format!("it ends within {part}"),
        _ => format!("{place} {wrong}"),
    }
}

/// Whether the colors of faces are shown: those of vertices are not, or all white.
fn shows_colors_of_faces(vertices: &[Vertex], faces: &[Face]) -> bool {
    faces.iter().any(|face| face.color != Vec3::ONE) && vertices.iter().all(|vertex| vertex.color == Vec3::ONE)
}

fn source(vertices: &[Vertex], faces: &[Face], path: &Path) -> Source {
    let wedges = Wedges::of(vertices, faces);
    let mut positions: Vec<Vec3> = wedges.each(|v| vertices[v].position.as_vec3());
    let corners = wedges.corners.iter().flat_map(|corners| corners.iter());
    let used = corners.filter_map(|&corner| positions.get(corner as usize));
    let offset = recenter::offset(used.copied());
    if let Some(offset) = offset {
        positions = wedges.each(|v| (vertices[v].position - offset).as_vec3());
    }
    let mut mesh = RawMesh {
        normals: wedges.each(|v| vertices[v].normal),
        // PLY does not define its texture space; its writers count v from the bottom.
        uvs: wedges.uvs.iter().map(|uv| Vec2::new(uv.x, 1.0 - uv.y)).collect(),
        tangents: vec![Vec4::ZERO; positions.len()],
        positions,
        ..Default::default()
    };
    if wedges.colors.iter().any(|color| *color != Vec3::ONE) {
        let colors: Vec<Vec3> = wedges.colors.iter().map(|color| color.map(linear_from_srgb)).collect();
        mesh.push_colors(0, &colors);
    }
    let mut polygons = Polygons::default();
    for (corners, face) in wedges.corners.iter().zip(faces) {
        mesh.push_polygon(0, corners, face.texture, 0, &mut polygons);
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Source {
        mesh,
        objects: vec![Object { name }],
        origin: offset,
        warnings: wedges.remark().into_iter().collect(),
        ..Default::default()
    }
}

/// Adds a material for each texture, and one without a texture for faces that name none.
fn add_textures(source: &mut Source, header: &Header, files: Files) -> Result<(), Trouble> {
    let mut library = TextureLibrary::new(files);
    let names = header.comments.iter().filter_map(|comment| comment.trim().strip_prefix("TextureFile"));
    for name in names.map(str::trim).filter(|name| !name.is_empty()) {
        let texture = library.load(name)?;
        let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut material = Material { name: stem, ..Default::default() };
        material.parameters.set("base_color", Vec3::ONE);
        let slot = TextureSlot { texture, color_space: ColorSpace::Srgb, ..Default::default() };
        material.maps.set("base_color", Some(slot));
        source.materials.push(material);
    }
    let count = source.materials.len() as u32;
    source.mesh.triangle_material.iter_mut().for_each(|material| *material = (*material).min(count));
    if count == 0 || source.mesh.triangle_material.contains(&count) {
        source.push_default_material();
    }
    library.finish(source);
    Ok(())
}

/// An element that a mesh does not use.
#[derive(Clone, Debug)]
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }

    fn set_property(&mut self, _name: &str, _value: Property) -> PropertyAccessResult {
        PropertyAccessResult::Ignored
    }
}

#[derive(Clone, Debug)]
struct Vertex {
    /// In double precision: maps have coordinates of millions of meters.
    position: DVec3,
    normal: Vec3,
    uv: Vec2,
    /// sRGB encoded, 0 to 1.
    color: Vec3,
    opacity: f32,
}

impl PropertyAccess for Vertex {
    /// Missing positions are NaN, which the repair reports.
    fn new() -> Self {
        Self { position: DVec3::NAN, normal: Vec3::ZERO, uv: RawMesh::NO_UV, color: Vec3::ONE, opacity: 1.0 }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let target = match name {
            "x" => return set_double(&mut self.position.x, &value),
            "y" => return set_double(&mut self.position.y, &value),
            "z" => return set_double(&mut self.position.z, &value),
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            "u" | "s" | "texture_u" | "texture_s" => &mut self.uv.x,
            "v" | "t" | "texture_v" | "texture_t" => &mut self.uv.y,
            _ => return set_color(&mut self.color, &mut self.opacity, name, &value),
        };
        let Some(number) = value.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        *target = number;
        PropertyAccessResult::Set
    }
}

fn set_double(target: &mut f64, value: &Property) -> PropertyAccessResult {
    let number = match *value {
        Property::Int(number) => Some(number.into()),
        Property::UInt(number) => Some(number.into()),
        Property::Double(number) => Some(number),
        _ => value.to_f32_lossy().map(f64::from),
    };
    let Some(number) = number else { return PropertyAccessResult::UnsupportedType };
    *target = number;
    PropertyAccessResult::Set
}

/// Sets a component of a color or an opacity.
fn set_color(color: &mut Vec3, opacity: &mut f32, name: &str, value: &Property) -> PropertyAccessResult {
    let target = match name {
        "red" | "diffuse_red" => &mut color.x,
        "green" | "diffuse_green" => &mut color.y,
        "blue" | "diffuse_blue" => &mut color.z,
        "alpha" | "diffuse_alpha" => opacity,
        _ => return PropertyAccessResult::Ignored,
    };
    set_fraction(target, value)
}

/// Integers are fractions of the largest number of 8 bits, or of 16.
fn set_fraction(target: &mut f32, value: &Property) -> PropertyAccessResult {
    let Some(number) = value.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
    *target = match value {
        Property::Float(_) | Property::Double(_) => number,
        Property::UShort(_) => number / 65_535.0,
        _ => number / 255.0,
    };
    PropertyAccessResult::Set
}

#[derive(Clone, Debug)]
struct Face {
    corners: Vec<u32>,
    /// Texture coordinates of the corners, two numbers for each; empty if the vertices have them.
    uvs: Vec<f32>,
    /// Number of the texture; one that is not there means none.
    texture: u32,
    /// As of vertices.
    color: Vec3,
    opacity: f32,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { corners: Vec::new(), uvs: Vec::new(), texture: 0, color: Vec3::ONE, opacity: 1.0 }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        match (name, value) {
            ("vertex_indices" | "vertex_index", value) => {
                let Some(corners) = value.to_u32_list() else { return PropertyAccessResult::UnsupportedType };
                self.corners = corners;
            }
            ("texcoord", Property::ListFloat(uvs)) => self.uvs = uvs,
            ("texcoord", Property::ListDouble(uvs)) => self.uvs = uvs.into_iter().map(|x| x as f32).collect(),
            ("texnumber", value) => {
                let Some(number) = value.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
                self.texture = if number >= 0.0 { number as u32 } else { u32::MAX };
            }
            (name, value) => return set_color(&mut self.color, &mut self.opacity, name, &value),
        }
        PropertyAccessResult::Set
    }
}
