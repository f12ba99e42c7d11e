//! Reading a dataset. This module assembles the parts as far as their sizes allow; `validate.rs` checks everything before use.

use super::{
    Dataset, DatasetError, DecodePicture, FORMAT_VERSION, WARD_OF_1992,
    error::Damage,
    header::Header,
    reader::{Reader, TensorFile},
    stored::all_stored,
    tensors::HIDDEN_POSITIONS,
};
use crate::{
    bounds::is_within_reach,
    light_tree::{LightTree, is_permutation},
    material::Material,
    mesh::Mesh,
    scene::{Object, Scene, pose::Objects},
    texture::Texture,
};
use glam::Vec3;
use safetensors::Dtype;
use std::{collections::BTreeMap, path::Path};

impl Dataset {
    /// Reads and checks a dataset. `decode` decodes its pictures.
    ///
    /// # Errors
    /// A file that is unreadable, not a dataset, of a newer format, or inconsistent.
    pub fn read(path: &Path, decode: DecodePicture) -> Result<Self, DatasetError> {
        let file = TensorFile::open(path)?;
        let foreign = |reason: &str| DatasetError::Foreign { path: path.into(), reason: reason.into() };
        let json = file.json().ok_or_else(|| foreign("it lacks Lapidary's metadata"))?;
        check_version(json, path)?;
        let damaged = |reason| DatasetError::of_contents(path, reason);
        let mut header: Header = serde_json::from_str(json).map_err(|e| damaged(Damage::Metadata(e.to_string())))?;
        if header.format_version < WARD_OF_1992 {
            header.materials.iter_mut().for_each(Material::with_ward_of_before);
        }
        let checksums = header.checksums.clone();
        let reader = Reader { file: &file, checksums: &checksums };
        let mut dataset = reader.dataset(header, decode).map_err(damaged)?;
        dataset.validate().map_err(damaged)?;
        reader.hidden(&mut dataset.scene).map_err(damaged)?;
        Ok(dataset)
    }
}

/// Checks the version first: a newer header may not parse.
fn check_version(json: &str, path: &Path) -> Result<(), DatasetError> {
    let value: serde_json::Value = serde_json::from_str(json)
        .map_err(|e| DatasetError::Foreign { path: path.into(), reason: format!("its metadata is not JSON: {e}") })?;
    let found = value["format_version"].as_u64().unwrap_or(0) as u32;
    if found > FORMAT_VERSION {
        return Err(DatasetError::Newer { path: path.into(), found, supported: FORMAT_VERSION });
    }
    Ok(())
}

impl Reader<'_> {
    fn dataset(&self, header: Header, decode: DecodePicture) -> Result<Dataset, Damage> {
        self.check_names()?;
        let tree = LightTree::from_order(self.permutation()?).map_err(|_| Damage::Tree)?;
        let scene = self.scene(&header, decode)?;
        let (vertices, triangles) = (scene.mesh.positions.len(), scene.mesh.triangles.len());
        let cuts = self.cuts(["cuts", "cut_offsets"], vertices)?;
        let mut dataset = Dataset {
            two_sided: self.flags("triangle_two_sided", triangles)?,
            vertex_valid: self.flags("vertex_valid", vertices)?,
            scene,
            tree,
            cuts,
            indirect: None,
            meshless: None,
            object_bases: None,
            wavelet: None,
            settings: header.settings,
            scene_hash: header.scene_hash,
            report: header.report,
        };
        all_stored().try_for_each(|part| part.read(self, &mut dataset))?;
        Ok(dataset)
    }

    fn scene(&self, header: &Header, decode: DecodePicture) -> Result<Scene, Damage> {
        let positions = self.array("positions", Dtype::F32, &[3], None)?;
        let v = Some(positions.len());
        let triangles = self.array("triangles", Dtype::U32, &[3], None)?;
        let t = Some(triangles.len());
        let mesh = Mesh {
            positions,
            normals: self.array("normals", Dtype::F32, &[3], v)?,
            tangents: self.array("tangents", Dtype::F32, &[4], v)?,
            uvs: self.array("uvs", Dtype::F32, &[2], v)?,
            second_uvs: self.optional_array("second_uvs", &[2], v)?,
            colors: self.optional_array("colors", &[3], v)?,
            triangles,
            triangle_material: self.array("triangle_material", Dtype::U32, &[], t)?,
            triangle_object: self.array("triangle_object", Dtype::U32, &[], t)?,
            ground: header.ground,
        };
        let textures =
            header.textures.iter().enumerate().map(|(i, name)| self.texture(i, name, decode).map(Into::into));
        Ok(Scene {
            mesh,
            materials: self.materials(header)?,
            textures: textures.collect::<Result<_, _>>()?,
            objects: header.objects.iter().map(|name| Object { name: name.clone() }).collect(),
            cameras: header.cameras.clone(),
            lights: header.lights.clone(),
            variants: header.variants.clone(),
            part_opacities: header.part_opacities.clone(),
            placed: header.placed.clone(),
            hidden: BTreeMap::new(),
            clip_time: header.clip_time.clone(),
            origin: header.origin,
        })
    }

    /// Gives a valid scene the vertices of its hidden objects.
    fn hidden(&self, scene: &mut Scene) -> Result<(), Damage> {
        let hidden: Vec<u32> = scene.placed.iter().filter(|of| of.pose.hidden).map(|of| of.object).collect();
        if hidden.is_empty() {
            return Ok(());
        }
        let objects = Objects::of(scene);
        let expected = hidden.iter().map(|&object| objects.vertices(object).len()).sum();
        let positions: Vec<Vec3> = self.array(HIDDEN_POSITIONS, Dtype::F32, &[3], Some(expected))?;
        if !positions.iter().all(|&place| is_within_reach(place)) {
            return Err(Damage::Placed);
        }
        scene.keep_hidden(&hidden, &positions);
        Ok(())
    }

    fn texture(&self, index: usize, name: &str, decode: DecodePicture) -> Result<Texture, Damage> {
        let bytes: Vec<u8> = self.array(&format!("texture.{index}"), Dtype::U8, &[], None)?;
        if bytes.is_empty() {
            return Ok(Texture::missing(name));
        }
        // The name gives the decoder the format, where the contents alone do not.
        let mut decoded = decode(&bytes, Path::new(name)).map_err(|source| Damage::Picture { index, source })?;
        decoded.texels.sanitize();
        Ok(Texture { name: name.to_owned(), encoded: bytes.into(), ..decoded })
    }

    fn permutation(&self) -> Result<Vec<u32>, Damage> {
        let order: Vec<u32> = self.array("tree_order", Dtype::U32, &[], None)?;
        if is_permutation(&order) { Ok(order) } else { Err(Damage::Tree) }
    }
}
