//! Inputs of a surface that depend on each other.

use super::{
    super::{
        graph::Unread,
        stretch,
        surface::{OPACITY_CUTOFF, Surface},
    },
    MaterialXError, Reader,
};
use crate::{
    fresnel::{set_specular_color, weigh_dielectric},
    material_file::MaterialFile,
};
use roxmltree::Node;

impl<'a> Reader<'_, 'a> {
    pub(super) fn finish(
        &mut self,
        material: &mut MaterialFile,
        shader: Node<'a, 'a>,
        surface: Surface,
    ) -> Result<(), MaterialXError> {
        match surface {
            Surface::OpenPbr => {}
            Surface::StandardSurface => {
                self.weigh_dielectric(material);
                stretched(material, stretch::of_burley);
                stretched_coat(material);
            }
            Surface::GltfPbr => {
                let has_sheen = material.parameters.color("fuzz_color").max_element() > 0.0
                    || material.maps.get("fuzz_color").is_some();
                material.parameters.set("fuzz_weight", if has_sheen { 1.0 } else { 0.0 });
                material.parameters.set("coat_ior", 1.5);
                material.parameters.set("coat_darkening", 0.0);
                let lost = set_specular_color(material, material.parameters.color("specular_color"));
                self.remarks.extend(lost.map(|lost| format!("it has a {lost}")));
                self.weigh_dielectric(material);
                stretched(material, stretch::of_gltf);
                self.alpha(material, shader)?;
            }
        }
        if let Some(name) = surface.thin_walled() {
            let thin = self.graph.constant(shader, name, &[0.0]).map(|numbers| numbers[0] != 0.0);
            material.double_sided = match thin {
                Ok(is_thin) => is_thin,
                Err(unread) => self.tell(name, unread).map(|()| false)?,
            };
        }
        Ok(())
    }

    /// `specular` is the weight of the dielectric's highlight alone.
    fn weigh_dielectric(&mut self, material: &mut MaterialFile) {
        if !weigh_dielectric(material) {
            self.remarks.push("\"specular\" also scales the reflection of its metal".into());
        }
    }

    /// Cutout as in glTF.
    fn alpha(&mut self, material: &mut MaterialFile, shader: Node<'a, 'a>) -> Result<(), MaterialXError> {
        const OPACITY: &str = "geometry_opacity";
        let [mode, cutoff] = [("alpha_mode", 0.0), ("alpha_cutoff", 0.5)]
            .map(|(name, default)| self.graph.constant(shader, name, &[default]).map(|numbers| numbers[0]));
        let unread = |unread| match unread {
            Unread::Wrong(text) | Unread::Beyond(text) => MaterialXError::Value(text),
        };
        let (mode, cutoff) = (mode.map_err(unread)?, cutoff.map_err(unread)?);
        if mode == 0.0 {
            material.parameters.set(OPACITY, 1.0);
            material.maps.set(OPACITY, None);
        }
        if mode == 1.0 {
            material.parameters.set(OPACITY_CUTOFF, cutoff);
        }
        Ok(())
    }
}

/// Sets OpenPBR's roughness and anisotropy for the lobe whose widths `widths` computes from the input.
fn stretched(material: &mut MaterialFile, widths: impl Fn(f32, f32) -> stretch::Widths) {
    change_stretch(material, ["specular_roughness", "specular_roughness_anisotropy"], widths);
}

fn stretched_coat(material: &mut MaterialFile) {
    change_stretch(material, ["coat_roughness", "coat_roughness_anisotropy"], stretch::of_burley);
}

fn change_stretch(material: &mut MaterialFile, names: [&'static str; 2], widths: impl Fn(f32, f32) -> stretch::Widths) {
    let [roughness, anisotropy] = names.map(|name| material.parameters.number(name));
    let is_mapped = names.iter().any(|name| material.maps.get(name).is_some());
    if anisotropy > 0.0 && !is_mapped {
        let lobe = stretch::to_openpbr(widths(roughness, anisotropy));
        names.into_iter().zip(lobe).for_each(|(name, number)| material.parameters.set(name, number));
    }
}
