//! After an edit the picture equals one rendered from scratch, and only samples changed by the edit are shaded. Both renderers are
//! tested with this.

use crate::{
    Appearance, Assigned, Backend, Baked, Components, LitScene, Look, Renderer, ShadedSamples, View,
    shade::surface::FirstHit,
    shade::surface::Surfaces,
    test_looks::look,
    test_scenes::{floor_and_wall, from_below, illumination, light, mirror_under_plate, point_light, toward_mirror},
};
use glam::Vec3;
use lapidary_core::{camera::Camera, dataset::Dataset, image::Image, lights::Emission, scene::Mesh};

/// Samples per pixel.
const AA: u32 = 3;

/// A floor with material 0 on one half and 2 on the other, beside an emissive wall of material 1.
fn baked() -> Baked {
    let mut dataset: Dataset = floor_and_wall(4);
    dataset.scene.materials.push(dataset.scene.materials[0].clone());
    let mesh: &mut Mesh = &mut dataset.scene.mesh;
    for (triangle, material) in mesh.triangles.iter().zip(&mut mesh.triangle_material).filter(|(_, m)| **m == 0) {
        let x: f32 = triangle.iter().map(|&v| mesh.positions[v as usize].x).sum();
        *material = if x < 0.0 { 0 } else { 2 };
    }
    dataset.into()
}

/// Lit half by a sky with one brighter side, half by a lamp in front of the wall.
fn base(baked: &Baked, components: Components) -> Look {
    let camera = Camera::look_at(Vec3::new(1.0, 3.0, 4.0), Vec3::new(-0.5, 0.3, 0.0), 50.0);
    let view = View { aa: AA, ..View::new(camera, [40, 32]) };
    let lights = [point_light(Vec3::new(0.5, 1.2, 0.4), 2.0)].into();
    let illumination = illumination([16, 8], |x, _| Vec3::splat(0.05 + 0.02 * x as f32));
    let appearance = Appearance::of(&baked.dataset.scene);
    Look { appearance, illumination, lights, components, view, illum_cut: 64, ..look() }
}

/// A renderer with its scene.
pub struct Shown<B: Backend> {
    scene: LitScene<B>,
    look: Look,
}

impl<B: Backend> Shown<B> {
    fn new(backend: B, baked: &Baked, components: Components) -> Self {
        let scene = LitScene::new(Box::new(backend), baked.clone()).unwrap();
        Self { scene, look: base(baked, components) }
    }

    /// The picture of a look, rendered from scratch.
    fn anew(&mut self, look: &Look) -> Image {
        self.scene.light(look).unwrap();
        self.scene.begin(&look.view, look.sampling).unwrap();
        self.scene.show_whole(look).unwrap().image
    }

    /// The picture after an edit, its shaded samples, and its rendered bands.
    fn edit(&mut self, edit: impl Fn(&mut Look)) -> (Image, ShadedSamples, u32) {
        edit(&mut self.look);
        let mut bands = 0;
        let mut count = || {
            bands += 1;
            true
        };
        let picture = self.scene.show(&self.look, &mut count).unwrap().unwrap();
        (picture.image, self.scene.backend().stats().unwrap().shaded, bands)
    }
}

/// Surface samples in all pixels, and in pixels that show a material.
fn surfaces(baked: &Baked, view: &View, material: u32) -> [u64; 2] {
    let renderer = Renderer::new(baked.clone());
    let surfaces = Surfaces::of(&renderer);
    let (mut all, mut showing) = (0, 0);
    for pixel in 0..view.size[0] * view.size[1] {
        let at = glam::Vec2::new((pixel % view.size[0]) as f32, (pixel / view.size[0]) as f32);
        let seen = view.pixel_offsets().into_iter().filter_map(|offset| {
            let direction = view.camera.direction_through(at + offset, view.size);
            match surfaces.seen_along(view.camera.eye, direction) {
                FirstHit::Surface(point) => Some(point.material),
                _ => None,
            }
        });
        let materials: Vec<u32> = seen.collect();
        all += materials.len() as u64;
        showing += if materials.contains(&material) { materials.len() as u64 } else { 0 };
    }
    [all, showing]
}

/// Largest difference as a share of the brightest value.
fn difference(a: &Image, b: &Image) -> f32 {
    let largest = b.pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / largest
}

/// Checks the shading work of each edit, and that the picture equals one rendered from scratch. `slack` is the share of samples at
/// edges by which a rasterizer may differ.
pub fn edits_shade_what_they_change<B: Backend>(make: impl Fn() -> B, slack: f64) {
    for components in [Components::UNBOUNCED, Components::ALL] {
        let baked = baked();
        let [mut shown, mut other] = [0, 1].map(|_| Shown::new(make(), &baked, components));
        let [all, floor] = surfaces(&baked, &shown.look.view, 0);
        assert!(floor > all / 5 && floor < all / 2);
        let bounce = if components.indirect { all } else { 0 };
        let of = |environment, bounce, direct, added| ShadedSamples {
            environment,
            bounce,
            direct,
            added,
            ..Default::default()
        };
        // Each spot has a shadow map, so a third spot leaves all maps' sizes unchanged.
        let cone = Emission::Spot { cone_degrees: 50.0, penumbra_degrees: 10.0 };
        let lamp = || light(cone, Vec3::new(-1.0, 1.5, -0.5), Vec3::new(-0.5, 0.0, 0.0), 3.0);
        let lights = |look: &mut Look, change: &dyn Fn(&mut Vec<_>)| {
            let mut lights = look.lights.to_vec();
            change(&mut lights);
            look.lights = lights.into();
        };
        type Edit<'a> = (&'a str, Box<dyn Fn(&mut Look) + 'a>, ShadedSamples);
        let edits: [Edit; 12] = [
            ("the first picture", Box::new(|_| ()), of(all, bounce, all, 0)),
            (
                "a material",
                Box::new(|look| look.appearance.materials[0].parameters.set("base_color", Vec3::new(0.2, 0.9, 0.4))),
                of(floor, bounce, floor, 0),
            ),
            ("another sky", Box::new(|look| look.illumination.rotation += 1.0), of(all, bounce, 0, 0)),
            ("a lamp that moves", Box::new(|l| lights(l, &|l| l[0].position.x += 0.2)), of(0, bounce, all, 0)),
            ("a second lamp", Box::new(|look| lights(look, &|l| l.push(lamp()))), of(0, bounce, 0, all)),
            ("that moves", Box::new(|look| lights(look, &|l| l[1].position.y += 0.5)), of(0, bounce, 0, all)),
            ("a third", Box::new(|look| lights(look, &|l| l.insert(0, lamp()))), of(0, bounce, 0, all)),
            ("off again", Box::new(|look| lights(look, &|l| l[0].enabled = false)), of(0, bounce, 0, 0)),
            (
                "a material under two parts of lamps",
                Box::new(|look| lights(look, &|l| l[0].enabled = true)),
                of(0, bounce, 0, all),
            ),
            (
                "the material again",
                Box::new(|look| look.appearance.materials[0].parameters.set("base_color", Vec3::splat(0.5))),
                of(floor, bounce, floor, floor),
            ),
            ("without lamps", Box::new(|look| lights(look, &|l| l.clear())), of(0, bounce, 0, 0)),
            ("without sky", Box::new(|look| look.components.environment = false), of(all, 0, 0, 0)),
        ];
        let mut before = Image::filled(shown.look.view.size, Vec3::ZERO);
        for (name, edit, expected) in edits {
            let (image, shaded, _) = shown.edit(edit);
            let near = |a: u64, b: u64| a.abs_diff(b) as f64 <= slack * all as f64 && (a == 0) == (b == 0);
            let counts = |s: ShadedSamples| [s.environment, s.bounce, s.direct, s.added];
            let fits = counts(shaded).into_iter().zip(counts(expected)).all(|(a, b)| near(a, b));
            assert!(fits, "{name}, {components}: {shaded:?} for {expected:?}");
            let whole = other.anew(&shown.look);
            // Sums of lamps in two parts round differently, and each omits its own negligible light.
            let rounded = shown.look.lights.len() > 1;
            let off = difference(&image, &whole);
            assert!(if rounded { off < 2e-4 } else { image == whole }, "{name}, {components}: {off}");
            assert!(difference(&image, &before) > 1e-2, "negative control: {name} must be visible");
            before = image;
            let (same, _, bands) = shown.edit(|look| look.post.exposure += 1.0);
            assert!(bands == 0 && same == before, "exposure affects the display alone");
        }
    }
}

/// Pictures that were stopped and then edited.
pub fn unfinished_pictures_go_on<B: Backend>(make: impl Fn() -> B) {
    let baked = baked();
    let mut shown = Shown::new(make(), &baked, Components::ALL);
    let edits: [fn(&mut Look); 5] = [
        |look| look.appearance.materials[0].parameters.set("base_color", Vec3::X),
        |look| look.lights = look.lights.iter().cloned().chain([point_light(Vec3::Y, 1.0)]).collect(),
        |look| look.illumination.rotation += 0.5,
        |look| look.appearance.materials[2].parameters.set("base_color", Vec3::Y),
        |look| look.lights = look.lights.iter().cloned().chain([point_light(Vec3::splat(0.7), 1.0)]).collect(),
    ];
    let (view, sampling) = (shown.look.view.clone(), shown.look.sampling);
    for (number, edit) in edits.into_iter().enumerate() {
        edit(&mut shown.look);
        shown.scene.light(&shown.look).unwrap();
        shown.scene.resume(&view, sampling).unwrap();
        for sample in 0..number as u32 % AA {
            shown.scene.render_rows(sample, 0..view.size[1]).unwrap();
        }
        shown.scene.render_rows(number as u32 % AA, 0..7).unwrap();
    }
    let image = shown.edit(|_| ()).0;
    let off = difference(&image, &Shown::new(make(), &baked, Components::ALL).anew(&shown.look));
    assert!(off < 2e-4, "{off}");
    let other = shown.edit(|look| look.view.camera.eye.x += 0.01).0;
    assert!(difference(&other, &image) > 1e-2, "negative control: another view starts from scratch");
}

/// Bounced light that a material changes invisibly stays, and does not creep.
pub fn unseen_changes_do_not_creep<B: Backend>(make: impl Fn() -> B) {
    let baked = baked();
    let components = Components { indirect: true, ..Components::NONE };
    let [mut shown, mut other] = [0, 1].map(|_| Shown::new(make(), &baked, components));
    shown.scene = shown.scene.keep_unseen_changes();
    let all = shown.edit(|_| ()).1.bounce;
    let brighter = |share: f32| {
        move |look: &mut Look| {
            let parameters = &mut look.appearance.materials[1].parameters;
            parameters.set("base_color", share * parameters.color("base_color"));
        }
    };
    let (mut kept, mut redone) = (0, 0);
    for _ in 0..12 {
        let (image, shaded, _) = shown.edit(brighter(1.0 + 0.3 / 512.0));
        let whole = other.anew(&shown.look);
        // Brightness differs everywhere by at most the bound, relative to each pixel.
        let near = |(a, b): (&Vec3, &Vec3)| (a - b).abs().cmple(1.01 / 512.0 * b + 1e-6).all();
        assert!(image.pixels.iter().zip(&whole.pixels).all(near));
        if shaded.bounce == all { redone += 1 } else { kept += 1 }
    }
    assert_eq!((kept, redone), (9, 3), "every fourth");
    assert_eq!(shown.edit(brighter(1.1)).1.bounce, all, "negative control: a visible change");
}

/// After an edit of what a mirror shows, the picture equals one rendered from scratch.
pub fn edits_reach_what_mirrors_show<B: Backend>(make: impl Fn() -> B) {
    let baked = Baked::from(mirror_under_plate(0.0025));
    let [mut shown, mut other] = [0, 1].map(|_| Shown::new(make(), &baked, Components::UNBOUNCED));
    for shown in [&mut shown, &mut other] {
        let appearance = Appearance::of(&baked.dataset.scene);
        shown.look = Look { appearance, illumination: from_below(), lights: [].into(), ..shown.look.clone() };
        shown.look.view.camera = toward_mirror([40, 32]).camera;
    }
    let [all, floor] = surfaces(&baked, &shown.look.view, 0);
    assert_eq!(shown.edit(|_| ()).1.mirrors, all);
    let plate = |color: Vec3| move |look: &mut Look| look.appearance.materials[1].parameters.set("base_color", color);
    let before = shown.edit(plate(Vec3::ONE)).0;
    let (image, shaded, _) = shown.edit(plate(Vec3::new(0.1, 0.5, 0.2)));
    assert!(difference(&image, &before) > 0.05, "negative control: the plate shows");
    assert!(shaded.mirrors.abs_diff(floor) < all / 20, "{shaded:?}: only {floor} of {all} mirror");
    let expected = other.anew(&shown.look);
    assert!(difference(&image, &expected) < 1e-5, "{}", difference(&image, &expected));
    let rough = shown.edit(|look| look.appearance.materials[0].parameters.set("roughness", 0.6)).0;
    let expected = other.anew(&shown.look);
    assert!(difference(&rough, &expected) < 1e-5, "no mirror is left: {}", difference(&rough, &expected));
}

/// Triangles with another assigned, emissive material look as if the mesh had it, and only pixels that show them are shaded again.
pub fn assigned_materials_look_as_those_of_the_mesh<B: Backend>(make: impl Fn() -> B, slack: f64) {
    let baked = baked();
    let mut shown = Shown::new(make(), &baked, Components::UNBOUNCED);
    let own: Assigned = Some(baked.dataset.scene.mesh.triangle_material.clone().into());
    let before = shown.edit(|look| look.appearance.assigned = own.clone()).0;
    let mut glow = baked.dataset.scene.materials[1].clone();
    glow.parameters.set("base_color", Vec3::new(0.1, 0.7, 0.2));
    glow.set_emission(Vec3::new(0.3, 0.1, 0.0));

    let mut oracle = (*baked.dataset).clone();
    oracle.scene.materials.push(glow.clone());
    oracle.scene.mesh.triangle_material.iter_mut().filter(|m| **m == 2).for_each(|m| *m = 3);
    let other: Assigned = Some(oracle.scene.mesh.triangle_material.clone().into());
    let oracle = Baked::from(oracle);

    let [all, half] = surfaces(&baked, &shown.look.view, 2);
    let (image, shaded, _) = shown.edit(|look| {
        look.appearance.materials.push(glow.clone());
        look.appearance.assigned = other.clone();
    });
    let expected = Shown::new(make(), &oracle, Components::UNBOUNCED).edit(|_| ()).0;
    assert!(image == expected, "{}", difference(&image, &expected));
    assert!(difference(&image, &before) > 1e-2, "negative control: the change must be visible");
    let near = |count: u64| count.abs_diff(half) as f64 <= slack * all as f64;
    assert!(near(shaded.environment) && near(shaded.direct), "{shaded:?} for {half} of {all}");
    let (back, ..) = shown.edit(|look| {
        look.appearance.materials.pop();
        look.appearance.assigned = own.clone();
    });
    assert!(back == before, "{}", difference(&back, &before));

    shown.look.components = Components::ALL;
    let mut expected = Shown::new(make(), &oracle, Components::ALL);
    let image = shown.edit(|look| {
        look.appearance.materials.push(glow.clone());
        look.appearance.assigned = other.clone();
    });
    assert!(image.0 == expected.edit(|_| ()).0, "its reflected and emitted light reaches other surfaces");
}

mod on_the_cpu {
    use crate::CpuBackend;

    #[test]
    fn edits_reach_what_mirrors_show() {
        super::edits_reach_what_mirrors_show(CpuBackend::new);
    }

    #[test]
    fn edits_shade_what_they_change() {
        super::edits_shade_what_they_change(CpuBackend::new, 0.0);
    }

    #[test]
    fn assigned_materials_look_as_those_of_the_mesh() {
        super::assigned_materials_look_as_those_of_the_mesh(CpuBackend::new, 0.0);
    }

    #[test]
    fn unfinished_pictures_go_on() {
        super::unfinished_pictures_go_on(CpuBackend::new);
    }

    #[test]
    fn unseen_changes_do_not_creep() {
        super::unseen_changes_do_not_creep(CpuBackend::new);
    }
}
