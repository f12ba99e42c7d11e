//! Wavefront OBJ, parsed by `tobj` after a pass of our own; see [`Outline`].

use super::{
    budget::OverBudget,
    files::{Files, Trouble},
    mtl,
    polygon::Polygons,
    recenter,
    repair::RawMesh,
    textures::TextureLibrary,
};
use crate::{
    import::{
        report::ImportError,
        source::{Source, check_count},
    },
    names::listed,
};
use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{input, scene::Object};
use outline::Outline;
use std::{
    cell::Cell,
    collections::{BTreeSet, HashMap, HashSet},
    io::{BufRead, Read},
    iter::repeat_n,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

mod outline;

pub(super) fn read(bytes: &[u8], path: &Path, mut files: Files) -> Result<Source, ImportError> {
    let failed = |trouble: Trouble| trouble.at(path, "OBJ");
    let parse_error = |reason: String| failed(reason.into());
    if bytes.contains(&0) {
        return Err(parse_error("it holds binary data".into()));
    }
    // The text is copied for `tobj`, and possibly again if it is not UTF-8.
    files.budget.take(2 * bytes.len() as u64).map_err(|over| over.at(path))?;
    let over_budget = |over: OverBudget| over.at(path);
    let mut outline = Outline::new(&String::from_utf8_lossy(bytes), &mut files.budget).map_err(failed)?;
    check_count("vertices", outline.positions, path)?;
    check_count("triangles", outline.triangles, path)?;
    let expected = outline.vertices();
    files.budget.take_mesh(expected, outline.triangles).map_err(over_budget)?;
    let mut source = Source::default();
    files.budget.take(outline.bytes_of_colors()).map_err(over_budget)?;
    outline.paint();
    let mut models = parse(&outline).map_err(parse_error)?;
    let places = models.iter().flat_map(|model| triples(&model.mesh.positions));
    if let Some(offset) = recenter::offset(places) {
        files.budget.take(outline.bytes_of_subtraction()).map_err(over_budget)?;
        outline.subtract(offset);
        models = parse(&outline).map_err(parse_error)?;
        source.origin = Some(offset);
    }
    let vertices: u64 = models.iter().map(|model| model.mesh.positions.len() as u64 / 3).sum();
    files.budget.take_mesh(vertices.saturating_sub(expected), 0).map_err(over_budget)?;
    outline.warn(&mut source.warnings);
    let mut damaged = Damaged::default();
    let (mut polygons, mut smoothing) = (Polygons::default(), outline.smoothing());
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let (mut objects, mut colored) = (HashMap::new(), BTreeSet::new());
    for model in models.iter().filter(|m| !m.mesh.indices.is_empty()) {
        let name = if model.name == "unnamed_object" { stem.to_string() } else { model.name.clone() };
        let object = *objects.entry(name.clone()).or_insert_with(|| {
            source.objects.push(Object { name: name.clone() });
            source.objects.len() as u32 - 1
        });
        let material = model.mesh.material_id.unwrap_or(outline.materials.in_order.len());
        let mesh = &mut source.mesh;
        let base = mesh.positions.len();
        if add_vertices(mesh, &model.mesh) {
            colored.insert(material);
        }
        for corners in faces(&model.mesh) {
            mesh.push_polygon(base, corners, material as u32, object, &mut polygons);
            if let Some(next) = &mut smoothing {
                mesh.triangle_smoothing.resize(mesh.triangles.len(), next());
            }
        }
        damaged.note(&name, &model.mesh);
    }
    damaged.warn(&mut source.warnings);
    add_materials(&mut source, &outline, TextureLibrary::new(files)).map_err(failed)?;
    colored.into_iter().for_each(|material| source.color_by_vertices(material));
    Ok(source)
}

/// Reads lines and counts them, to locate errors.
struct LineCounter<'a> {
    rest: &'a [u8],
    lines: &'a Cell<usize>,
}

impl Read for LineCounter<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.rest.read(buffer)
    }
}

impl BufRead for LineCounter<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(self.rest)
    }

    fn consume(&mut self, amount: usize) {
        let (read, rest) = self.rest.split_at(amount);
        self.lines.set(self.lines.get() + read.iter().filter(|b| **b == b'\n').count());
        self.rest = rest;
    }
}

/// Runs `tobj` over the text. Its materials are the names in use, whether or not a library defines them.
fn parse(outline: &Outline) -> Result<Vec<tobj::Model>, String> {
    let lines = Cell::new(0);
    let library = "mtllib names\n".as_bytes();
    let mut reader = library.chain(LineCounter { rest: outline.text.as_bytes(), lines: &lines });
    let options = tobj::LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };
    let names = |_: &Path| {
        let materials =
            outline.materials.in_order.iter().map(|n| tobj::Material { name: n.clone(), ..Default::default() });
        let indices = outline.materials.in_order.iter().cloned().zip(0..).collect();
        Ok((materials.collect(), indices))
    };
    // tobj computes with indices before it checks them: absurd ones overflow, which panics in debug builds.
    let parsed = catch_unwind(AssertUnwindSafe(|| tobj::load_obj_buf(&mut reader, &options, names)));
    match parsed {
        Ok(Ok((models, _))) => Ok(models),
        Ok(Err(e)) => Err(format!("{e} at or before line {}", lines.get())),
        Err(_) => Err(format!("an index is out of range at or before line {}", lines.get())),
    }
}

fn triples(values: &[f32]) -> impl Iterator<Item = Vec3> {
    values.chunks_exact(3).map(Vec3::from_slice)
}

/// Appends the vertices of one object and material. Normals and texture coordinates on only some of its faces cannot be
/// assigned to vertices, and count as missing. Returns whether they have colors other than white.
fn add_vertices(raw: &mut RawMesh, mesh: &tobj::Mesh) -> bool {
    let base = raw.positions.len();
    let count = base + mesh.positions.len() / 3;
    raw.positions.extend(triples(&mesh.positions));
    if mesh.normals.len() == mesh.positions.len() {
        raw.normals.extend(triples(&mesh.normals));
    }
    if 3 * mesh.texcoords.len() == 2 * mesh.positions.len() {
        // OBJ counts v from the bottom of the picture.
        raw.uvs.extend(mesh.texcoords.chunks_exact(2).map(|uv| Vec2::new(uv[0], 1.0 - uv[1])));
    }
    raw.normals.resize(count, Vec3::ZERO);
    raw.uvs.resize(count, RawMesh::NO_UV);
    raw.tangents.resize(count, Vec4::ZERO);
    let colors: Vec<Vec3> = triples(&mesh.vertex_color).collect();
    raw.push_colors(base, &colors)
}

/// The corners of each face. `tobj` gives no counts if all are triangles.
fn faces(mesh: &tobj::Mesh) -> impl Iterator<Item = &[u32]> {
    let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
    let counts = mesh.face_arities.iter().map(|&count| count as usize).chain(repeat_n(3, triangles));
    counts.scan(&mesh.indices[..], |rest, count| {
        let (corners, after) = rest.split_at_checked(count)?;
        *rest = after;
        Some(corners)
    })
}

/// Objects whose normals or texture coordinates were dropped.
#[derive(Default)]
struct Damaged {
    normals: Vec<String>,
    uvs: Vec<String>,
}

impl Damaged {
    fn note(&mut self, name: &str, mesh: &tobj::Mesh) {
        let partial = |length: usize, width: usize| length > 0 && length / width != mesh.positions.len() / 3;
        if partial(mesh.normals.len(), 3) {
            self.normals.push(name.to_owned());
        }
        if partial(mesh.texcoords.len(), 2) {
            self.uvs.push(name.to_owned());
        }
    }

    fn warn(&self, warnings: &mut Vec<String>) {
        for (what, names) in [("normals", &self.normals), ("texture coordinates", &self.uvs)] {
            if !names.is_empty() {
                warnings.push(format!(
                    "only some faces of {} have {what}, which were rebuilt for all of them; \
                     export these objects with {what} throughout to keep them",
                    listed(names)
                ));
            }
        }
    }
}

fn add_materials(source: &mut Source, outline: &Outline, mut library: TextureLibrary) -> Result<(), Trouble> {
    let mut entries = HashMap::new();
    let mut unread = Vec::new();
    for name in library_names(&outline.libraries.in_order, &mut library.files) {
        match library.files.find(name).and_then(|file| library.files.read(&file)) {
            Ok(bytes) => match input::text(&bytes) {
                Ok(text) => entries.extend(mtl::parse(&String::from_utf8_lossy(&text), &mut library.files.budget)?),
                Err(error) => unread.push(format!("{name} ({error})")),
            },
            Err(Trouble::Memory(over)) => return Err(Trouble::Memory(over)),
            Err(_) => unread.push(name.to_owned()),
        }
    }
    if !unread.is_empty() {
        let warning = format!(
            "the material libraries {} cannot be read and their materials show gray; put them beside the scene",
            listed(&unread)
        );
        source.unread.push(warning.clone());
        source.warnings.push(warning);
    }
    mtl::add_materials(source, &outline.materials.in_order, &entries, &mut library)?;
    let count = source.materials.len() as u32;
    if source.mesh.triangle_material.contains(&count) {
        source.push_default_material();
    }
    library.finish(source);
    Ok(())
}

/// The names of material libraries, each once. A name may contain spaces, and a statement may list several names.
fn library_names<'a>(statements: &'a [String], files: &mut Files) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for statement in statements {
        let is_one = !matches!(files.find(statement), Err(Trouble::Reason(_)));
        let found: Vec<&str> = if is_one { vec![statement] } else { statement.split_whitespace().collect() };
        names.extend(found);
    }
    let mut known = HashSet::new();
    names.retain(|name| known.insert(*name));
    names
}
