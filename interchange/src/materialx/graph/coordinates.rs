//! The transform of texture coordinates by the nodes before a picture.

use super::{
    super::placement::{placed, tiled, turned},
    Graph, Result, XmlNode,
};
use glam::{Affine2, Mat2, Vec2};
use lapidary_core::texture::UvSet;

impl<'a> Graph<'a> {
    /// The transform of an image node, after the transform of its coordinates.
    pub(super) fn transform(&self, node: XmlNode<'a>) -> Result<Affine2> {
        let own = match node.tag_name().name() {
            "tiledimage" => {
                let real = self.pair(node, "realworldtilesize", Vec2::ONE)?
                    / self.pair(node, "realworldimagesize", Vec2::ONE)?;
                let (tiling, offset) =
                    (self.pair(node, "uvtiling", Vec2::ONE)?, self.pair(node, "uvoffset", Vec2::ZERO)?);
                Affine2::from_scale_angle_translation(real, 0.0, Vec2::ZERO) * tiled(tiling, offset)
            }
            "gltf_image" | "gltf_colorimage" | "gltf_normalmap" => {
                // The numbers are as in KHR_texture_transform.
                let scale = self.pair(node, "scale", Vec2::ONE)?;
                let offset = self.pair(node, "offset", Vec2::ZERO)?;
                let pivot = self.pair(node, "pivot", Vec2::Y)?;
                let degrees = self.constant(node, "rotate", &[0.0])?[0];
                placed(pivot, 1.0 / scale, -degrees, Vec2::new(-offset.x, offset.y), false)
            }
            _ => Affine2::IDENTITY,
        };
        Ok(own * self.before(node, "texcoord")?)
    }

    /// The set of coordinates before the transforms of a picture.
    pub(super) fn uv_set(&self, node: XmlNode<'a>) -> Result<UvSet> {
        let before = ["texcoord", "in", "in1"].into_iter().find_map(|input| self.child(node, input));
        let Some((node, _)) = before.map(|input| self.target(input)).transpose()?.flatten() else {
            return Ok(UvSet::First);
        };
        self.step(node)?;
        if !node.has_tag_name("texcoord") {
            return self.uv_set(node);
        }
        match self.constant(node, "index", &[0.0])?[0] {
            0.0 => Ok(UvSet::First),
            1.0 => Ok(UvSet::Second),
            _ => {
                self.remark(node, "a third set of texture coordinates or a further one is taken for the first");
                Ok(UvSet::First)
            }
        }
    }

    /// The transform behind an input of coordinates, if there is one.
    fn before(&self, node: XmlNode<'a>, input: &str) -> Result<Affine2> {
        self.child(node, input).map_or(Ok(Affine2::IDENTITY), |input| self.coordinates(input))
    }

    fn coordinates(&self, input: XmlNode<'a>) -> Result<Affine2> {
        let Some((node, _)) = self.target(input)? else { return Ok(Affine2::IDENTITY) };
        self.step(node)?;
        match node.tag_name().name() {
            "texcoord" => Ok(Affine2::IDENTITY),
            "place2d" => {
                let number = |name| self.constant(node, name, &[0.0]).map(|numbers| numbers[0]);
                let [pivot, offset] = ["pivot", "offset"].map(|name| self.pair(node, name, Vec2::ZERO));
                let scale = self.pair(node, "scale", Vec2::ONE)?;
                let own = placed(pivot?, scale, number("rotate")?, offset?, number("operationorder")? == 1.0);
                Ok(own * self.before(node, "texcoord")?)
            }
            "rotate2d" => {
                let degrees = self.constant(node, "amount", &[0.0])?[0];
                Ok(turned(degrees) * self.before(node, "in")?)
            }
            "multiply" | "divide" | "add" | "subtract" => self.combined_coordinates(node),
            "dot" => self.before(node, "in"),
            other => self.beyond(node, &format!("coordinates by the node \"{other}\" are not read")),
        }
    }

    /// Coordinates and a constant, which is the second input.
    fn combined_coordinates(&self, node: XmlNode<'a>) -> Result<Affine2> {
        let category = node.tag_name().name();
        let numbers = self.constant(node, "in2", &[if ["add", "subtract"].contains(&category) { 0.0 } else { 1.0 }])?;
        let second = Vec2::new(numbers[0], numbers.get(1).copied().unwrap_or(numbers[0]));
        let own = match category {
            "multiply" => Affine2::from_mat2(Mat2::from_diagonal(second)),
            "divide" => Affine2::from_mat2(Mat2::from_diagonal(1.0 / second)),
            "add" => Affine2::from_translation(second),
            _ => Affine2::from_translation(-second),
        };
        Ok(own * self.before(node, "in1")?)
    }
}
