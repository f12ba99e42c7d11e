//! The JSON metadata of a dataset file.

use super::{BakeReport, BakeSettings};
use crate::{
    brdf::ContentKind,
    camera::Camera,
    lights::Light,
    material::Material,
    mesh::GroundStart,
    opacity::PartOpacity,
    parts::Variants,
    scene::{placed::Placed, pose::ClipTime},
    texture::is_default,
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The JSON part of a dataset.
#[derive(PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    pub format_version: u32,
    pub settings: BakeSettings,
    pub scene_hash: String,
    pub report: BakeReport,
    pub materials: Vec<Material>,
    pub objects: Vec<String>,
    pub cameras: Vec<Camera>,
    #[serde(default)]
    pub lights: Vec<Light>,
    #[serde(default, skip_serializing_if = "Variants::is_empty")]
    pub variants: Variants,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub part_opacities: Vec<PartOpacity>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub placed: Vec<Placed>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_time: Option<ClipTime>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub origin: DVec3,
    /// First vertex and triangle of the ground in the mesh.
    #[serde(default)]
    pub ground: Option<GroundStart>,
    pub textures: Vec<String>,
    /// Kinds of the BRDF files.
    #[serde(default)]
    pub brdfs: Vec<ContentKind>,
    /// Each material's index among the BRDF files.
    #[serde(default)]
    pub material_brdfs: Vec<Option<u32>>,
    /// BLAKE3 of each tensor's bytes, hexadecimal.
    pub checksums: BTreeMap<String, String>,
}
