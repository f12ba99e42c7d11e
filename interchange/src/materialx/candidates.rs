//! The materials of a document.

use super::{graph::Graph, read::MaterialXError, surface::Surface};
use roxmltree::Node;

/// A material, or a surface without a material.
pub struct Candidate<'a> {
    /// Its name in the document.
    pub name: &'a str,
    /// Its display name.
    pub label: &'a str,
    /// Its surface, if it has one.
    pub shader: Option<Node<'a, 'a>>,
    /// What else it connects, which is not rendered.
    pub others: Vec<&'a str>,
    pub node: Node<'a, 'a>,
}

/// Inputs of a material beside its surface, and what they are.
const OTHERS: [(&str, &str); 2] =
    [("displacementshader", "displacement"), ("backsurfaceshader", "the surface of its back")];

/// The category of a surface: its element's, or the one its reference names.
pub fn category<'a>(shader: Node<'a, 'a>) -> &'a str {
    if shader.has_tag_name("shaderref") {
        shader.attribute("node").unwrap_or_default()
    } else {
        shader.tag_name().name()
    }
}

impl<'a> Candidate<'a> {
    /// All candidates of a document, in order.
    pub fn all(graph: &Graph<'a>, root: Node<'a, 'a>) -> Vec<Self> {
        let of = |node: Node<'a, 'a>, shader| {
            let name = node.attribute("name").unwrap_or_default();
            let label = node.attribute("uiname").filter(|label| !label.is_empty()).unwrap_or(name);
            Self { name, label, shader, others: Vec::new(), node }
        };
        let materials = root.children().filter(|node| node.has_tag_name("surfacematerial")).map(|node| {
            let input = graph.child(node, "surfaceshader");
            let target = input.and_then(|input| graph.target(input).ok().flatten());
            let is_connected = |input: &Node| ["nodename", "nodegraph"].iter().any(|to| input.has_attribute(*to));
            let has = |name| graph.child(node, name).is_some_and(|input| is_connected(&input));
            let others = OTHERS.into_iter().filter(|(name, _)| has(name)).map(|(_, what)| what).collect();
            Self { others, ..of(node, target.map(|(shader, _)| shader)) }
        });
        // Before version 1.38 a material contains its surface, and may contain its displacement.
        let before = root.children().filter(|node| node.has_tag_name("material")).map(|node| {
            let shaders = || node.children().filter(|child| child.has_tag_name("shaderref"));
            let is_surface = |shader: &Node<'a, 'a>| Surface::of(category(*shader)).is_some();
            let shader = shaders().find(is_surface).or_else(|| shaders().next());
            let others = shaders().filter(|other| Some(*other) != shader).map(category).collect();
            Self { others, ..of(node, shader) }
        });
        let materials: Vec<_> = materials.chain(before).collect();
        if !materials.is_empty() {
            return materials;
        }
        let is_surface = |node: &Node| Surface::of(node.tag_name().name()).is_some();
        root.children().filter(is_surface).map(|node| of(node, Some(node))).collect()
    }

    /// Its surface, if it is of a supported kind.
    pub fn surface(&self) -> Option<(Node<'a, 'a>, Surface)> {
        let shader = self.shader?;
        Some((shader, Surface::of(category(shader))?))
    }

    fn is_called(&self, name: &str) -> bool {
        let shader = self.shader.and_then(|shader| shader.attribute("name"));
        [self.name, self.label].contains(&name) || shader == Some(name)
    }
}

/// The candidate called `wanted`, or the first supported one.
pub fn choose<'b, 'a>(
    all: &'b [Candidate<'a>],
    wanted: Option<&str>,
    place: impl FnOnce() -> String,
) -> Result<&'b Candidate<'a>, MaterialXError> {
    let Some(first) = all.first() else {
        let reason = "it has no material, and no surface that is read";
        return Err(MaterialXError::Contents { place: place(), reason: reason.into() });
    };
    match wanted {
        Some(name) => all.iter().find(|candidate| candidate.is_called(name)).ok_or_else(|| {
            let known = all.iter().map(|candidate| candidate.name.to_owned()).collect();
            MaterialXError::NoSuchMaterial { name: name.into(), known }
        }),
        None => Ok(all.iter().find(|candidate| candidate.surface().is_some()).unwrap_or(first)),
    }
}
