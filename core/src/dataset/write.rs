//! Writing a dataset, atomically.

use super::{
    BakeReport, BakeSettings, Dataset, DatasetError, FORMAT_VERSION, brdfs,
    header::Header,
    stored::all_stored,
    tensors::{HIDDEN_POSITIONS, Tensor, arranged, checksum, cut_tensors, owned, tensor},
};
use crate::{material::Material, output::write_parts_atomically};
use glam::Vec3;
use safetensors::Dtype;
use std::{borrow::Cow, collections::BTreeMap, io, path::Path};

impl Dataset {
    /// Writes the dataset to a temporary name beside `path` and renames it when complete, so a failure leaves the old
    /// file. The contents are checked before the first byte is written: every written file is readable.
    ///
    /// # Errors
    /// Invalid contents, or a file that cannot be written, such as on a full disk.
    pub fn write(&self, path: &Path) -> Result<(), DatasetError> {
        self.write_as(path, &self.settings)
    }

    /// Writes the dataset with other settings of the same contents.
    ///
    /// # Errors
    /// See [`Self::write`].
    pub fn write_as(&self, path: &Path, settings: &BakeSettings) -> Result<(), DatasetError> {
        self.validate().map_err(|reason| DatasetError::Unwritable { path: path.into(), reason })?;
        let tensors = self.tensors();
        let header = self.header(settings, tensors.iter().map(|t| (t.name.clone(), checksum(&t.bytes))).collect());
        self.write_tensors(path, &tensors, &header).map_err(|source| DatasetError::Io {
            action: "write",
            path: path.into(),
            source,
        })
    }

    /// Bytes of all tensors.
    pub fn tensor_bytes(&self) -> u64 {
        self.tensors().iter().map(|t| t.bytes.len() as u64).sum()
    }

    fn write_tensors(&self, path: &Path, tensors: &[Tensor], header: &Header) -> io::Result<()> {
        let (metadata, ordered) = arranged(tensors, serde_json::to_string(header)?).map_err(io::Error::other)?;
        let mut head = serde_json::to_vec(&metadata)?;
        head.resize(head.len().next_multiple_of(8), b' ');
        let length = (head.len() as u64).to_le_bytes();
        let parts = [&length[..], &head].into_iter().chain(ordered.into_iter().map(|t| &*t.bytes));
        write_parts_atomically(path, parts)
    }

    /// The JSON metadata with these checksums of the tensors.
    pub(super) fn header(&self, settings: &BakeSettings, checksums: BTreeMap<String, String>) -> Header {
        let (brdfs, material_brdfs) = brdfs::kinds(&self.scene.materials);
        Header {
            format_version: FORMAT_VERSION,
            settings: settings.clone(),
            scene_hash: self.scene_hash.clone(),
            report: BakeReport { run: None, ..self.report.clone() },
            materials: self.scene.materials.iter().map(Material::without_content).collect(),
            objects: self.scene.objects.iter().map(|o| o.name.clone()).collect(),
            cameras: self.scene.cameras.clone(),
            lights: self.scene.lights.clone(),
            variants: self.scene.variants.clone(),
            part_opacities: self.scene.part_opacities.clone(),
            placed: self.scene.placed.clone(),
            clip_time: self.scene.clip_time.clone(),
            origin: self.scene.origin,
            ground: self.scene.mesh.ground,
            textures: self.scene.textures.iter().map(|t| t.name.clone()).collect(),
            brdfs,
            material_brdfs,
            checksums,
        }
    }

    fn tensors(&self) -> Vec<Tensor<'_>> {
        let mesh = &self.scene.mesh;
        let (v, t) = (mesh.positions.len(), mesh.triangles.len());
        let flags = |flags: &[bool]| Cow::Owned(flags.iter().map(|&f| u8::from(f)).collect::<Vec<u8>>());
        let mut tensors = vec![
            tensor("positions", Dtype::F32, [v, 3], &mesh.positions),
            tensor("normals", Dtype::F32, [v, 3], &mesh.normals),
            tensor("tangents", Dtype::F32, [v, 4], &mesh.tangents),
            tensor("uvs", Dtype::F32, [v, 2], &mesh.uvs),
            tensor("triangles", Dtype::U32, [t, 3], &mesh.triangles),
            tensor("triangle_material", Dtype::U32, [t], &mesh.triangle_material),
            tensor("triangle_object", Dtype::U32, [t], &mesh.triangle_object),
            tensor("tree_order", Dtype::U32, [self.tree.len()], self.tree.order()),
        ];
        if !mesh.second_uvs.is_empty() {
            tensors.push(tensor("second_uvs", Dtype::F32, [v, 2], &mesh.second_uvs));
        }
        if !mesh.colors.is_empty() {
            tensors.push(tensor("colors", Dtype::F32, [v, 3], &mesh.colors));
        }
        if !self.scene.hidden.is_empty() {
            let places: Vec<Vec3> = self.scene.hidden.values().flat_map(|of| of.vertices().positions.clone()).collect();
            tensors.push(owned(tensor(HIDDEN_POSITIONS, Dtype::F32, [places.len(), 3], &places)));
        }
        tensors.extend(cut_tensors(["cuts", "cut_offsets"], &self.cuts));
        tensors.extend(all_stored().flat_map(|part| part.tensors(self)));
        for (name, values) in [("triangle_two_sided", &self.two_sided), ("vertex_valid", &self.vertex_valid)] {
            tensors.push(Tensor {
                name: name.into(),
                dtype: Dtype::U8,
                shape: vec![values.len()],
                bytes: flags(values),
            });
        }
        for (i, texture) in self.scene.textures.iter().enumerate() {
            let bytes: &[u8] = &texture.encoded;
            tensors.push(tensor(&format!("texture.{i}"), Dtype::U8, [bytes.len()], bytes));
        }
        tensors.extend(brdfs::tensors(&self.scene.materials));
        tensors
    }
}
