//! What of a document is not rendered, in remarks.

use super::{
    super::{
        candidates::Candidate,
        graph::Found,
        surface::{Lost, Surface},
    },
    Reader,
};
use roxmltree::Node;

impl<'a> Reader<'_, 'a> {
    pub(super) fn tell_of_others(
        &mut self,
        all: &[Candidate],
        chosen: &Candidate,
        was_asked: bool,
        root: Node<'a, 'a>,
    ) {
        let others: Vec<String> =
            all.iter().filter(|other| other.name != chosen.name).map(|other| other.name.into()).collect();
        if !was_asked && !others.is_empty() {
            self.remarks.push(format!(
                "it has {} materials, of which \"{}\" was read; add #NAME to the file's name for another: {}",
                all.len(),
                chosen.name,
                crate::names::listed(&others)
            ));
        }
        if root.children().any(|node| node.has_tag_name("variantset")) {
            self.remarks.push("its variants are left out".into());
        }
    }

    /// Adds remarks on connections of the material and inputs of its surface that have no effect here, and on unknown ones.
    pub(super) fn tell_of_lost(&mut self, of: &Candidate<'a>, shader: Node<'a, 'a>, surface: Surface) {
        let inputs = surface
            .lost()
            .iter()
            .filter(|lost| self.graph.child(shader, lost.input).is_some_and(|input| self.shows(input, lost)));
        let lost: Vec<&str> = of.others.iter().copied().chain(inputs.map(|lost| lost.what)).collect();
        if !lost.is_empty() {
            self.remarks.push(format!("left out: {}", lost.join(", ")));
        }
        for input in shader.children().filter(|node| ["input", "bindinput"].contains(&node.tag_name().name())) {
            let name = input.attribute("name").unwrap_or_default();
            if !surface.knows(name) {
                let place = self.graph.place(input);
                self.remarks.push(format!("{place}: {} has no input \"{name}\", which is left out", surface.node()));
            }
        }
    }

    /// Whether an input has an effect: it is connected, or another number than the one without effect. A normal's value
    /// is its default.
    fn shows(&self, input: Node<'a, 'a>, lost: &Lost) -> bool {
        match self.graph.input(input) {
            Ok(Found::Constant(numbers)) => numbers.len() == 1 && numbers[0] != lost.without_effect,
            Ok(Found::Picture(_)) => true,
            Err(_) => input.attribute("value").is_none(),
        }
    }
}
