//! The scenes of a glTF file (glTF 2.0, section 3.5.1). One of them is imported: programs store alternatives, and unused
//! scenes.

use crate::names::listed;
use lapidary_core::names::told_apart;

/// The scenes of a file.
pub(super) struct FileScenes {
    /// Their names, told apart; those without a name have one derived from their number.
    pub names: Vec<String>,
    /// The imported one; `None` if no scene has nodes, and all nodes of the file are imported.
    pub shown: Option<usize>,
    /// The one that is imported unless another is wanted.
    pub default: Option<usize>,
    /// Names of the others that have nodes.
    left_out: Vec<String>,
}

/// The scene that a file shows: its default one, or else the first, that has nodes.
fn own(gltf: &gltf::Document) -> Option<usize> {
    let has_nodes = |scene: &gltf::Scene| scene.nodes().next().is_some();
    let scene = gltf.default_scene().filter(has_nodes).or_else(|| gltf.scenes().find(has_nodes));
    scene.map(|scene| scene.index())
}

impl FileScenes {
    /// The scenes of a file, of which the `wanted` one is shown: a name, or a number from 0. By default it is the file's own
    /// choice, else the first with nodes.
    ///
    /// # Errors
    /// The existing names, if `wanted` is not among them.
    pub fn of(gltf: &gltf::Document, wanted: Option<&str>) -> Result<Self, Vec<String>> {
        let name = |scene: gltf::Scene| scene.name().map_or_else(|| format!("scene {}", scene.index()), str::to_owned);
        let names = told_apart(gltf.scenes().map(name).collect());
        let default = own(gltf);
        let shown = match wanted {
            None => default,
            Some(wanted) => {
                let named = names.iter().position(|name| name == wanted);
                let numbered = || wanted.parse().ok().filter(|number| *number < names.len());
                match named.or_else(numbered) {
                    Some(found) => Some(found),
                    None => return Err(names),
                }
            }
        };
        let is_left_out = |scene: &gltf::Scene| Some(scene.index()) != shown && scene.nodes().next().is_some();
        let left_out = gltf.scenes().filter(is_left_out).map(|scene| names[scene.index()].clone()).collect();
        Ok(Self { names, shown, default, left_out })
    }

    /// The remark on scenes that are left out.
    pub fn remark(&self) -> Option<String> {
        let shown = &self.names[self.shown.filter(|_| !self.left_out.is_empty())?];
        let others = listed(&self.left_out);
        Some(format!(
            "the file has several scenes: \"{shown}\" is shown, and {others} left out; choose another in the Scene tab, or with --scene NAME"
        ))
    }
}
