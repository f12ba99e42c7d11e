//! Check of a dataset's contents, after reading and before writing: indices and counts fit, numbers are finite and in
//! range. A valid dataset can be verified and rendered, and gives finite pictures.

use super::{
    Dataset,
    error::{Damage, SurfelDamage},
    header::Header,
    stored::all_stored,
};
use crate::{
    bounds::is_within_reach, cut::packed::PackedCuts, light_tree::is_permutation, lights::MAX_LIGHTS, mesh::is_unit,
    scene::Scene, surfel::Surfel,
};
use glam::Vec2;
use std::collections::BTreeMap;

/// How far rounding may move barycentric weights outside 0 to 1.
const BARYCENTRIC_SLACK: f32 = 0.01;

impl Dataset {
    /// Checks all contents.
    ///
    /// # Errors
    /// The first [`Damage`] found.
    pub fn validate(&self) -> Result<(), Damage> {
        let Scene { mesh, materials, objects, variants, part_opacities, .. } = &self.scene;
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        mesh.validate(materials.len(), objects.len())?;
        check_count("flags of sides", self.two_sided.len(), triangles)?;
        check_count("flags of vertices", self.vertex_valid.len(), vertices)?;
        check_scene(&self.scene)?;
        if !variants.fit(objects.len(), materials.len()) {
            return Err(Damage::Variants);
        }
        if !part_opacities.iter().all(|other| other.fits(objects.len(), materials.len())) {
            return Err(Damage::PartOpacities);
        }
        if !self.scene.placed_fits() {
            return Err(Damage::Placed);
        }
        self.check_settings()?;
        if !is_permutation(self.tree.order()) {
            return Err(Damage::Tree);
        }
        check_cuts("cuts", &self.cuts, self.tree.height(), vertices)?;
        all_stored().try_for_each(|part| part.check(self))?;
        self.check_header()
    }

    fn check_settings(&self) -> Result<(), Damage> {
        let mut checks = all_stored().flat_map(|part| part.settings(self));
        match checks.find(|(_, is_good)| !is_good) {
            Some((name, _)) => Err(Damage::Setting(name)),
            None => Ok(()),
        }
    }

    /// Checks that the JSON metadata reads back unchanged. Numbers that are not finite become `null` in JSON and fail.
    fn check_header(&self) -> Result<(), Damage> {
        let header = self.header(&self.settings, BTreeMap::new());
        let unreadable = |e: serde_json::Error| Damage::Metadata(e.to_string());
        let json = serde_json::to_string(&header).map_err(unreadable)?;
        let again: Header = serde_json::from_str(&json).map_err(unreadable)?;
        if again == header { Ok(()) } else { Err(Damage::Metadata("it does not survive being written".into())) }
    }
}

fn check_count(what: &'static str, found: usize, expected: usize) -> Result<(), Damage> {
    if found == expected { Ok(()) } else { Err(Damage::Count { what, found, expected }) }
}

/// Checks `count` cuts over a tree of `height`.
pub(super) fn check_cuts(cuts: &'static str, packed: &PackedCuts, height: u32, count: usize) -> Result<(), Damage> {
    check_count("cuts", packed.len(), count)?;
    packed.validate(height).map_err(|(index, source)| Damage::Cut { cuts, index, source })
}

fn check_scene(scene: &Scene) -> Result<(), Damage> {
    let of_parts = scene.part_opacities.iter().map(|other| &other.material);
    for (index, material) in scene.materials.iter().chain(of_parts).enumerate() {
        let name = || material.name.clone();
        material.validate().map_err(|source| Damage::Material { index, name: name(), source })?;
        let count = scene.textures.len();
        if let Some(slot) = material.maps.slots().find(|slot| slot.image().is_some_and(|image| image >= count)) {
            return Err(Damage::Texture { material: name(), texture: slot.texture, count });
        }
    }
    if let Some(index) = scene.cameras.iter().position(|camera| !camera.is_valid()) {
        return Err(Damage::Camera { index, name: scene.cameras[index].name.clone() });
    }
    if scene.lights.len() > MAX_LIGHTS {
        return Err(Damage::Lights(scene.lights.len()));
    }
    for (index, light) in scene.lights.iter().enumerate() {
        light.validate().map_err(|source| Damage::Light { index, name: light.name.clone(), source })?;
    }
    Ok(())
}

/// Checks a point on one of `count` triangles.
pub(super) fn check_surfel(surfel: &Surfel, count: usize) -> Result<(), SurfelDamage> {
    let triangle = surfel.place.triangle;
    if !is_within_reach(surfel.position) {
        Err(SurfelDamage::Position)
    } else if !is_unit(surfel.normal) {
        Err(SurfelDamage::Normal)
    } else if triangle as usize >= count {
        Err(SurfelDamage::Triangle { triangle, count })
    } else if !is_barycentric(surfel.place.barycentric) {
        Err(SurfelDamage::Place)
    } else {
        Ok(())
    }
}

fn is_barycentric(weights: Vec2) -> bool {
    let Vec2 { x, y } = weights;
    x >= -BARYCENTRIC_SLACK && y >= -BARYCENTRIC_SLACK && x + y <= 1.0 + BARYCENTRIC_SLACK
}
