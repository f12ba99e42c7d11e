//! Sketches are close to the picture, keep its edges, and end as the picture.

use super::by_blocks;
use crate::{
    Appearance, Backend, Background, Baked, BrdfSampling, CpuBackend, Illumination, Renderer, STRIDES, Stale, Tiles,
    View, ViewMode,
    test_scenes::{dataset, from_the_side, illumination, mesh, rel_rmse, white},
};
use glam::{UVec2, Vec2, Vec3};
use lapidary_core::{
    brdf::GgxParameters,
    dataset::Dataset,
    image::{Image, Region},
    material::{BrdfModel, Material},
    scene::{
        Mesh, Object,
        pose::{Pose, Poses},
    },
};
use std::sync::Arc;

/// A red floor below a blue blocker; `change` edits the mesh.
fn scene(change: impl FnOnce(&mut Mesh)) -> Arc<Dataset> {
    let mut mesh = mesh(8, true);
    let floor = mesh.triangles.len() - 4;
    mesh.triangle_material[floor..].fill(1);
    change(&mut mesh);
    let lambert = |base_color| Material {
        model: BrdfModel::Lambert,
        parameters: GgxParameters { base_color, ..Default::default() }.into(),
        ..Default::default()
    };
    let mut dataset = dataset(mesh, white());
    dataset.scene.materials = vec![lambert(Vec3::X), lambert(Vec3::Z)];
    dataset.into()
}

fn light() -> Illumination {
    illumination([64, 32], |x, y| Vec3::splat(0.1 * x as f32 + 0.02 * y as f32))
}

fn lit(dataset: &Arc<Dataset>) -> CpuBackend {
    let mut backend = CpuBackend::new();
    backend.set_scene(&dataset.clone().into()).unwrap();
    let lighting = Renderer::new(dataset.clone()).lighting(&light(), 64);
    backend.set_light(&light(), &lighting.into()).unwrap();
    backend
}

fn sketch(backend: &mut CpuBackend, view: &View, stride: u32) {
    let tiles: Vec<u32> = (0..Tiles::of(view.size).count()).collect();
    backend.sketch(stride, &tiles).unwrap();
}

/// A sketch of one lattice.
fn sketched(backend: &mut CpuBackend, view: &View, stride: u32) -> Image {
    backend.begin(view, BrdfSampling::Refine).unwrap();
    sketch(backend, view, STRIDES[0]);
    sketch(backend, view, stride);
    backend.fill(0).unwrap();
    backend.read(0).unwrap().0
}

fn whole(backend: &mut CpuBackend, view: &View) -> Image {
    backend.begin(view, BrdfSampling::Refine).unwrap();
    backend.render_rows(0, 0..view.size[1]).unwrap();
    backend.read(1).unwrap().0
}

/// A picture stretched to `size`.
fn stretched(image: &Image, size: [u32; 2]) -> Image {
    let [from, to] = [image.size, size].map(|[x, y]| Vec2::new(x as f32, y as f32));
    let at = |p: Vec2| {
        let p = p.clamp(Vec2::ZERO, from - 1.0).as_uvec2();
        image.pixels[(p.y * image.size[0] + p.x) as usize]
    };
    Image::from_fn(size, |x, y| {
        let p = (UVec2::new(x, y).as_vec2() + 0.5) / to * from - 0.5;
        let f = p - p.floor();
        let row = |y: f32| at(Vec2::new(p.x.floor(), y)).lerp(at(Vec2::new(p.x.floor() + 1.0, y)), f.x);
        row(p.y.floor()).lerp(row(p.y.floor() + 1.0), f.y)
    })
}

fn view() -> View {
    View { background: Background::Environment, ..View::new(from_the_side(1).camera, [150, 110]) }
}

#[test]
fn a_sketch_is_far_closer_to_the_picture_than_a_stretched_one() {
    let (dataset, view) = (scene(|_| ()), view());
    let mut backend = lit(&dataset);
    let full = whole(&mut backend, &view);
    let errors = STRIDES.map(|stride| rel_rmse(&sketched(&mut backend, &view, stride), &full));
    let coarse = whole(&mut backend, &View { size: view.size.map(|side| side.div_ceil(8)), ..view.clone() });
    let today = rel_rmse(&stretched(&coarse, view.size), &full);
    assert!(errors[0] < 0.15 * today, "{errors:?}, stretched {today}");
    assert!(errors.windows(2).all(|e| e[1] < e[0]) && errors[3] == 0.0, "{errors:?}");
}

#[test]
fn no_colour_crosses_an_edge() {
    let (dataset, view) = (scene(|_| ()), View { background: Background::Flat(Vec3::Y), ..view() });
    let mut backend = lit(&dataset);
    let full = whole(&mut backend, &view);
    let channels = |image: &Image| image.pixels.iter().map(|p| p.cmpgt(Vec3::ZERO)).collect::<Vec<_>>();
    let edges = channels(&full);
    assert!([Vec3::X, Vec3::Y, Vec3::Z].iter().all(|c| edges.contains(&c.cmpgt(Vec3::ZERO))), "all are seen");
    for stride in STRIDES {
        assert!(channels(&sketched(&mut backend, &view, stride)) == edges, "{stride}");
    }
    let coarse = whole(&mut backend, &View { size: view.size.map(|side| side.div_ceil(8)), ..view.clone() });
    assert!(channels(&stretched(&coarse, view.size)) != edges, "negative control");
}

#[test]
fn every_lattice_keeps_the_coarser_ones_and_the_last_one_is_the_sample() {
    let (dataset, view) = (scene(|_| ()), View { aa: 3, ..view() });
    let mut backend = lit(&dataset);
    backend.begin(&view, BrdfSampling::Refine).unwrap();
    let mut before: Option<Image> = None;
    for stride in STRIDES {
        sketch(&mut backend, &view, stride);
        backend.fill(20).unwrap();
        let image = backend.read(0).unwrap().0;
        let coarser = 2 * stride;
        let kept = |i: usize, a: &Vec3| {
            let [x, y] = [i as u32 % view.size[0], i as u32 / view.size[0]];
            x % coarser != 0 || y % coarser != 0 || *a == image.pixels[i]
        };
        assert!(before.is_none_or(|before| before.pixels.iter().enumerate().all(|(i, a)| kept(i, a))), "{stride}");
        before = Some(image);
    }
    let shaded = backend.stats().unwrap();
    backend.render_rows(0, 0..view.size[1]).unwrap();
    assert_eq!(backend.stats().unwrap(), shaded, "no pixel lacks the first sample");
    let sketched = backend.read(1).unwrap().0;
    let mut other = lit(&dataset);
    assert!(sketched == whole(&mut other, &view));
    assert_eq!(shaded.pixels_shaded, other.stats().unwrap().pixels_shaded, "none was shaded twice");
    for backend in [&mut backend, &mut other] {
        (1..3).for_each(|sample| backend.render_rows(sample, 0..view.size[1]).unwrap());
    }
    assert!(backend.read(3).unwrap().0 == other.read(3).unwrap().0);
    assert!(sketched != backend.read(3).unwrap().0, "negative control");
}

#[test]
fn edits_and_cameras_are_looked_up_again() {
    let (dataset, view) = (scene(|_| ()), view());
    let mut backend = lit(&dataset);
    let old = sketched(&mut backend, &view, 1);
    let mut appearance = Appearance::of(&dataset.scene);
    appearance.materials[1].parameters.set("base_color", Vec3::new(0.2, 0.7, 0.3));
    let mut moved = view.clone();
    moved.camera.eye.x += 0.3;
    let mut other = lit(&dataset);
    for backend in [&mut backend, &mut other] {
        backend.set_appearance(&appearance).unwrap();
    }
    for view in [view, moved, View { size: [70, 90], ..self::view() }, View { mode: ViewMode::Normals, ..self::view() }]
    {
        let new = sketched(&mut backend, &view, 1);
        assert!(new == whole(&mut other, &view));
        assert!(new != old, "negative control");
        assert!(sketched(&mut backend, &view, 8) == sketched(&mut lit_with(&dataset, &appearance), &view, 8));
    }
}

#[test]
fn what_lets_light_through_is_looked_up_again() {
    let (dataset, view) = (scene(|_| ()), view());
    let mut backend = lit(&dataset);
    let opaque = sketched(&mut backend, &view, 1);
    for opacity in [0.5, 0.0, 1.0] {
        let mut appearance = Appearance::of(&dataset.scene);
        appearance.materials[1].parameters.set("geometry_opacity", opacity);
        backend.set_appearance(&appearance).unwrap();
        let sketched = sketched(&mut backend, &view, 1);
        assert!(sketched == whole(&mut lit_with(&dataset, &appearance), &view), "{opacity}");
        assert_eq!(sketched == opaque, opacity == 1.0, "negative control: {opacity}");
    }
}

fn lit_with(dataset: &Arc<Dataset>, appearance: &Appearance) -> CpuBackend {
    let mut backend = lit(dataset);
    backend.set_appearance(appearance).unwrap();
    backend
}

#[test]
fn a_thin_object_is_shaded_itself() {
    // Half a pixel to the right of a lattice column and narrower than a cell.
    let narrow = |mesh: &mut Mesh| {
        let first = mesh.positions.len() - 8;
        mesh.positions[first..].iter_mut().for_each(|p| p.x = 0.05 + 0.03 * p.x);
    };
    let (dataset, view) = (scene(narrow), view());
    let mut backend = lit(&dataset);
    let full = whole(&mut backend, &view);
    let blade: Vec<usize> =
        (0..full.pixels.len()).filter(|&i| full.pixels[i].z > 0.0 && full.pixels[i].x == 0.0).collect();
    let right = |image: &Image| blade.iter().filter(|&&i| image.pixels[i] == full.pixels[i]).count();
    assert!(right(&sketched(&mut backend, &view, 8)) < blade.len() / 2, "negative control");
    backend.fill(u32::MAX).unwrap();
    let image = backend.read(0).unwrap().0;
    assert!(blade.len() >= 8 && right(&image) > blade.len() / 2, "{} of {}", right(&image), blade.len());
    let close = |i: &usize| (image.pixels[*i] - full.pixels[*i]).length() < 0.1 * full.pixels[*i].length();
    assert!(blade.iter().all(close));
}

#[test]
fn without_light_and_in_the_smallest_pictures_nothing_is_undefined() {
    let dataset = scene(|_| ());
    let mut dark = CpuBackend::new();
    dark.set_scene(&dataset.clone().into()).unwrap();
    assert!(sketched(&mut dark, &view(), 8).pixels.iter().all(|p| *p == Vec3::ZERO));
    let mut backend = lit(&dataset);
    for size in [[1, 1], [3, 2], [7, 65], [65, 3]] {
        let view = View { size, ..view() };
        assert!(sketched(&mut backend, &view, 8).pixels.iter().all(|p| p.is_finite()), "{size:?}");
        assert!(sketched(&mut backend, &view, 1) == whole(&mut lit(&dataset), &view), "{size:?}");
        for mode in ViewMode::ALL {
            let view = View { mode, wireframe: true, ..view.clone() };
            assert!(sketched(&mut backend, &view, 2).pixels.iter().all(|p| p.is_finite()), "{mode:?}");
        }
    }
}

/// The view after the eye has moved slightly sideways.
fn moved(view: &View) -> View {
    let mut moved = view.clone();
    moved.camera.eye.x += 0.1;
    moved
}

/// A sketch of the coarsest lattice after a complete sketch of another view, with edits between.
fn sketched_after(backend: &mut CpuBackend, before: &View, view: &View, stale: &Stale) -> Image {
    sketched(backend, before, 1);
    coarse(backend, view, stale)
}

/// The coarsest lattice of a picture that follows another.
fn coarse(backend: &mut CpuBackend, view: &View, stale: &Stale) -> Image {
    backend.resume(view, BrdfSampling::Refine, stale).unwrap();
    sketch(backend, view, STRIDES[0]);
    backend.fill(0).unwrap();
    backend.read(0).unwrap().0
}

#[test]
fn after_a_small_move_a_sketch_has_the_detail_of_the_last_picture() {
    let (dataset, view) = (scene(|_| ()), view());
    let mut backend = lit(&dataset);
    let moved = moved(&view);
    let full = whole(&mut backend, &moved);
    let alone = sketched(&mut backend, &moved, 8);
    let after = sketched_after(&mut backend, &view, &moved, &Stale::NOTHING);
    let errors = [rel_rmse(&after, &full), rel_rmse(&alone, &full)];
    assert!(errors[0] < 0.4 * errors[1], "{errors:?}");
    // Also from a smaller picture, as at the end of a drag.
    let reduced = View { size: view.size.map(|side| side / 2), ..moved.clone() };
    let rested = rel_rmse(&sketched_after(&mut backend, &reduced, &moved, &Stale::NOTHING), &full);
    assert!(rested < 0.7 * errors[1], "{rested} {errors:?}");
    for stride in [4, 2, 1] {
        sketch(&mut backend, &moved, stride);
    }
    assert!(backend.read(1).unwrap().0 == full, "the last lattice keeps nothing of it");
}

#[test]
fn pictures_with_several_samples_tell_of_the_next_too() {
    let (dataset, view) = (scene(|_| ()), View { aa: 4, ..view() });
    let (mut backend, moved) = (lit(&dataset), moved(&view));
    let full = whole(&mut backend, &moved);
    let alone = rel_rmse(&sketched(&mut backend, &moved, 8), &full);
    sketched(&mut backend, &view, 1);
    (1..4).for_each(|sample| backend.render_rows(sample, 0..view.size[1]).unwrap());
    let after = rel_rmse(&coarse(&mut backend, &moved, &Stale::NOTHING), &full);
    assert!(after < 0.5 * alone, "{after} {alone}");
}

#[test]
fn a_sketch_knows_nothing_of_pictures_of_another_light_or_material() {
    let (dataset, view) = (scene(|_| ()), view());
    let (mut backend, moved) = (lit(&dataset), moved(&view));
    let alone = sketched(&mut backend, &moved, 8);
    let after = |backend: &mut CpuBackend, before: &View, stale: &Stale| {
        sketched_after(backend, before, &moved, stale) == alone
    };
    assert!(after(&mut backend, &view, &Stale::ALL));
    for other in [
        View { mode: ViewMode::Albedo, ..view.clone() },
        View { background: Background::Flat(Vec3::Y), ..view.clone() },
    ] {
        assert!(after(&mut backend, &other, &Stale::NOTHING));
    }
    sketched(&mut backend, &view, 1);
    backend.resume(&moved, BrdfSampling::Once, &Stale::NOTHING).unwrap();
    assert!(coarse(&mut backend, &moved, &Stale::NOTHING) == alone, "another way to merge was between");
    assert!(!after(&mut backend, &view, &Stale::NOTHING), "negative control");
    // Nothing of the previous scene remains either.
    sketched(&mut backend, &view, 1);
    let lighting = Renderer::new(dataset.clone()).lighting(&light(), 64);
    backend.set_scene(&dataset.clone().into()).unwrap();
    backend.set_light(&light(), &lighting.into()).unwrap();
    assert!(coarse(&mut backend, &moved, &Stale::NOTHING) == alone);
}

#[test]
fn what_comes_into_view_is_filled_as_without_a_last_picture() {
    let (dataset, view) = (scene(|_| ()), view());
    let mut backend = lit(&dataset);
    let mut away = view.clone();
    away.camera.target = 2.0 * away.camera.eye - away.camera.target;
    let alone = sketched(&mut backend, &view, 8);
    assert!(sketched_after(&mut backend, &away, &view, &Stale::NOTHING) == alone, "it showed nothing of it");
    let unseen = View { size: [0, 0], ..view.clone() };
    assert!(sketched_after(&mut backend, &unseen, &view, &Stale::NOTHING) == alone);
}

#[test]
fn blocks_hold_each_pixel_of_a_region_once() {
    for (width, height) in [(64, 64), (1, 1), (7, 5), (3, 64)] {
        let region = Region { x: 64, y: 128, width, height };
        let mut pixels: Vec<[u32; 2]> = by_blocks(region).collect();
        assert_eq!(pixels[..2.min(pixels.len())].last(), Some(&[64 + u32::from(width > 1), 128]));
        pixels.sort_unstable_by_key(|&[x, y]| (y, x));
        let rows: Vec<[u32; 2]> = region.rows().flat_map(|y| region.columns().map(move |x| [x, y])).collect();
        assert_eq!(pixels, rows);
    }
}

#[test]
fn posed_objects_are_looked_up_where_they_were_and_where_they_are() {
    let dataset = scene(|mesh| {
        let blocker = mesh.triangles.len() - 4;
        mesh.triangle_object[blocker..].fill(1);
    });
    let mut dataset = Arc::unwrap_or_clone(dataset);
    dataset.scene.objects.push(Object { name: "blocker".into() });
    let baked = Baked::from(dataset);
    let at = |x: f32, degrees: f32| {
        let mut poses = Poses::default();
        poses.set(1, Pose { translate: Vec3::X * x, rotate_degrees: Vec3::Z * degrees, scale: 1.0, ..Pose::AS_BAKED });
        baked.posed(&poses).unwrap()
    };
    let relit = |backend: &mut CpuBackend, posed: &Baked| {
        let lighting = Renderer::new(posed.clone()).lighting(&light(), 64);
        backend.set_light(&light(), &lighting.into()).unwrap();
        sketched(backend, &view(), STRIDES[3])
    };
    let mut dragged = lit(&baked.dataset);
    let mut last = sketched(&mut dragged, &view(), STRIDES[3]);
    for posed in [at(0.1, 0.0), at(0.4, 20.0), at(5.0, 0.0), at(0.0, 0.0)] {
        dragged.pose(&posed, None).unwrap();
        let stale = dragged.sketch.stale.iter().filter(|stale| **stale).count();
        assert!(stale > 0 && stale < 150 * 110 / 2, "{stale} pixels look again");
        let now = relit(&mut dragged, &posed);
        assert!(now == relit(&mut lit(&posed.dataset), &posed), "as where nothing was known");
        assert!(now != last, "negative control: another pose");
        last = now;
    }
}
