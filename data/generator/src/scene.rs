//! A scene of the generator: pieces, materials and cameras, before it becomes a file.

use glam::{Affine3A, Vec3};

use crate::mesh::Mesh;
use crate::motion::Motion;

/// A texture file beside the scene, `None` for none.
pub type Texture = Option<&'static str>;

/// A glTF metallic-roughness material; factors multiply their textures.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name shown to the artist.
    pub name: &'static str,
    /// Linear Rec. 709 base color.
    pub base_color: [f32; 3],
    /// 0 for dielectrics, 1 for metals.
    pub metallic: f32,
    /// Perceptual roughness: its square is the GGX alpha.
    pub roughness: f32,
    /// Seen and lit from both sides: open sheets only.
    pub double_sided: bool,
    /// sRGB image that multiplies the base color.
    pub base_color_texture: Texture,
    /// Image whose green channel multiplies roughness and whose blue channel multiplies metallic.
    pub roughness_texture: Texture,
    /// Tangent-space normal map, +Y up.
    pub normal_texture: Texture,
    /// Strength of the normal map.
    pub normal_scale: f32,
}

impl Material {
    /// A dielectric without textures.
    pub fn dielectric(name: &'static str, base_color: [f32; 3], roughness: f32) -> Material {
        Material {
            name,
            base_color,
            metallic: 0.0,
            roughness,
            double_sided: false,
            base_color_texture: None,
            roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
        }
    }

    /// A metal without textures; `base_color` is its reflectance at normal incidence.
    pub fn metal(name: &'static str, base_color: [f32; 3], roughness: f32) -> Material {
        Material { metallic: 1.0, ..Material::dielectric(name, base_color, roughness) }
    }
}

/// A mesh with the name of its material.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Name of the mesh.
    pub name: String,
    /// Geometry in its own space.
    pub mesh: Mesh,
    /// Name of one of the scene's materials.
    pub material: &'static str,
}

/// A placed piece.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name shown to the artist.
    pub name: String,
    /// Index of the piece.
    pub piece: usize,
    /// Rigid placement.
    pub world_from_object: Affine3A,
}

/// A perspective camera.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Name shown to the artist.
    pub name: &'static str,
    /// Position in meters.
    pub eye: Vec3,
    /// Point in the middle of the picture.
    pub target: Vec3,
    /// Vertical field of view in degrees.
    pub vertical_fov: f32,
}

/// A local light (KHR_lights_punctual).
#[derive(Clone, Copy, Debug)]
pub struct PunctualLight {
    /// Name shown to the artist.
    pub name: &'static str,
    /// Position in meters.
    pub position: Vec3,
    /// Target of a spot light.
    pub target: Vec3,
    /// Radiant intensity per color channel in W/sr; the file format says candela, Lapidary takes it for W/sr.
    pub intensity: [f32; 3],
    /// Angles of a spot from its axis in degrees: start and end of its falloff. `None` for a point light.
    pub cone: Option<[f32; 2]>,
}

/// Everything that goes into one glTF file.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name of the scene.
    pub name: &'static str,
    /// Materials, in file order.
    pub materials: Vec<Material>,
    /// Meshes, in file order.
    pub pieces: Vec<Piece>,
    /// Placements of pieces.
    pub nodes: Vec<Node>,
    /// Cameras; the first is the initial view.
    pub cameras: Vec<Camera>,
    /// Local lights.
    pub lights: Vec<PunctualLight>,
    /// Motion.
    pub motion: Option<Motion>,
}

impl Scene {
    /// Adds a mesh without placing it and returns its index.
    pub fn piece(&mut self, name: &str, mesh: Mesh, material: &'static str) -> usize {
        self.pieces.push(Piece { name: name.to_owned(), mesh, material });
        self.pieces.len() - 1
    }

    /// Places a piece.
    pub fn place(&mut self, name: &str, piece: usize, world_from_object: Affine3A) {
        self.nodes.push(Node { name: name.to_owned(), piece, world_from_object });
    }

    /// Adds a mesh and places it once.
    pub fn add(&mut self, name: &str, mesh: Mesh, material: &'static str, world_from_object: Affine3A) {
        let piece = self.piece(name, mesh, material);
        self.place(name, piece, world_from_object);
    }

    /// Vertices over all placements.
    pub fn vertex_count(&self) -> usize {
        self.nodes.iter().map(|node| self.pieces[node.piece].mesh.positions.len()).sum()
    }

    /// Triangles over all placements.
    pub fn triangle_count(&self) -> usize {
        self.nodes.iter().map(|node| self.pieces[node.piece].mesh.triangle_count()).sum()
    }
}

/// A placement at `position`, turned counter-clockwise around Y by `degrees`.
pub fn at(position: Vec3, degrees: f32) -> Affine3A {
    let turn = glam::Quat::from_rotation_y(degrees.to_radians());
    Affine3A::from_rotation_translation(turn, position)
}
