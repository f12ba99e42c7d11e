//! Texture coordinates at the corners of faces, and colors of faces: a vertex on a seam has several.

use super::{Face, Vertex, shows_colors_of_faces};
use glam::{Vec2, Vec3};
use std::{borrow::Cow, collections::HashMap};

/// The vertices of a mesh, each with one pair of texture coordinates and one color.
pub(super) struct Wedges<'a> {
    /// Indices of the file's vertices.
    of_file: Vec<u32>,
    pub uvs: Vec<Vec2>,
    /// sRGB encoded.
    pub colors: Vec<Vec3>,
    /// The vertices of each face. Indices out of range stay so.
    pub corners: Vec<Cow<'a, [u32]>>,
    /// Faces whose coordinates do not fit their corners.
    unfit: usize,
}

impl<'a> Wedges<'a> {
    /// Splits the vertices of a file where faces disagree.
    pub fn of(vertices: &[Vertex], faces: &'a [Face]) -> Self {
        let mut all = Self {
            of_file: (0..vertices.len() as u32).collect(),
            uvs: vertices.iter().map(|vertex| vertex.uv).collect(),
            colors: vertices.iter().map(|vertex| vertex.color).collect(),
            corners: Vec::with_capacity(faces.len()),
            unfit: 0,
        };
        let shows_colors = shows_colors_of_faces(vertices, faces);
        let mut known = HashMap::new();
        for face in faces {
            let (uvs, rest) = face.uvs.as_chunks::<2>();
            let fits = uvs.len() == face.corners.len() && rest.is_empty();
            all.unfit += usize::from(!fits && !face.uvs.is_empty());
            if !fits && !shows_colors {
                all.corners.push(Cow::Borrowed(&face.corners));
                continue;
            }
            let mut split = |(at, &corner): (usize, &u32)| {
                let Some(vertex) = vertices.get(corner as usize) else { return u32::MAX };
                let uv = if fits { Vec2::from_array(uvs[at]) } else { vertex.uv };
                let color = if shows_colors { face.color } else { vertex.color };
                let key = (corner, uv.to_array().map(f32::to_bits), color.to_array().map(f32::to_bits));
                let next = all.uvs.len() as u32;
                let index = *known.entry(key).or_insert(next);
                if index == next {
                    all.of_file.push(corner);
                    all.uvs.push(uv);
                    all.colors.push(color);
                }
                index
            };
            let corners = face.corners.iter().enumerate().map(&mut split).collect();
            all.corners.push(corners);
        }
        all
    }

    /// A value for each vertex, by the index of the file's vertex.
    pub fn each<T>(&self, value: impl Fn(usize) -> T) -> Vec<T> {
        self.of_file.iter().map(|&vertex| value(vertex as usize)).collect()
    }

    /// What is left out.
    pub fn remark(&self) -> Option<String> {
        (self.unfit > 0).then(|| {
            format!(
                "{} faces have texture coordinates for another number of corners, which were left out; export the mesh as \
                 triangles",
                self.unfit
            )
        })
    }
}
