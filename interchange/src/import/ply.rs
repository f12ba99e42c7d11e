//! Stanford PLY, ascii and binary, parsed by `ply-rs-bw`.

use super::{
    files::{Files, Trouble},
    polygon::Polygons,
    recenter,
    repair::RawMesh,
};
use crate::import::{
    report::ImportError,
    source::{Source, check_count, colors_left_out},
};
use glam::{DVec3, Vec2, Vec3, Vec4};
use lapidary_core::{material::Material, scene::Object};
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{Property, PropertyAccess, PropertyAccessResult},
};
use std::{io::ErrorKind, path::Path};

pub(super) fn read(bytes: &[u8], path: &Path, mut files: Files) -> Result<Source, ImportError> {
    let parse_error = |reason: String| Trouble::from(reason).at(path, "PLY");
    let mut reader = Reader::new(bytes);
    let header = Parser::<Vertex>::new().read_header(&mut reader);
    let header = header.map_err(|error| parse_error(told(&error, "its header", "is not as PLY defines it")))?;
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
    let mut source = source(&vertices, &faces, path);
    let has_colors = header.elements.get("vertex").is_some_and(|vertex| vertex.properties.contains_key("red"));
    source.warnings.extend(has_colors.then(|| colors_left_out(count("vertex"))));
    Ok(source)
}

/// What is wrong with a part of the file.
fn told(error: &ParseError, part: &str, wrong: &str) -> String {
    let place = error.line().map_or_else(|| format!("something in {part}"), |line| format!("line {line} in {part}"));
    match error.kind() {
        ErrorKind::UnexpectedEof => format!("it ends within {part}"),
        _ => format!("{place} {wrong}"),
    }
}

fn source(vertices: &[Vertex], faces: &[Face], path: &Path) -> Source {
    let mut positions: Vec<Vec3> = vertices.iter().map(|v| v.position.as_vec3()).collect();
    let used = faces.iter().flat_map(|face| &face.corners).filter_map(|&corner| positions.get(corner as usize));
    let offset = recenter::offset(used.copied());
    if let Some(offset) = offset {
        positions = vertices.iter().map(|v| (v.position - offset).as_vec3()).collect();
    }
    let mut mesh = RawMesh {
        positions,
        normals: vertices.iter().map(|v| v.normal).collect(),
        // PLY does not define its texture space; its writers count v from the bottom.
        uvs: vertices.iter().map(|v| Vec2::new(v.uv.x, 1.0 - v.uv.y)).collect(),
        tangents: vec![Vec4::ZERO; vertices.len()],
        ..Default::default()
    };
    let mut polygons = Polygons::default();
    for Face { corners } in faces {
        mesh.push_polygon(0, corners, 0, 0, &mut polygons);
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Source {
        mesh,
        materials: vec![Material { name: "default".into(), ..Default::default() }],
        objects: vec![Object { name }],
        warnings: offset.map(recenter::warning).into_iter().collect(),
        ..Default::default()
    }
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
}

impl PropertyAccess for Vertex {
    /// Missing positions are NaN, which the repair reports.
    fn new() -> Self {
        Self { position: DVec3::NAN, normal: Vec3::ZERO, uv: RawMesh::NO_UV }
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
            _ => return PropertyAccessResult::Ignored,
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

#[derive(Clone, Debug)]
struct Face {
    corners: Vec<u32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if name != "vertex_indices" && name != "vertex_index" {
            return PropertyAccessResult::Ignored;
        }
        let Some(corners) = value.to_u32_list() else { return PropertyAccessResult::UnsupportedType };
        self.corners = corners;
        PropertyAccessResult::Set
    }
}
