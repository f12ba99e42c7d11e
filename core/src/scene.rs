//! A scene: its mesh, materials, textures, cameras and lights.

mod opacities;
pub mod placed;
mod placing;
pub mod pose;

pub use crate::mesh::{Mesh, MeshError};

use crate::{
    camera::Camera, lights::Light, material::Material, opacity::PartOpacity, parts::Variants, texture::Texture,
};
use glam::DVec3;
use placed::Placed;
use pose::{ClipTime, DeformedObject};
use std::{collections::BTreeMap, sync::Arc};
use thiserror::Error;

/// A named part of the scene that can be selected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// Name from the source file, or one derived from its position there.
    pub name: String,
}

/// The result of an import.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// All triangles of all objects, in world space.
    pub mesh: Mesh,
    /// Materials; at least one if there are triangles.
    pub materials: Vec<Material>,
    /// Textures that the materials refer to by index; shared, because they are large and immutable.
    pub textures: Vec<Arc<Texture>>,
    /// Objects that the triangles refer to by index.
    pub objects: Vec<Object>,
    /// Cameras of the source file; may be empty.
    pub cameras: Vec<Camera>,
    /// Local lights of the source file; may be empty.
    pub lights: Vec<Light>,
    /// Variants of the materials.
    pub variants: Variants,
    /// Parts whose opacity a bake takes from another material; a file has none.
    pub part_opacities: Vec<PartOpacity>,
    /// Objects that a bake moved or deformed; a file has none.
    pub placed: Vec<Placed>,
    /// Objects that a bake hid, with their vertices where they would be; in the mesh they are points. A file has none.
    pub hidden: BTreeMap<u32, DeformedObject>,
    /// The animation time of a bake; `None` at rest, as in a file.
    pub clip_time: Option<ClipTime>,
    /// Where its origin is in the source file, in meters: a scene far from the origin there is moved, for precision.
    pub origin: DVec3,
}

impl Scene {
    /// The same scene with another mesh of the same objects and materials.
    #[must_use]
    pub fn with_mesh(&self, mesh: Mesh) -> Self {
        Self {
            mesh,
            materials: self.materials.clone(),
            textures: self.textures.clone(),
            objects: self.objects.clone(),
            cameras: self.cameras.clone(),
            lights: self.lights.clone(),
            variants: self.variants.clone(),
            part_opacities: self.part_opacities.clone(),
            placed: self.placed.clone(),
            hidden: self.hidden.clone(),
            clip_time: self.clip_time.clone(),
            origin: self.origin,
        }
    }

    /// The camera called `name`.
    ///
    /// # Errors
    /// [`NoSuchCamera`], which lists the scene's cameras.
    pub fn camera(&self, name: &str) -> Result<&Camera, NoSuchCamera> {
        camera_named(self.cameras.iter(), name)
    }

    /// The first camera, or a view of the whole scene if there is none.
    pub fn first_view(&self) -> Camera {
        let bounds = self.mesh.bounds();
        let whole = || Camera::framing(bounds.center(), 0.5 * bounds.diagonal());
        self.cameras.first().cloned().unwrap_or_else(whole)
    }
}

/// The first camera called `name`.
///
/// # Errors
/// [`NoSuchCamera`], which lists the available cameras.
pub fn camera_named<'a>(
    mut cameras: impl Iterator<Item = &'a Camera> + Clone,
    name: &str,
) -> Result<&'a Camera, NoSuchCamera> {
    let all = cameras.clone();
    cameras
        .find(|camera| camera.name == name)
        .ok_or_else(|| NoSuchCamera { name: name.to_owned(), known: all.map(|camera| camera.name.clone()).collect() })
}

/// A name that no camera of a scene has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("the scene has no camera \"{name}\"; it has {}", if known.is_empty() { "none".into() } else { known.join(", ") })]
pub struct NoSuchCamera {
    /// The requested name.
    pub name: String,
    /// Names of the scene's cameras.
    pub known: Vec<String>,
}
