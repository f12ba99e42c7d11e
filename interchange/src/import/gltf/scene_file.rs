//! A parsed glTF file: its buffers, its nodes, and the primitives that clips move.

use super::{
    super::files::{Files, Trouble},
    buffers::Buffers,
    deformations,
    hierarchy::{self, Hierarchy},
    materials,
    primitive::Primitive,
    scenes::FileScenes,
    variants::{self, FileVariants},
};
use crate::{
    import::{
        gltf::{
            completed::Completed,
            document::{Parsed, container, parse},
            hierarchy::node_name,
            primitive::is_surface,
        },
        recenter,
        report::{ImportError, ImportOptions},
        source::{Source, check_count},
    },
    names::listed,
};
use glam::{DVec3, Vec3};
use gltf::{
    json::{animation::Target, validation::Checked},
    mesh::{Mode, Semantic},
};
use lapidary_core::{
    animation::{
        Clip,
        clip::Property,
        nodes::Nodes,
        shape::{Deformation, Posture},
        skin::Skin,
    },
    bounds::Bounds,
    parts::Part,
};
use serde_json::Value;
use std::{
    collections::{HashMap, HashSet},
    path::Path,
};

/// Scale at rest of nodes that have none there and get one from a clip: a thousandth hides them. It is not smaller, because clips
/// find the vertices again by their places at rest, and coordinates of some meters have steps of a micrometer.
const HIDDEN_SCALE: f32 = 1e-3;

/// A parsed file with its buffers and nodes.
pub(super) struct SceneFile {
    pub gltf: gltf::Gltf,
    /// Its JSON, completed.
    pub json: Vec<u8>,
    pub buffers: Buffers,
    pub variants: FileVariants,
    pub scenes: FileScenes,
    pub nodes: Nodes,
    /// Nodes of the scene, parents first.
    order: Vec<usize>,
    /// Nodes whose rotation was normalized.
    pub turned: Vec<String>,
    pub skins: Vec<Result<Skin, String>>,
    /// Animations that had channels without a node.
    pub pointing: HashSet<usize>,
    /// Names of materials with textures that have no picture.
    pub without_picture: Vec<String>,
    /// By texture, its own picture, where one in an extension comes before it.
    pub other_pictures: HashMap<usize, usize>,
    /// What was subtracted from the places of the scene's roots, if they are far from the origin.
    pub origin: Option<DVec3>,
}

impl SceneFile {
    pub fn open(bytes: &[u8], path: &Path, files: &mut Files, options: &ImportOptions) -> Result<Self, ImportError> {
        let failed = |trouble: Trouble| trouble.at(path, "glTF");
        let container = container(bytes, path)?;
        files.budget.take_json(container.json).map_err(|over| over.at(path))?;
        let Parsed { gltf, completed } = parse(&container, path, &mut files.budget)?;
        let Completed { text: json, pointing, without_picture, other_pictures, compressed } = completed;
        let bytes_of_nodes = hierarchy::bytes_of_weights(&gltf).saturating_add(deformations::bytes_of_skins(&gltf));
        files.budget.take(bytes_of_nodes).map_err(|over| over.at(path))?;
        let variant = options.variant.as_deref();
        let variants =
            FileVariants::of(&json, variant).map_err(|known| ImportError::no_variant(path, variant, known))?;
        let wanted = options.scene.as_deref();
        let scenes = FileScenes::of(&gltf, wanted).map_err(|known| ImportError::no_scene(path, wanted, known))?;
        let buffers = Buffers::load(&gltf, &compressed, files).map_err(failed)?;
        let hierarchy = hierarchy::read(&gltf, scenes.shown);
        let skins = deformations::skins(&gltf, &buffers);
        let Hierarchy { nodes, order, turned } = hierarchy;
        let pointing = pointing.into_iter().collect();
        let origin = None;
        let mut file = Self {
            gltf,
            json,
            buffers,
            variants,
            scenes,
            nodes,
            order,
            turned,
            skins,
            pointing,
            without_picture,
            other_pictures,
            origin,
        };
        file.check_size(files, path)?;
        file.bring_near();
        Ok(file)
    }

    /// Moves the roots of a scene that is far from the origin there, in the double precision of the JSON. Roots that a clip moves
    /// stay, since it says where they are.
    fn bring_near(&mut self) {
        // As stored: the crate panics at targets that are not valid.
        let of_root = |Target { path, node, .. }: &Target| {
            let is_root = node.value() < self.gltf.nodes().count() && self.nodes.get(node.value()).parent.is_none();
            is_root && *path == Checked::Valid(gltf::animation::Property::Translation)
        };
        let animations = self.gltf.as_json().animations.iter();
        if animations.flat_map(|animation| &animation.channels).any(|channel| of_root(&channel.target)) {
            return;
        }
        // Declared bounds may be missing or wrong, but are known without reading all positions.
        let declared = |primitive: &gltf::Primitive| bounds_of(primitive).to_vec();
        let read = |primitive: &gltf::Primitive| self.buffers.positions(primitive).unwrap_or_default();
        let Some(origin) = self.offset_of(declared).and_then(|_| self.offset_of(read)) else { return };
        let document: Value = serde_json::from_slice(&self.json).unwrap_or_default();
        for &index in &self.order {
            let node = &document["nodes"][index];
            let at = |list: &Value, first: usize| {
                list.as_array()?
                    .get(first..first + 3)
                    .map(|xyz| DVec3::from_array([0, 1, 2].map(|i| xyz[i].as_f64().unwrap_or_default())))
            };
            if self.nodes.get(index).parent.is_none() {
                let place = at(&node["matrix"], 12).or(at(&node["translation"], 0)).unwrap_or_default();
                self.nodes.place_at_rest(index, (place - origin).as_vec3());
            }
        }
        self.origin = Some(origin);
    }

    /// The offset of the scene at rest from the origin, if it is far away. `positions` gives those of a primitive.
    fn offset_of(&self, positions: impl Fn(&gltf::Primitive) -> Vec<Vec3>) -> Option<DVec3> {
        let at_rest = self.at_rest();
        let mut corners = Vec::new();
        for node in self.nodes_of_scene() {
            let world_from_node = at_rest.world_from_node(node.index());
            for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
                let places = positions(&primitive).into_iter().map(|place| world_from_node.transform_point3(place));
                let Bounds { min, max } = Bounds::around(places);
                corners.extend([min, max]);
            }
        }
        recenter::offset(corners.into_iter().filter(|corner| corner.is_finite()))
    }

    /// Keeps the triangles of nodes that have no extent at rest and get one from a clip: they take [`HIDDEN_SCALE`] instead of 0.
    /// Returns a note.
    pub fn keep_hidden(&mut self, clips: &[Clip]) -> Option<String> {
        let scaled = clips.iter().flat_map(Clip::channels).filter(|channel| channel.property == Property::Scale);
        let mut hidden: Vec<usize> = scaled.map(|channel| channel.node).collect();
        hidden.sort_unstable();
        hidden.dedup();
        hidden.retain(|&node| self.nodes.extend_at_rest(node, HIDDEN_SCALE));
        let all: Vec<gltf::Node> = self.gltf.nodes().collect();
        let names: Vec<String> = hidden.into_iter().map(|node| node_name(&all[node])).collect();
        (!names.is_empty()).then(|| {
            format!(
                "the nodes {} have a scale of 0 at rest, and show at times of an animation that give them one",
                listed(&names)
            )
        })
    }

    pub fn nodes_of_scene(&self) -> impl Iterator<Item = gltf::Node<'_>> {
        let all: Vec<gltf::Node> = self.gltf.nodes().collect();
        self.order.iter().map(move |&index| all[index].clone())
    }

    pub fn at_rest(&self) -> Posture {
        let skins: Vec<Skin> = self.skins.iter().map(|skin| skin.clone().unwrap_or_default()).collect();
        Posture::new(&self.nodes, &skins, self.nodes.at_rest())
    }

    /// Checks the total size of all instances before anything is read.
    fn check_size(&self, files: &mut Files, path: &Path) -> Result<(), ImportError> {
        let (mut vertices, mut triangles, mut deformations) = (0u64, 0u64, 0u64);
        for primitive in self.nodes_of_scene().filter_map(|node| node.mesh()).flat_map(|mesh| mesh.primitives()) {
            let positions = primitive.get(&Semantic::Positions).map_or(0, |a| a.count() as u64);
            let corners = primitive.indices().map_or(positions, |a| a.count() as u64);
            let per_triangle = if primitive.mode() == Mode::Triangles { 3 } else { 1 };
            // Empty instances take time, too.
            vertices = vertices.saturating_add(positions.max(1));
            triangles = triangles.saturating_add((corners / per_triangle).max(1));
            deformations = deformations.saturating_add(deformations::bytes(&primitive, positions));
        }
        check_count("vertices", vertices, path)?;
        check_count("triangles", triangles, path)?;
        let taken = files.budget.take_mesh(vertices, triangles).and_then(|()| files.budget.take(deformations));
        taken.map_err(|over| over.at(path))
    }

    /// Adds the objects of the scene, and calls `each` with their primitives and parts.
    pub fn add_objects(
        &self,
        source: &mut Source,
        mut each: impl FnMut(&mut Source, &gltf::Node, &gltf::Primitive, Part) -> Result<(), ImportError>,
    ) -> Result<(), ImportError> {
        for node in self.nodes_of_scene() {
            let Some(mesh) = node.mesh() else { continue };
            let mut parts = variants::PartsOfNode::new(source, node_name(&node));
            for primitive in mesh.primitives().filter(|p| is_surface(p.mode())) {
                let mut material = |chosen| materials::index_of(source, &self.gltf, &primitive, chosen);
                let place = [mesh.index(), primitive.index()];
                let (own, looks) = (material(self.variants.chosen(place)), self.variants.looks(place, &mut material));
                let part = parts.add(source, own, looks);
                each(source, &node, &primitive, part)?;
            }
        }
        Ok(())
    }

    /// The vertices and triangles of a primitive.
    pub fn primitive(&self, primitive: &gltf::Primitive, path: &Path) -> Result<Primitive, ImportError> {
        let parse_error = |reason: String| Trouble::from(reason).at(path, "glTF");
        let read = Primitive::read(primitive, &self.buffers).map_err(parse_error)?;
        read.check().map_err(|source| ImportError::Mesh { path: path.into(), source })?;
        Ok(read)
    }

    /// The usable deformation of a primitive; `remarks` gets sentences on the rest.
    pub fn deformation(
        &self,
        node: &gltf::Node,
        primitive: &gltf::Primitive,
        remarks: &mut Vec<String>,
    ) -> Deformation {
        let vertices = primitive.get(&Semantic::Positions).map_or(0, |positions| positions.count());
        let (deformation, troubles) = deformations::read(node, primitive, vertices, &self.skins, &self.buffers);
        let told = |trouble| {
            format!("\"{}\" shows without a part of its deformation, {trouble}; export it again", node_name(node))
        };
        remarks.extend(troubles.into_iter().map(told));
        deformation
    }

    /// Nodes, meshes and skins that some clip moves.
    pub fn moving(&self, clips: &[Clip]) -> Moving {
        let channels = || clips.iter().flat_map(Clip::channels);
        let marked = |is_meant: fn(Property) -> bool| {
            let mut marked = vec![false; self.gltf.nodes().count()];
            channels().filter(|c| is_meant(c.property)).for_each(|channel| marked[channel.node] = true);
            marked
        };
        let nodes = self.nodes.carried(&marked(|property| property != Property::Weights));
        let is_carried = |skin: &Skin| skin.joints.iter().any(|&joint| nodes[joint]);
        let skins = self.skins.iter().map(|skin| skin.as_ref().is_ok_and(is_carried)).collect();
        Moving { weights: marked(|property| property == Property::Weights), nodes, skins }
    }
}

/// Two opposite corners of the positions that a primitive declares.
fn bounds_of(primitive: &gltf::Primitive) -> [Vec3; 2] {
    let gltf::mesh::Bounds { min, max } = primitive.bounding_box();
    [min, max].map(Vec3::from_array)
}

/// Indices of the nodes, meshes and skins that clips move.
pub(super) struct Moving {
    nodes: Vec<bool>,
    weights: Vec<bool>,
    skins: Vec<bool>,
}

impl Moving {
    /// Whether clips move a primitive of a node. An unusable skin leaves the primitive to its node.
    pub fn reaches(&self, node: &gltf::Node, primitive: &gltf::Primitive) -> bool {
        let index = node.index();
        let has_targets = primitive.morph_targets().next().is_some();
        self.nodes[index]
            || self.weights[index] && has_targets
            || node.skin().is_some_and(|skin| self.skins[skin.index()])
    }
}
