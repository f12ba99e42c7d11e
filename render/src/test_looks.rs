//! Looks shared by the tests of several crates.

use crate::{Appearance, Components, Illumination, Look, View};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    cut::lit::DEFAULT_TAU,
    environment::Environment,
    image::Image,
    lights::{Emission, Light},
    material::{Material, MaterialMaps},
    scene::pose::Poses,
    texture::TextureSlot,
};

/// A look with two materials with maps, a light and an environment.
pub fn look() -> Look {
    let maps = MaterialMaps::from(["bump", "normal"].map(|kind| (kind, TextureSlot::default())));
    let material = |name: &str| Material { name: name.into(), maps: maps.clone(), ..Default::default() };
    let environment = Environment::new("gray".into(), Image::filled([4, 2], Vec3::ONE));
    let light = Light {
        name: "key".into(),
        emission: Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 },
        position: Vec3::new(1.0, 2.0, 0.5),
        target: Vec3::new(0.0, 0.2, 0.0),
        intensity: Vec3::splat(5.0),
        ..Default::default()
    };
    Look {
        poses: Poses::default(),
        appearance: Appearance { materials: vec![material("gold"), material("wood")], ..Default::default() },
        illumination: Illumination { environment: environment.into(), rotation: 0.3, intensity: 1.0, sun: None },
        lights: [light].into(),
        components: Components::ALL,
        solution: Default::default(),
        illum_cut: 256,
        tau: DEFAULT_TAU,
        sampling: Default::default(),
        view: View::new(Camera::look_at(Vec3::new(0.5, 1.0, 3.0), Vec3::new(0.1, 0.3, 0.0), 40.0), [8, 6]),
        post: Default::default(),
        backplate: None,
    }
}

/// A look without materials and lights under a white environment, in a small picture of `aa` samples per pixel.
pub fn plain_look(aa: u32) -> Look {
    let environment = Environment::new("white".into(), Image::filled([8, 4], Vec3::ONE));
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, 40.0);
    Look {
        poses: Poses::default(),
        appearance: Appearance::default(),
        illumination: Illumination { environment: environment.into(), rotation: 0.0, intensity: 1.0, sun: None },
        lights: [].into(),
        components: Components::ALL,
        solution: Default::default(),
        illum_cut: 16,
        tau: DEFAULT_TAU,
        sampling: Default::default(),
        view: View { aa, ..View::new(camera, [64, 48]) },
        post: Default::default(),
        backplate: None,
    }
}
