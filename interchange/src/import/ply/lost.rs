//! What of a file is not rendered, by the names of its elements and properties.

use super::{Face, Vertex, shows_colors_of_faces};
use crate::{
    features::{self, Feature, Format, PLY_OTHERS, Support},
    names::listed,
};
use glam::Vec3;
use ply_rs_bw::ply::{Header, Property, PropertyAccess, PropertyAccessResult};

/// Elements and properties that are left out, in the order of the file.
#[derive(Default)]
pub(super) struct Lost {
    elements: Names,
    of_vertices: Names,
    of_faces: Names,
    /// Whether faces have colors beside those of vertices.
    colors_of_faces: bool,
}

/// The names that have a feature.
type Names = Vec<(Feature, Vec<String>)>;

impl Lost {
    pub fn of(header: &Header, vertices: &[Vertex], faces: &[Face]) -> Self {
        let mut lost = Self {
            colors_of_faces: faces.iter().any(|face| face.color != Vec3::ONE)
                && !shows_colors_of_faces(vertices, faces),
            ..Self::default()
        };
        let vertices_fade = vertices.iter().any(|vertex| vertex.opacity < 1.0);
        let faces_fade = faces.iter().any(|face| face.opacity < 1.0);
        for element in header.elements.values().filter(|element| element.count > 0) {
            let (names, fades, is_read): (_, _, fn(&str) -> bool) = match element.name.as_str() {
                "vertex" => (&mut lost.of_vertices, vertices_fade, is_of_vertices),
                "face" => (&mut lost.of_faces, faces_fade, is_of_faces),
                name => {
                    note(&mut lost.elements, name);
                    continue;
                }
            };
            let is_lost = |name: &&String| if name.ends_with("alpha") { fades } else { !is_read(name) };
            element.properties.keys().filter(is_lost).for_each(|name| note(names, name));
        }
        lost
    }

    /// Why a file without faces is refused, if it has other elements in place of them.
    pub fn in_place_of_faces(&self) -> Option<String> {
        let (feature, names) = self.elements.iter().find(|(feature, _)| *feature != PLY_OTHERS)?;
        Some(format!("it has no faces but {} ({})", feature.name, listed(names)))
    }

    pub fn warnings(&self) -> Vec<String> {
        let parts = [
            (&self.elements, "elements"),
            (&self.of_vertices, "properties of vertices"),
            (&self.of_faces, "properties of faces"),
        ];
        let all = parts.into_iter().flat_map(|(names, things)| {
            names.iter().filter_map(move |(feature, names)| feature.warning(things, names))
        });
        let colors =
            "the faces have colors beside those of vertices, which are left out; export the colors of faces alone";
        all.chain(self.colors_of_faces.then(|| colors.to_owned())).collect()
    }
}

fn is_of_vertices(name: &str) -> bool {
    Vertex::new().set_property(name, Property::Float(0.0)) != PropertyAccessResult::Ignored
}

fn is_of_faces(name: &str) -> bool {
    Face::new().set_property(name, Property::ListFloat(Vec::new())) != PropertyAccessResult::Ignored
}

fn note(all: &mut Names, name: &str) {
    let of_table = features::of(Format::Ply, name).filter(|feature| feature.support != Support::Read);
    let feature = of_table.unwrap_or(PLY_OTHERS);
    match all.iter_mut().find(|(known, _)| *known == feature) {
        Some((_, names)) => names.push(name.to_owned()),
        None => all.push((feature, vec![name.to_owned()])),
    }
}
