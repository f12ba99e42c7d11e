//! Reading a dataset: everything is checked before anything is used.

use super::{
    Dataset, DatasetError, FORMAT_VERSION,
    error::Damage,
    header::{Header, METADATA_KEY},
    tensors::Reader,
};
use crate::{
    camera::Camera,
    image::decode,
    input,
    light_tree::LightTree,
    lights::Light,
    scene::{Mesh, Object, Scene},
    texture::Texture,
};
use safetensors::{Dtype, SafeTensors};
use std::path::Path;

impl Dataset {
    /// Reads and checks a dataset.
    ///
    /// # Errors
    /// A file that cannot be read, is no dataset, is of a newer format, or contradicts itself.
    pub fn read(path: &Path) -> Result<Self, DatasetError> {
        let bytes =
            input::read(path).map_err(|source| DatasetError::Io { action: "read", path: path.into(), source })?;
        let foreign = |reason: String| DatasetError::Foreign { path: path.into(), reason };
        let (_, metadata) = SafeTensors::read_metadata(&bytes).map_err(|e| foreign(e.to_string()))?;
        let json = metadata.metadata().as_ref().and_then(|m| m.get(METADATA_KEY));
        let json = json.ok_or_else(|| foreign("it lacks Lapidary's metadata".into()))?;
        check_version(json, path)?;
        let tensors = SafeTensors::deserialize(&bytes).map_err(|e| foreign(e.to_string()))?;
        Reader { tensors, path }.dataset(json).map_err(|reason| DatasetError::Damaged { path: path.into(), reason })
    }
}

/// The version stands before all else: a newer header may not parse.
fn check_version(json: &str, path: &Path) -> Result<(), DatasetError> {
    let value: serde_json::Value = serde_json::from_str(json)
        .map_err(|e| DatasetError::Foreign { path: path.into(), reason: format!("its metadata is no JSON: {e}") })?;
    let found = value["format_version"].as_u64().unwrap_or(0) as u32;
    if found > FORMAT_VERSION {
        return Err(DatasetError::Newer { path: path.into(), found, supported: FORMAT_VERSION });
    }
    Ok(())
}

impl Reader<'_> {
    fn dataset(&self, json: &str) -> Result<Dataset, Damage> {
        let header: Header = serde_json::from_str(json).map_err(|e| Damage::Metadata(e.to_string()))?;
        self.check_sums(&header)?;
        let tree = LightTree::from_order(self.permutation()?).map_err(|_| Damage::Tree)?;
        let scene = self.scene(&header)?;
        let (vertices, triangles) = (scene.mesh.positions.len(), scene.mesh.triangles.len());
        let cuts = self.cuts(["cuts", "cut_offsets"], tree.height(), vertices)?;
        let reported = header.report.indirect.as_ref().map_or(0.0, |report| report.radius);
        let indirect = self.indirect(tree.height(), vertices, triangles, reported)?;
        let meshless = self.meshless(triangles)?;
        Ok(Dataset {
            two_sided: self.flags("triangle_two_sided", triangles)?,
            vertex_valid: self.flags("vertex_valid", vertices)?,
            scene,
            tree,
            cuts,
            indirect,
            meshless,
            settings: header.settings,
            scene_hash: header.scene_hash,
            report: header.report,
        })
    }

    fn check_sums(&self, header: &Header) -> Result<(), Damage> {
        for (name, expected) in &header.checksums {
            let tensor = self.tensors.tensor(name).map_err(|_| Damage::Missing(name.clone()))?;
            if blake3::hash(tensor.data()).to_hex().as_str() != expected {
                return Err(Damage::Checksum(name.clone()));
            }
        }
        Ok(())
    }

    fn scene(&self, header: &Header) -> Result<Scene, Damage> {
        let positions = self.array("positions", Dtype::F32, &[3], None)?;
        let v = Some(positions.len());
        let triangles = self.array("triangles", Dtype::U32, &[3], None)?;
        let t = Some(triangles.len());
        let mesh = Mesh {
            positions,
            normals: self.array("normals", Dtype::F32, &[3], v)?,
            tangents: self.array("tangents", Dtype::F32, &[4], v)?,
            uvs: self.array("uvs", Dtype::F32, &[2], v)?,
            triangles,
            triangle_material: self.array("triangle_material", Dtype::U32, &[], t)?,
            triangle_object: self.array("triangle_object", Dtype::U32, &[], t)?,
        };
        mesh.validate(header.materials.len(), header.objects.len())?;
        let textures = header.textures.iter().enumerate().map(|(i, name)| self.texture(i, name).map(Into::into));
        let scene = Scene {
            mesh,
            materials: header.materials.clone(),
            textures: textures.collect::<Result<_, _>>()?,
            objects: header.objects.iter().map(|name| Object { name: name.clone() }).collect(),
            cameras: header.cameras.clone(),
            lights: header.lights.clone(),
        };
        check_texture_indices(&scene)?;
        check_cameras(&scene)?;
        check_lights(&scene)?;
        Ok(scene)
    }

    fn texture(&self, index: usize, name: &str) -> Result<Texture, Damage> {
        let bytes: Vec<u8> = self.array(&format!("texture.{index}"), Dtype::U8, &[], None)?;
        if bytes.is_empty() {
            return Ok(Texture::missing(name));
        }
        // The name tells the decoder the format, where the contents alone do not.
        let mut decoded = decode(&bytes, Path::new(name)).map_err(|e| Damage::Metadata(e.to_string()))?;
        decoded.texels.sanitize();
        Ok(Texture { name: name.to_owned(), encoded: bytes.into(), ..decoded })
    }

    fn permutation(&self) -> Result<Vec<u32>, Damage> {
        let order: Vec<u32> = self.array("tree_order", Dtype::U32, &[], None)?;
        let mut seen = vec![false; order.len()];
        let fresh = order.iter().all(|&s| seen.get_mut(s as usize).is_some_and(|x| !std::mem::replace(x, true)));
        if fresh { Ok(order) } else { Err(Damage::Tree) }
    }
}

/// Numbers above those of an f32 are read as infinite.
fn check_cameras(scene: &Scene) -> Result<(), Damage> {
    let finite = |c: &Camera| (c.eye.is_finite() && c.target.is_finite() && c.up.is_finite()) && c.fov_y.is_finite();
    match scene.cameras.iter().position(|c| !finite(c)) {
        Some(index) => Err(Damage::Camera { index, name: scene.cameras[index].name.clone() }),
        None => Ok(()),
    }
}

fn check_lights(scene: &Scene) -> Result<(), Damage> {
    let check = |(index, light): (usize, &Light)| {
        light.validate().map_err(|source| Damage::Light { index, name: light.name.clone(), source })
    };
    scene.lights.iter().enumerate().try_for_each(check)
}

fn check_texture_indices(scene: &Scene) -> Result<(), Damage> {
    for material in &scene.materials {
        for slot in material.maps.slots() {
            if slot.texture as usize >= scene.textures.len() {
                let count = scene.textures.len();
                return Err(Damage::Texture { material: material.name.clone(), texture: slot.texture, count });
            }
        }
    }
    Ok(())
}
