//! What of a scene may change without a bake: its materials and their textures.

use lapidary_core::{material::Material, scene::Scene, texture::Texture};
use std::sync::Arc;

/// Materials and the textures that they refer to by index.
#[derive(Clone, Debug, Default)]
pub struct Appearance {
    /// One for each material index of the mesh.
    pub materials: Vec<Material>,
    /// Shared: copying an appearance copies no texels.
    pub textures: Vec<Arc<Texture>>,
}

impl Appearance {
    /// As the scene has them.
    pub fn of(scene: &Scene) -> Self {
        Self { materials: scene.materials.clone(), textures: scene.textures.clone() }
    }
}
