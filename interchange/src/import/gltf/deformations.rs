//! Skins and morph targets of a glTF file. Unusable ones are reported and left out; the rest shows without them.

use super::buffers::Buffers;
use glam::{Mat4, Vec3};
use gltf::{
    Semantic,
    accessor::{DataType, Dimensions, Iter},
};
use lapidary_core::animation::{
    shape::Deformation,
    skin::{InfluenceSet, Influences, Skin},
    surface::MorphTarget,
};

/// Largest number of sets of four joints per vertex; programs write one or two.
const MOST_SETS: u32 = 64;

/// Peak bytes of a vertex of a morph target.
const TARGET_VERTEX: u64 = 36;

/// Peak bytes of a vertex in a set of joints and weights.
const SET_VERTEX: u64 = 40;

/// Peak bytes of a joint: its node, and its matrices in the skin and in postures.
const JOINT: u64 = 300;

/// Bytes of a file's skins.
pub(super) fn bytes_of_skins(gltf: &gltf::Document) -> u64 {
    gltf.skins().map(|skin| skin.joints().count() as u64 * JOINT).sum()
}

/// All skins of a file by index. An unusable skin gives the reason.
pub(super) fn skins(gltf: &gltf::Document, buffers: &Buffers) -> Vec<Result<Skin, String>> {
    gltf.skins().map(|skin| read_skin(&skin, buffers)).collect()
}

fn read_skin(skin: &gltf::Skin, buffers: &Buffers) -> Result<Skin, String> {
    let joints: Vec<usize> = skin.joints().map(|node| node.index()).collect();
    let Some(accessor) = skin.inverse_bind_matrices() else {
        return Ok(Skin { joints_from_mesh: vec![Mat4::IDENTITY; joints.len()], joints });
    };
    if accessor.count() < joints.len() {
        return Err(format!("it has {} inverse bind matrices for {} joints", accessor.count(), joints.len()));
    }
    let joints_from_mesh = buffers.matrices(&accessor, joints.len())?;
    match joints_from_mesh.iter().position(|matrix| !matrix.is_finite()) {
        Some(joint) => Err(format!("the inverse bind matrix of joint {joint} is not finite")),
        None => Ok(Skin { joints, joints_from_mesh }),
    }
}

/// Bytes of a primitive's deformation.
pub(super) fn bytes(primitive: &gltf::Primitive, vertices: u64) -> u64 {
    let sets = (0..MOST_SETS).take_while(|&set| primitive.get(&Semantic::Joints(set)).is_some()).count() as u64;
    let targets = primitive.morph_targets().count() as u64;
    vertices.saturating_mul(targets.saturating_mul(TARGET_VERTEX).saturating_add(sets * SET_VERTEX))
}

/// The deformation of a primitive of a node, and its unusable parts.
pub(super) fn read(
    node: &gltf::Node,
    primitive: &gltf::Primitive,
    vertices: usize,
    skins: &[Result<Skin, String>],
    buffers: &Buffers,
) -> (Deformation, Vec<String>) {
    let mut troubles = Vec::new();
    let targets = targets(primitive, vertices, buffers).unwrap_or_else(|reason| {
        troubles.push(format!("its morph targets cannot be used: {reason}"));
        Vec::new()
    });
    let skin = node.skin().and_then(|skin| {
        let influences = influences(primitive, vertices, &skins[skin.index()], buffers);
        let told = influences.map_err(|reason| troubles.push(format!("its skin cannot be used: {reason}")));
        told.ok().map(|influences| (skin.index(), influences))
    });
    (Deformation { targets, skin }, troubles)
}

fn influences(
    primitive: &gltf::Primitive,
    vertices: usize,
    skin: &Result<Skin, String>,
    buffers: &Buffers,
) -> Result<Influences, String> {
    let skin = skin.as_ref().map_err(Clone::clone)?;
    let mut sets = Vec::new();
    for set in 0..MOST_SETS {
        let attributes = [Semantic::Joints(set), Semantic::Weights(set)].map(|semantic| primitive.get(&semantic));
        match attributes {
            [Some(joints), Some(weights)] => {
                let (joints, weights) = (buffers.joints(&joints, vertices)?, buffers.weights(&weights, vertices)?);
                sets.push(InfluenceSet { joints, weights });
            }
            [None, None] => break,
            _ => return Err(format!("set {set} has joints or weights alone")),
        }
    }
    if sets.is_empty() {
        return Err("it has no joints and weights".into());
    }
    Influences::new(&sets, vertices, skin.joints.len())
}

fn targets(primitive: &gltf::Primitive, vertices: usize, buffers: &Buffers) -> Result<Vec<MorphTarget>, String> {
    // Rebuilt normals follow the positions.
    let [has_normals, has_tangents] =
        [Semantic::Normals, Semantic::Tangents].map(|semantic| primitive.get(&semantic).is_some());
    let read = |accessor: Option<gltf::Accessor>, is_read: bool| match accessor.filter(|_| is_read) {
        Some(accessor) => buffers.differences(&accessor, vertices),
        None => Ok(Vec::new()),
    };
    let target = |target: gltf::mesh::MorphTarget| {
        Ok(MorphTarget {
            positions: read(target.positions(), true)?,
            normals: read(target.normals(), has_normals)?,
            tangents: read(target.tangents(), has_tangents)?,
        })
    };
    primitive.morph_targets().map(target).collect()
}

impl Buffers {
    /// The first `count` matrices of an accessor.
    fn matrices(&self, accessor: &gltf::Accessor, count: usize) -> Result<Vec<Mat4>, String> {
        self.check(accessor, &[DataType::F32], Dimensions::Mat4)?;
        let stored = Iter::<[[f32; 4]; 4]>::new(accessor.clone(), |buffer| self.slice(&buffer));
        let stored = stored.ok_or("its inverse bind matrices have no data")?;
        Ok(stored.take(count).map(|columns| Mat4::from_cols_array_2d(&columns)).collect())
    }

    fn differences(&self, accessor: &gltf::Accessor, vertices: usize) -> Result<Vec<Vec3>, String> {
        super::buffers::one_per_vertex(accessor, "morph targets", vertices)?;
        let values =
            self.numbers(accessor, Dimensions::Vec3).or_else(|_| self.attribute(accessor, Dimensions::Vec3))?;
        let differences: Vec<Vec3> = values.chunks_exact(3).map(Vec3::from_slice).collect();
        match differences.iter().position(|difference| !difference.is_finite()) {
            Some(vertex) => Err(format!("vertex {vertex} of a target is not a finite number")),
            None => Ok(differences),
        }
    }

    fn joints(&self, accessor: &gltf::Accessor, vertices: usize) -> Result<Vec<[u16; 4]>, String> {
        super::buffers::one_per_vertex(accessor, "joints", vertices)?;
        self.check(accessor, &[DataType::U8, DataType::U16], Dimensions::Vec4)?;
        let slice = |buffer: gltf::Buffer| self.slice(&buffer);
        let missing = || "its joints are missing".to_owned();
        Ok(match accessor.data_type() {
            DataType::U8 => {
                let joints = Iter::<[u8; 4]>::new(accessor.clone(), slice).ok_or_else(missing)?;
                joints.map(|joints| joints.map(u16::from)).collect()
            }
            _ => Iter::<[u16; 4]>::new(accessor.clone(), slice).ok_or_else(missing)?.collect(),
        })
    }

    fn weights(&self, accessor: &gltf::Accessor, vertices: usize) -> Result<Vec<[f32; 4]>, String> {
        super::buffers::one_per_vertex(accessor, "weights", vertices)?;
        let values = self.numbers(accessor, Dimensions::Vec4)?;
        Ok(values.chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]).collect())
    }
}
