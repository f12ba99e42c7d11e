//! Scenes, lights and views shared by tests, small enough for known answers.

mod mirrors;

use crate::{
    Appearance, Background, Baked, BrdfSampling, Changes, Components, Illumination, LocalLighting, LocalRig,
    PictureStats, RenderStats, Renderer, SceneLighting, Situation, Solution, Tier, View,
    cpu::picture::Picture,
    light::situation::Relight,
    measure::compare::compare,
    shade::{
        background::{Backdrop, BlurCache},
        painter::{Painter, PictureLight},
        pixel_sampler::PixelSampler,
        seen_scene::SeenScene,
        surface::{FirstHit, SurfacePoint, Surfaces},
    },
};
use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{
    brdf::{GgxParameters, Parameters},
    camera::Camera,
    cut::{
        CutCriterion, CutSelector,
        packed::{PackedCuts, pack_node},
        solid_angle_code,
    },
    dataset::{BakeReport, BakeSettings, Dataset},
    environment::Environment,
    image::Image,
    light_tree::{LightTree, TreeKind},
    lights::{Emission, Light},
    material::{BrdfModel, Material},
    meshless::{Basis, MeshlessBake, Transport},
    ray::{DirectionSet, Intersector, OPEN},
    scene::{Mesh, Object, Scene, pose::Poses},
    sources::{IndirectBake, Source},
    surfel::{MeshPlace, Surfel},
};
pub(crate) use mirrors::{
    from_below, into_bowl, metal, mirror, mirror_bowl, mirror_under_ball, mirror_under_plate, toward_mirror,
    two_mirrors_and_plate,
};
use std::{
    f32::consts::PI,
    ops::{Deref, DerefMut},
    time::Instant,
};

/// A rig with its situation, which tests edit step by step.
pub(crate) struct Edited<L> {
    rig: L,
    pub situation: Situation,
}

impl<L: Relight> Edited<L> {
    /// A rig for a scene as baked, without light.
    pub fn new(baked: &Baked, mut rig: L) -> Self {
        let situation = Situation::unlit(baked);
        rig.update(&situation, Changes::ALL);
        Self { rig, situation }
    }

    pub fn set_lights(&mut self, lights: &[Light]) {
        self.situation.lights = lights.into();
        self.rig.update(&self.situation, Changes { lights: true, ..Changes::NONE });
    }

    pub fn set_appearance(&mut self, appearance: &Appearance) {
        self.situation.appearance = appearance.clone().into();
        self.rig.update(&self.situation, Changes { appearance: true, ..Changes::NONE });
    }

    pub fn set_environment(&mut self, lighting: Option<SceneLighting>) {
        self.situation.environment = lighting.map(Into::into);
        self.rig.update(&self.situation, Changes { environment: true, ..Changes::NONE });
    }

    pub fn set_poses(&mut self, baked: &Baked, poses: &Poses) {
        (self.situation.scene, self.situation.poses) = (baked.posed(poses).expect("within reach"), poses.clone());
        self.rig.update(&self.situation, Changes { poses: true, ..Changes::NONE });
    }
}

impl Edited<LocalRig> {
    /// The completed light by a solution.
    pub fn lighting(&mut self, components: Components, solution: Solution, illum_cut: u32) -> LocalLighting {
        if self.situation.gathering.illum_cut != illum_cut {
            self.situation.gathering.illum_cut = illum_cut;
            self.rig.update(&self.situation, Changes { gathering: true, ..Changes::NONE });
        }
        while components.indirect && self.rig.advance(&self.situation, solution) {}
        self.rig.lighting(&self.situation, components, solution)
    }
}

impl Relight for LocalRig {
    fn update(&mut self, _: &Situation, changes: Changes) {
        self.note(changes);
    }
}

impl<L> Deref for Edited<L> {
    type Target = L;

    fn deref(&self) -> &L {
        &self.rig
    }
}

impl<L> DerefMut for Edited<L> {
    fn deref_mut(&mut self) -> &mut L {
        &mut self.rig
    }
}

/// Sources along each side of the wall, as a power of two.
pub(crate) const SIDE_LOG2: u32 = 5;
pub(crate) const SOURCES: usize = 1 << (2 * SIDE_LOG2);
/// The wall beside the floor, counter-clockwise seen from it.
pub(crate) const WALL: [Vec3; 4] =
    [Vec3::new(-2.2, 0.2, 1.0), Vec3::new(-2.2, 0.2, -1.0), Vec3::new(-2.2, 2.2, -1.0), Vec3::new(-2.2, 2.2, 1.0)];

/// Vector irradiance of the floor from a wall of unit radiance.
pub(crate) const LINK: Vec3 = Vec3::new(-0.3, 0.2, 0.05);

pub(crate) const LIGHTS: usize = 4096;

/// A floor of `cells` x `cells` squares over [-2, 2]², with a horizontal blocker of half-width 0.5 at height 1 if `blocker`.
pub(crate) fn mesh(cells: u32, blocker: bool) -> Mesh {
    floor_under_plate(cells, blocker.then_some(1))
}

/// The same with the squares along each edge of the blocker.
fn floor_under_plate(cells: u32, of_plate: Option<u32>) -> Mesh {
    let mut mesh = Mesh::default();
    let mut grid = |cells: u32, half: f32, y: f32, flip: bool| {
        let first = mesh.positions.len() as u32;
        for j in 0..=cells {
            for i in 0..=cells {
                let p = |k: u32| half * (2.0 * k as f32 / cells as f32 - 1.0);
                mesh.positions.push(Vec3::new(p(i), y, p(j)));
                mesh.normals.push(if flip { Vec3::NEG_Y } else { Vec3::Y });
                mesh.tangents.push(Vec4::new(1.0, 0.0, 0.0, 1.0));
                mesh.uvs.push(Vec2::new(p(i), p(j)));
            }
        }
        for j in 0..cells {
            for i in 0..cells {
                let v = |i: u32, j: u32| first + j * (cells + 1) + i;
                let (a, b, c, d) = (v(i, j), v(i, j + 1), v(i + 1, j + 1), v(i + 1, j));
                mesh.triangles.extend(if flip { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
            }
        }
    };
    grid(cells, 2.0, 0.0, false);
    if let Some(cells) = of_plate {
        grid(cells, 0.5, 1.0, false);
        grid(cells, 0.5, 0.999, true);
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh.triangle_object = vec![0; mesh.triangles.len()];
    mesh
}

/// A dataset whose cuts are exact at every vertex (sigma 0).
pub(crate) fn dataset(mesh: Mesh, parameters: impl Into<Parameters>) -> Dataset {
    dataset_of_sigma(mesh, parameters, 0.0)
}

/// Sets the lights visible from a vertex, as in the cuts of these datasets.
pub(crate) fn trace_vertex(
    mesh: &Mesh,
    intersector: &Intersector,
    lights: &DirectionSet,
    vertex: u32,
    seen: &mut [u8],
) {
    let (p, n) = (mesh.positions[vertex as usize], mesh.normals[vertex as usize]);
    intersector.trace_batch(p + n * 1e-3, lights, |_, d| d.dot(n) > 0.0, seen);
}

pub(crate) fn dataset_of_sigma(mesh: Mesh, parameters: impl Into<Parameters>, sigma: f32) -> Dataset {
    let tree = LightTree::geometric(LIGHTS).unwrap();
    let directions = DirectionSet::new(tree.leaf_directions());
    let intersector = Intersector::new(&mesh);
    let criterion = CutCriterion { sigma, ..Default::default() };
    let mut selector = CutSelector::new(tree.height(), criterion);
    let mut cuts = PackedCuts::default();
    for vertex in 0..mesh.positions.len() as u32 {
        let mut visible = vec![0; LIGHTS];
        trace_vertex(&mesh, &intersector, &directions, vertex, &mut visible);
        let mut cut = Vec::new();
        selector.select(&visible, &mut cut);
        let offset = cuts.push_cut(&cut);
        cuts.push_vertex(offset);
    }
    let settings = BakeSettings {
        lights: LIGHTS,
        tree: TreeKind::Geometric,
        beta: 1.0,
        criterion,
        pilot_clusters: 1,
        max_vertices: None,
        ..Default::default()
    };
    Dataset {
        indirect: None,
        meshless: None,
        object_bases: None,
        wavelet: None,
        two_sided: vec![false; mesh.triangles.len()],
        vertex_valid: vec![true; mesh.positions.len()],
        scene: Scene {
            mesh,
            materials: vec![Material {
                model: BrdfModel::Lambert,
                parameters: parameters.into(),
                ..Default::default()
            }],
            objects: vec![Object { name: "test".into() }],
            ..Default::default()
        },
        tree,
        cuts,
        settings,
        scene_hash: String::new(),
        report: BakeReport::default(),
    }
}

pub(crate) fn white() -> GgxParameters {
    GgxParameters { base_color: Vec3::ONE, ..Default::default() }
}

pub(crate) fn glossy(roughness: f32) -> GgxParameters {
    GgxParameters { base_color: Vec3::ZERO, roughness, ..Default::default() }
}

pub(crate) fn illumination(size: [u32; 2], f: impl FnMut(u32, u32) -> Vec3) -> Illumination {
    let environment = Environment::new("test".into(), Image::from_fn(size, f));
    Illumination { environment: environment.into(), rotation: 0.0, intensity: 1.0, sun: None }
}

pub(crate) fn from_above(size: u32) -> View {
    // Over the inner part of the floor; a slight tilt fixes which way is up in the picture.
    let camera = Camera::look_at(Vec3::new(0.0, 6.0, 0.01), Vec3::ZERO, 30.0);
    View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [size, size]) }
}

pub(crate) fn from_the_side(size: u32) -> View {
    let camera = Camera::look_at(Vec3::new(0.0, 1.5, 3.5), Vec3::ZERO, 30.0);
    View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [size, size]) }
}

pub(crate) fn rel_rmse(test: &Image, reference: &Image) -> f64 {
    compare(test, reference).unwrap().rel_rmse
}

pub(crate) fn light(emission: Emission, position: Vec3, target: Vec3, intensity: f32) -> Light {
    Light { emission, position, target, intensity: Vec3::splat(intensity), ..Default::default() }
}

pub(crate) fn mean(image: &Image) -> f32 {
    image.pixels.iter().map(|p| p.x).sum::<f32>() / image.pixels.len() as f32
}

/// The surface at the center of a view.
pub(crate) fn surface_at(renderer: &Renderer, view: &View) -> SurfacePoint {
    let direction = view.camera.direction_through(0.5 * Vec2::new(view.size[0] as f32, view.size[1] as f32), view.size);
    match Surfaces::of(renderer).seen_along(view.camera.eye, direction) {
        FirstHit::Surface(point) => *point,
        _ => panic!("the view looks at a surface"),
    }
}

/// Adds a parallelogram; the normal is the cross product of its edges.
fn add_quad(mesh: &mut Mesh, corner: Vec3, u: Vec3, v: Vec3) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([corner, corner + u, corner + u + v, corner + v]);
    mesh.normals.extend([u.cross(v).normalize(); 4]);
    mesh.tangents.extend([u.normalize().extend(1.0); 4]);
    mesh.uvs.extend([Vec2::ZERO; 4]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.triangle_material.extend([0; 2]);
    mesh.triangle_object.extend([0; 2]);
}

/// A floor over x in [0, 2] and z in [-1, 1], and a wall of height 1 over its edge at x = 0.
pub(crate) fn plates() -> Mesh {
    let mut mesh = Mesh::default();
    add_quad(&mut mesh, Vec3::new(0.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X);
    add_quad(&mut mesh, Vec3::new(0.0, 0.0, -1.0), Vec3::Y, 2.0 * Vec3::Z);
    mesh
}

/// A unit sphere seen from inside, of `rows` from pole to pole.
pub(crate) fn sphere(rows: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let columns = 2 * rows;
    for (row, column) in (0..=rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let (theta, phi) = (PI * row as f32 / rows as f32, 2.0 * PI * column as f32 / columns as f32);
        let p = Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos());
        mesh.positions.push(p);
        mesh.normals.push(-p);
        mesh.tangents.push(Vec4::new(phi.cos(), 0.0, -phi.sin(), 1.0));
        mesh.uvs.push(Vec2::ZERO);
    }
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let at = |r: u32, c: u32| r * columns + c % columns;
        let [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        if row + 1 < rows {
            mesh.triangles.push([a, c, b]);
        }
        if row > 0 {
            mesh.triangles.push([a, d, c]);
        }
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh.triangle_object = vec![0; mesh.triangles.len()];
    mesh
}

/// Irradiance under a polygon of unit radiance that lies above the horizon (Lambert 1760).
pub(crate) fn polygon_irradiance(corners: &[Vec3], point: Vec3, normal: Vec3) -> f64 {
    let edge = |a: Vec3, b: Vec3| {
        let (a, b) = ((a - point).normalize().as_dvec3(), (b - point).normalize().as_dvec3());
        let across = a.cross(b).try_normalize();
        across.map_or(0.0, |n| a.dot(b).clamp(-1.0, 1.0).acos() * n.dot(normal.as_dvec3()))
    };
    let around = (0..corners.len()).map(|i| edge(corners[i], corners[(i + 1) % corners.len()])).sum::<f64>();
    (0.5 * around).abs()
}

pub(crate) fn point_light(position: Vec3, intensity: f32) -> Light {
    light(Emission::Point, position, Vec3::ZERO, intensity)
}

/// A floor and a wall beside it with sources; all nodes in the cuts of the floor's vertices are `depth` below the root.
pub(crate) fn floor_and_wall(depth: u32) -> Dataset {
    let mut mesh = mesh(32, false);
    add_wall(&mut mesh);
    let wall = (mesh.triangles.len() - 2) as u32;
    let mut dataset = dataset(mesh, white());
    let parameters = GgxParameters { base_color: Vec3::new(0.6, 0.3, 0.1), ..Default::default() };
    dataset.scene.materials.push(Material {
        model: BrdfModel::Lambert,
        parameters: parameters.into(),
        ..Default::default()
    });
    let sources = wall_sources(wall);
    let environment_cuts = environment_cuts(&dataset, &sources);
    let cuts = source_cuts(&dataset, &sources, depth);
    dataset.indirect = Some(IndirectBake { sources, cuts, environment_cuts });
    dataset
}

fn add_wall(mesh: &mut Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(WALL);
    mesh.normals.extend([Vec3::X; 4]);
    mesh.tangents.extend([Vec4::new(0.0, 0.0, -1.0, 1.0); 4]);
    mesh.uvs.extend([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.triangle_material.extend([1, 1]);
    mesh.triangle_object.extend([0, 0]);
}

/// A grid over the wall in Morton order, so that nodes are squares and oblongs.
fn wall_sources(triangle: u32) -> Vec<Source> {
    let coordinate = |code: u32| (0..SIDE_LOG2).fold(0, |c, bit| c | (code >> (2 * bit) & 1) << bit);
    let cell = 2.0 / (1 << SIDE_LOG2) as f32;
    let source = |i: u32| {
        let at = |code: u32| cell * (coordinate(code) as f32 + 0.5);
        let position = WALL[0] + Vec3::new(0.0, at(i), -at(i >> 1));
        let place = MeshPlace { triangle, barycentric: Vec2::splat(1.0 / 3.0) };
        Source { surfel: Surfel { position, normal: Vec3::X, place }, area: cell * cell, spacing: cell }
    };
    (0..SOURCES as u32).map(source).collect()
}

fn environment_cuts(dataset: &Dataset, sources: &[Source]) -> PackedCuts {
    let criterion = CutCriterion { sigma: 0.0, ..Default::default() };
    let mut selector = CutSelector::new(dataset.tree.height(), criterion);
    let mut cuts = PackedCuts::default();
    for source in sources {
        let above = |d: &Vec3| OPEN * u8::from(d.dot(source.surfel.normal) > 0.0);
        let visible: Vec<u8> = dataset.tree.leaf_directions().iter().map(above).collect();
        let mut cut = Vec::new();
        selector.select(&visible, &mut cut);
        let offset = cuts.push_cut(&cut);
        cuts.push_vertex(offset);
    }
    cuts
}

/// Solid angle of a source, without occlusion.
pub(crate) fn seen(source: &Source, from: Vec3) -> f32 {
    let away = from - source.surfel.position;
    source.area * away.dot(source.surfel.normal).max(0.0) / away.length().powi(3)
}

fn source_cuts(dataset: &Dataset, sources: &[Source], depth: u32) -> PackedCuts {
    let mut cuts = PackedCuts::default();
    let mesh = &dataset.scene.mesh;
    for (&p, n) in mesh.positions.iter().zip(&mesh.normals) {
        let value = |part: &[Source]| part.iter().map(|s| seen(s, p)).sum::<f32>() / part.len() as f32;
        let node = |part: &[Source]| pack_node(depth, 0.0) | solid_angle_code(value(part));
        let floor = *n == Vec3::Y;
        let cut: Vec<u16> = match floor {
            true => sources.chunks(SOURCES >> depth).map(node).collect(),
            false => vec![pack_node(0, 0.0)],
        };
        let offset = cuts.push_cut(&cut);
        cuts.push_vertex(offset);
    }
    cuts
}

/// A function on the wall, which sends, and one on the floor, which receives, each wide enough for the whole surface.
pub(crate) fn linked_floor_and_wall() -> Dataset {
    linked(Vec3::Y, LINK)
}

/// The linked floor and wall, with the floor's function on the side of `normal`.
pub(crate) fn linked(normal: Vec3, link: Vec3) -> Dataset {
    let mut dataset = floor_and_wall(4);
    let sources = &dataset.indirect.as_ref().unwrap().sources;
    let on_wall = sources[sources.len() / 2].surfel;
    let place = MeshPlace { triangle: 0, barycentric: Vec2::splat(0.3) };
    let on_floor = Surfel { position: Vec3::ZERO, normal, place };
    let basis = Basis::new(&[vec![on_wall, on_floor]], 20.0, 1).unwrap();
    let transport = Transport::from_rows(&[Vec::new(), vec![(0, link)]], 2);
    dataset.meshless = Some(MeshlessBake { basis, transport }.into());
    dataset
}

impl Renderer {
    /// Renders the environment alone, with an illumination cut of at most `illum_cut` nodes, in one step.
    pub(crate) fn render(
        &self,
        view: &View,
        light: &Illumination,
        illum_cut: u32,
        sampling: BrdfSampling,
    ) -> (Image, RenderStats) {
        drop(self.rig());
        let start = Instant::now();
        let lighting = self.lighting(light, illum_cut);
        let (image, stats) = self.render_lit(view, light, &lighting, sampling);
        (image, RenderStats { seconds: start.elapsed().as_secs_f64(), ..stats })
    }

    /// Renders under prepared light; `light` is only the background.
    pub(crate) fn render_lit(
        &self,
        view: &View,
        light: &Illumination,
        lighting: &SceneLighting,
        sampling: BrdfSampling,
    ) -> (Image, RenderStats) {
        let start = Instant::now();
        let backdrop = Backdrop::new(view, Some(light), true, &mut BlurCache::default());
        let sampler = PixelSampler::new(self, view, &backdrop);
        let mirrored = SeenScene::in_mirrors(self, view, sampling, &backdrop);
        let light = PictureLight { environment: Some(lighting), mirrored, ..Default::default() };
        let painter = || Painter::new(view, &self.dataset, light, sampling);
        let mut picture = Picture::new(view.size, light.parts(view.mode), None);
        for sample in 0..view.aa.max(1) {
            picture.add_rows(&sampler, painter, None, sample, 0..view.size[1]);
        }
        let PictureStats { pixels_shaded, mean_merged_nodes, mean_brdf_evaluations, .. } = picture.stats();
        let seconds = start.elapsed().as_secs_f64();
        let stats = RenderStats {
            tier: Tier::Cuts,
            backend: "cpu".into(),
            adapter: None,
            seconds,
            pixels_shaded,
            mean_merged_nodes,
            mean_brdf_evaluations,
        };
        (picture.read().0, stats)
    }
}
