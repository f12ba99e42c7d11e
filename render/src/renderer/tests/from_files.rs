//! BRDFs from files: refinement finds their lobes as it does for analytic models.

use super::*;
use lapidary_core::{
    brdf::{Brdf, BrdfFile, BrdfModel, Content, Ggx, GgxParameters, Measured, Written},
    material::Material,
};

/// A measured material with the tabulated values of a metal.
fn measured(roughness: f32) -> Material {
    let ggx = Ggx::new(&GgxParameters { roughness, metalness: 1.0, ..Default::default() });
    let table = Measured::tabulated(|wi, wo| ggx.brdf_cos(wi, wo) / wi.z);
    let file = BrdfFile { path: "metal.binary".into(), content: Some(Content::Measured(table.into())) };
    Material { model: BrdfModel::Merl, file: Some(file), ..Default::default() }
}

/// A highlight written in WGSL.
fn written(exponent: f32) -> Material {
    let text = include_str!("../../../../data/brdfs/gloss.wgsl");
    let file =
        BrdfFile { path: "gloss.wgsl".into(), content: Some(Content::Written(Written::new(text).unwrap().into())) };
    let mut material = Material { model: BrdfModel::Wgsl, file: Some(file), ..Default::default() };
    material.parameters.set("exponent", exponent);
    material.parameters.set("gloss", 0.8);
    material
}

#[test]
fn refinement_of_measured_and_written_lobes_beats_sampling_once() {
    let sun = |x: u32, y: u32| if (30..33).contains(&x) && (20..22).contains(&y) { 300.0 } else { 0.5 };
    let light = illumination([128, 64], |x, y| Vec3::splat(sun(x, y)));
    let view = from_the_side(32);
    for material in [measured(0.35), written(120.0)] {
        let mut dataset = dataset(mesh(24, true), glossy(0.35));
        let name = material.file.as_ref().unwrap().name();
        dataset.scene.materials.iter_mut().for_each(|m| *m = Material { name: m.name.clone(), ..material.clone() });
        let renderer = Renderer::new(dataset);
        let reference = renderer.samples_reference(&view, &light, &Quiet);
        let error = |sampling| rel_rmse(&renderer.render(&view, &light, 64, sampling).0, &reference);
        let [once, refined] = [BrdfSampling::Once, BrdfSampling::Refine].map(error);
        assert!(refined < 0.5 * once && refined < 0.1, "{name}: {once} to {refined}");
    }
}
