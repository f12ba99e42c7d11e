//! Normal and height maps behind a normal input.

use super::{Found, Graph, Picture, Result, XmlNode};

/// A normal or height map and its strength.
#[derive(Clone, Debug)]
pub struct Relief {
    /// The picture.
    pub picture: Picture,
    /// Scale of normals, or height in meters.
    pub strength: f32,
    /// Whether its normals turn with the picture, as glTF's do; others are those of the surface's own tangents.
    pub turns: bool,
}

impl<'a> Graph<'a> {
    /// The maps behind a normal input: normals and heights.
    pub fn reliefs(&self, input: XmlNode<'a>) -> Result<[Option<Relief>; 2]> {
        self.steps.set(0);
        self.reliefs_behind(input)
    }

    fn reliefs_behind(&self, input: XmlNode<'a>) -> Result<[Option<Relief>; 2]> {
        let Some((node, _)) = self.target(input)? else { return Ok([None, None]) };
        self.step(node)?;
        match node.tag_name().name() {
            "normalmap" | "gltf_normalmap" => Ok([Some(self.normals(node)?), None]),
            "bump" => {
                let [normals, _] = match self.child(node, "normal") {
                    Some(below) => self.reliefs_behind(below)?,
                    None => [None, None],
                };
                let height = self.needed(node, "height")?;
                let Found::Picture(picture) = self.follow(height)? else { return Ok([normals, None]) };
                let strength = self.constant(node, "scale", &[1.0])?[0] * picture.factor.x;
                Ok([normals, Some(Relief { picture: *picture, strength, turns: true })])
            }
            "dot" => self.reliefs_behind(self.needed(node, "in")?),
            // The unmapped normal.
            "normal" => Ok([None, None]),
            other => self.beyond(node, &format!("a normal by the node \"{other}\" is not read")),
        }
    }

    fn normals(&self, node: XmlNode<'a>) -> Result<Relief> {
        let found = if node.has_tag_name("gltf_normalmap") {
            self.image(node, None)?
        } else {
            self.follow(self.needed(node, "in")?)?
        };
        let Found::Picture(picture) = found else { return self.beyond(node, "it has no picture of normals") };
        if self.word(node, "space").is_some_and(|space| space != "tangent") {
            return self.beyond(node, "normals that are not those of tangent space are not read");
        }
        let strength = self.constant(node, "scale", &[1.0])?[0];
        Ok(Relief { picture: *picture, strength, turns: node.has_tag_name("gltf_normalmap") })
    }
}
