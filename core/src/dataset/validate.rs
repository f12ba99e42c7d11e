//! The check of a dataset's contents, for files that were read and for datasets about to be written: indices and counts fit,
//! numbers are finite and in their ranges. What it passes can be verified and rendered, and gives finite pictures.

use super::{
    Dataset,
    error::{Damage, MOST_LINK_SCALE, MeshlessDamage, SourceDamage, SurfelDamage},
    header::Header,
    indirect::{SOURCE_CUTS, SOURCE_ENVIRONMENT_CUTS},
};
use crate::{
    bounds::is_within_reach,
    cut::packed::PackedCuts,
    light_tree::{height_of, is_permutation},
    lights::MAX_LIGHTS,
    mesh::is_unit,
    meshless::{MeshlessBake, TransportError},
    ray::is_number_per_probe,
    scene::Scene,
    shot::Shot,
    sources::{IndirectBake, Source},
    surfel::Surfel,
};
use glam::Vec2;
use std::collections::BTreeMap;

/// Largest area of a source in squares of the scene's diagonal, and spacing in diagonals. A scene may be folded.
const MOST_SOURCE_SIZE: f32 = 64.0;
/// How far weights of a triangle's corners may be outside 0 to 1 by rounding.
const BARYCENTRIC_SLACK: f32 = 0.01;
/// Most rays of a gather.
const MOST_RAYS: usize = 65_536;

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
        self.indirect.iter().try_for_each(|bake| self.check_indirect(bake))?;
        self.meshless.iter().try_for_each(|bake| check_meshless(bake, triangles))?;
        self.check_header()
    }

    /// The settings that a verification uses, and what the bake made of them. The bake itself has narrower ranges.
    fn check_settings(&self) -> Result<(), Damage> {
        let settings = &self.settings;
        let (cuts, sources) = (&settings.criterion, &settings.indirect.criterion);
        let meshless = &settings.meshless;
        let is_size = |x: f32| x.is_finite() && x >= 0.0;
        let checks = [
            ("beta", settings.beta.is_finite()),
            ("sigma", is_size(cuts.sigma)),
            ("total error", cuts.total_error.is_none_or(is_size)),
            ("sigma of the sources", is_size(sources.sigma)),
            ("contrast of the sources", is_size(sources.contrast)),
            ("largest solid angle", is_size(sources.max_solid_angle)),
            ("viewpoint", settings.indirect.viewpoint.is_none_or(is_within_reach)),
            ("coarse radius", meshless.coarse_radius.is_none_or(is_size)),
            ("rays", (1..=MOST_RAYS).contains(&meshless.rays)),
            ("epsilon", is_size(meshless.epsilon)),
            ("shots", settings.shots.iter().all(Shot::is_valid)),
            ("lights per probe", is_number_per_probe(self.report.lights_per_probe())),
            (
                "sources per probe",
                self.report.indirect.as_ref().is_none_or(|r| is_number_per_probe(r.sources_per_probe())),
            ),
        ];
        match checks.into_iter().find(|(_, is_good)| !is_good) {
            Some((name, _)) => Err(Damage::Setting(name)),
            None => Ok(()),
        }
    }

    fn check_indirect(&self, bake: &IndirectBake) -> Result<(), Damage> {
        let mesh = &self.scene.mesh;
        let (count, diagonal) = (bake.sources.len(), mesh.bounds().diagonal());
        let height = height_of(count).map_err(|_| SourceDamage::Count(count))?;
        for (index, source) in bake.sources.iter().enumerate() {
            check_surfel(&source.surfel, mesh.triangles.len())
                .map_err(|source| SourceDamage::Place { index, source })?;
            let &Source { area, spacing, .. } = source;
            let fits = |size: f32, scene: f32| size >= 0.0 && size <= MOST_SOURCE_SIZE * scene;
            if !(fits(area, diagonal * diagonal) && fits(spacing, diagonal)) {
                return Err(SourceDamage::Size { index, area, spacing, diagonal }.into());
            }
        }
        check_cuts(SOURCE_CUTS[0], &bake.cuts, height, mesh.positions.len())?;
        check_cuts(SOURCE_ENVIRONMENT_CUTS[0], &bake.environment_cuts, self.tree.height(), count)
    }

    /// The JSON part reads back as what it was. Numbers that are not finite become `null` in JSON and do not.
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

fn check_cuts(cuts: &'static str, packed: &PackedCuts, height: u32, count: usize) -> Result<(), Damage> {
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

fn check_meshless(bake: &MeshlessBake, triangles: usize) -> Result<(), Damage> {
    let (basis, transport) = (&bake.basis, &bake.transport);
    for (function, point) in basis.points().iter().enumerate() {
        check_surfel(point, triangles).map_err(|source| MeshlessDamage::Function { function, source })?;
    }
    let [receivers, senders] = [basis.len(), basis.senders().len()];
    if [transport.receivers(), transport.senders()] != [receivers, senders] {
        return Err(MeshlessDamage::Transport(TransportError { receivers, senders }).into());
    }
    if (0.0..=MOST_LINK_SCALE).contains(&transport.scale()) {
        Ok(())
    } else {
        Err(MeshlessDamage::Scale(transport.scale()).into())
    }
}

fn check_surfel(surfel: &Surfel, count: usize) -> Result<(), SurfelDamage> {
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
