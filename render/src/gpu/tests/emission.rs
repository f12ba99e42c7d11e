//! Light that surfaces send by themselves, and sharp lobes, against the CPU.

use super::twin::{agrees, appearance, backend, difference, maps, on_the_cpu, parameters, scene, view};
use crate::{
    Backend, BrdfSampling, Components, EnvironmentLight, LocalLighting, Renderer, ViewMode,
    shade::painter::PictureLight, test_scenes::illumination,
};
use glam::Vec3;
use lapidary_core::{
    brdf::{BrdfModel, Parameters},
    material::MaterialMaps,
};
use std::sync::Arc;

fn shining(luminance: f32) -> Parameters {
    let mut shining = Parameters::from(parameters(0.5, 0.0));
    shining.set("emission_color", Vec3::new(1.0, 0.5, 0.25));
    shining.set("emission_luminance", luminance);
    shining
}

/// The emission is shown with local lights, and has maps as all parameters.
#[test]
fn emission_agrees_and_is_shown_with_local_lights() {
    let Some((_one, mut gpu)) = backend() else { return };
    let mut renderer = Renderer::new(scene());
    gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
    let mut maps = MaterialMaps::default();
    maps.set("emission_color", super::twin::maps().get("base_color").cloned());
    maps.set("emission_luminance", super::twin::maps().get("roughness").cloned());
    let mut shown = |luminance: f32, maps: &MaterialMaps, emission: bool| {
        let looks = appearance(renderer.dataset(), BrdfModel::Ggx, shining(luminance), maps.clone());
        gpu.set_appearance(&looks).unwrap();
        renderer.set_appearance(looks);
        let components = Components { direct: emission, ..Components::NONE };
        gpu.set_local_lighting(&LocalLighting { components, ..Default::default() }).unwrap();
        gpu.begin(&view(ViewMode::Shaded), BrdfSampling::Lit).unwrap();
        gpu.render_rows(0, 0..view(ViewMode::Shaded).size[1]).unwrap();
        let light = PictureLight { emission, ..Default::default() };
        let cpu = on_the_cpu(&gpu, &renderer, &view(ViewMode::Shaded), light, BrdfSampling::Lit);
        (gpu.read(1).unwrap().0, cpu)
    };
    let (gpu, cpu) = shown(3.0, &maps, true);
    assert!(agrees(&gpu, &cpu), "{:?}", difference(&gpu, &cpu));
    let (plain, _) = shown(3.0, &MaterialMaps::default(), true);
    assert!(!agrees(&plain, &cpu), "negative control: without maps");
    let (dark, cpu_dark) = shown(3.0, &maps, false);
    assert!(agrees(&dark, &cpu_dark) && !agrees(&dark, &cpu), "negative control: without local lights");
}

/// Mirrors of few and many texels, turned, in all samplings that have them.
#[test]
fn mirrors_agree_and_read_the_map() {
    let Some((_one, mut gpu)) = backend() else { return };
    let mut renderer = Renderer::new(scene());
    gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
    let coated = |roughness: f32| {
        let mut coated = Parameters::default();
        coated.set("coat_weight", 1.0);
        coated.set("coat_roughness", roughness);
        coated.set("specular_roughness", 0.15);
        coated
    };
    for size in [[37, 20], [3, 1]] {
        let sky = illumination(size, |x, y| Vec3::new(0.3, (x % 3) as f32, (y % 2) as f32 + 0.1));
        let sky = crate::Illumination { rotation: 0.7, intensity: 1.3, ..sky };
        let lighting: Arc<EnvironmentLight> = renderer.lighting(&sky, 64).into();
        let mut blurred = (*lighting).clone();
        blurred.lights.mirrored = None;
        for (model, parameters) in [
            (BrdfModel::Ggx, Parameters::from(parameters(0.08, 0.0))),
            (BrdfModel::Ward, Parameters::from(parameters(0.1, 0.7))),
            (BrdfModel::OpenPbr, coated(0.05)),
        ] {
            let looks = appearance(renderer.dataset(), model, parameters, maps_of_normals());
            gpu.set_appearance(&looks).unwrap();
            renderer.set_appearance(looks);
            for sampling in [BrdfSampling::Refine, BrdfSampling::Lit] {
                gpu.set_light(&sky, &lighting).unwrap();
                gpu.begin(&view(ViewMode::Shaded), sampling).unwrap();
                gpu.render_rows(0, 0..view(ViewMode::Shaded).size[1]).unwrap();
                let found = gpu.read(1).unwrap().0;
                let on_the_cpu = |lighting| {
                    let light = PictureLight { environment: Some(lighting), ..Default::default() };
                    on_the_cpu(&gpu, &renderer, &view(ViewMode::Shaded), light, sampling)
                };
                let expected = on_the_cpu(&lighting);
                assert!(agrees(&found, &expected), "{model:?} {size:?}: {:?}", difference(&found, &expected));
                let blurred = on_the_cpu(&blurred);
                assert!(!agrees(&blurred, &expected), "negative control: without the map, {model:?} {size:?}");
            }
        }
    }
}

fn maps_of_normals() -> MaterialMaps {
    let mut of_normals = maps();
    of_normals.retain(|name, _| name == "normal");
    of_normals
}
