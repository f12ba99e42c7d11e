//! BRDF files of materials in a dataset, each stored once.

use super::{
    Damage,
    header::Header,
    reader::Reader,
    tensors::{Tensor, tensor},
};
use crate::{
    brdf::{Content, ContentKind},
    material::Material,
};
use safetensors::Dtype;
use std::borrow::Cow;

/// Distinct contents, and each material's index among them.
struct Shared<'a> {
    contents: Vec<&'a Content>,
    of_materials: Vec<Option<u32>>,
}

impl<'a> Shared<'a> {
    fn of(materials: &'a [Material]) -> Self {
        let mut contents: Vec<&Content> = Vec::new();
        let mut place = |material: &'a Material| {
            let content = material.file.as_ref()?.content.as_ref()?;
            let known = contents.iter().position(|known| known.hash() == content.hash());
            Some(known.unwrap_or_else(|| {
                contents.push(content);
                contents.len() - 1
            }) as u32)
        };
        let of_materials = materials.iter().map(&mut place).collect();
        Self { contents, of_materials }
    }
}

/// Kinds of the contents, and each material's index among them.
pub(super) fn kinds(materials: &[Material]) -> (Vec<ContentKind>, Vec<Option<u32>>) {
    let Shared { contents, of_materials } = Shared::of(materials);
    (contents.into_iter().map(Content::kind).collect(), of_materials)
}

/// Tensors of the contents.
pub(super) fn tensors(materials: &[Material]) -> Vec<Tensor<'_>> {
    let contents = Shared::of(materials).contents;
    let of = |(i, content): (usize, &Content)| {
        let bytes = content.packed();
        let empty: &[u8] = &[];
        let shape = [bytes.len()];
        Tensor { bytes: Cow::Owned(bytes), ..tensor(&format!("brdf.{i}"), Dtype::U8, shape, empty) }
    };
    contents.into_iter().enumerate().map(of).collect()
}

impl Reader<'_> {
    /// The materials of a header, with their BRDF contents.
    pub(super) fn materials(&self, header: &Header) -> Result<Vec<Material>, Damage> {
        let content = |(index, &kind): (usize, &ContentKind)| {
            let bytes: Vec<u8> = self.array(&format!("brdf.{index}"), Dtype::U8, &[], None)?;
            let name = format!("brdf.{index}");
            Content::from_packed(kind, &bytes, name.as_ref()).map_err(|source| Damage::Brdf { index, source })
        };
        let contents = header.brdfs.iter().enumerate().map(content).collect::<Result<Vec<_>, _>>()?;
        let mut materials = header.materials.clone();
        for (material, place) in materials.iter_mut().zip(&header.material_brdfs) {
            let (Some(file), Some(index)) = (&mut material.file, *place) else { continue };
            let content = contents.get(index as usize);
            let count = contents.len();
            file.content =
                Some(content.ok_or(Damage::NoBrdf { material: material.name.clone(), index, count })?.clone());
        }
        Ok(materials)
    }
}
