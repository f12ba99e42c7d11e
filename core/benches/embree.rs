//! Exhaustive bake rays against Embree: `cargo bench -p lapidary-core --bench embree -- FILE.cuts`.
//!
//! All lights above the horizon of some vertices are traced, by batches and by Embree's packets of 16, on one core.
//! Embree 3 is loaded from its installation (Debian: `libembree3-3`).

use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    light_tree::LightTree,
    mesh::Mesh,
    ray::{DirectionSet, HalfSpace, Intersector},
    texture::Texture,
};
use libloading::{Library, Symbol};
use std::{
    ffi::{c_char, c_void},
    path::Path,
    ptr::null,
    time::Instant,
};

const LIGHTS: usize = 32_768;
const VERTICES: usize = 400;
const ROUNDS: usize = 3;

fn main() {
    let Some(path) = std::env::args().skip(1).find(|argument| argument.ends_with(".cuts")) else {
        println!("skipped: name a dataset, `cargo bench -p lapidary-core --bench embree -- FILE.cuts`");
        return;
    };
    let dataset =
        Dataset::read(Path::new(&path), |_, path| Ok(Texture::missing(&path.to_string_lossy()))).expect("a dataset");
    let mesh = &dataset.scene.mesh;
    let Some(embree) = Embree::load(mesh) else {
        println!("skipped: libembree3.so.3 is not installed");
        return;
    };
    let tree = LightTree::geometric(LIGHTS).expect("a power of two");
    let directions = tree.leaf_directions();
    let (intersector, set) = (Intersector::new(mesh), DirectionSet::new(directions));
    let origins = origins(mesh, &dataset.vertex_valid);
    let (mut ours, mut theirs) = (vec![0_u8; LIGHTS], vec![0_u8; LIGHTS]);
    let (mut rays, mut differ) = (0, 0);
    for &(origin, half) in &origins {
        ours.fill(0);
        theirs.fill(0);
        rays += intersector.trace_batch(origin, &set, |_, d| half.has(d), &mut ours);
        embree.trace(origin, directions, &half, &mut theirs);
        differ += ours.iter().zip(&theirs).filter(|(a, b)| a != b).count();
    }
    for _ in 0..ROUNDS {
        let million = |trace: &mut dyn FnMut(Vec3, &HalfSpace)| {
            let start = Instant::now();
            origins.iter().for_each(|(origin, half)| trace(*origin, half));
            (origins.len() * LIGHTS) as f64 / start.elapsed().as_secs_f64() / 1e6
        };
        let batches = million(&mut |origin, half| {
            ours.fill(0);
            intersector.trace_batch(origin, &set, |_, d| half.has(d), &mut ours);
        });
        let packets = million(&mut |origin, half| embree.trace(origin, directions, half, &mut theirs));
        println!(
            "million pairs a second and core: batches {batches:.2}, Embree {packets:.2}, ratio {:.2}",
            batches / packets
        );
    }
    println!("{} vertices, {rays} rays, {differ} differ", origins.len());
}

/// Some vertices, slightly off the surface, and the half-spaces above their horizons.
fn origins(mesh: &Mesh, valid: &[bool]) -> Vec<(Vec3, HalfSpace)> {
    let lift = 1e-4 * mesh.bounds().diagonal();
    let step = (mesh.positions.len() / VERTICES).max(1);
    let vertices = (0..mesh.positions.len()).step_by(step).filter(|&v| valid[v]);
    let origin = |v: usize| {
        let normal = mesh.normals[v];
        (mesh.positions[v] + lift * normal, HalfSpace { normal, height: 0.0, is_above: true })
    };
    vertices.map(origin).collect()
}

/// A scene of Embree 3. It lives as long as the program.
struct Embree {
    library: Library,
    scene: *mut c_void,
}

/// `RTCRay16`.
#[repr(C, align(64))]
struct Rays {
    origin: [[f32; 16]; 3],
    near: [f32; 16],
    direction: [[f32; 16]; 3],
    time: [f32; 16],
    far: [f32; 16],
    mask: [u32; 16],
    id: [u32; 16],
    flags: [u32; 16],
}

/// `RTCIntersectContext`, with padding.
#[repr(C)]
struct Context {
    flags: u32,
    filter: *const c_void,
    instance: u32,
    room: [u32; 8],
}

/// `RTC_INTERSECT_CONTEXT_FLAG_COHERENT`.
const COHERENT: u32 = 1;
/// `RTC_INVALID_GEOMETRY_ID`.
const INVALID: u32 = u32::MAX;

impl Embree {
    /// `None` if the library is missing.
    fn load(mesh: &Mesh) -> Option<Self> {
        // SAFETY: types and constants are from Embree 3's headers. Buffers are leaked, so they outlive the scene; the
        // last position has the padding that Embree requires.
        unsafe {
            let library = Library::new("libembree3.so.3").ok()?;
            let new_device: Symbol<unsafe extern "C" fn(*const c_char) -> *mut c_void> =
                library.get(b"rtcNewDevice").ok()?;
            let new_scene: Symbol<unsafe extern "C" fn(*mut c_void) -> *mut c_void> =
                library.get(b"rtcNewScene").ok()?;
            let new_geometry: Symbol<unsafe extern "C" fn(*mut c_void, i32) -> *mut c_void> =
                library.get(b"rtcNewGeometry").ok()?;
            type SetBuffer = unsafe extern "C" fn(*mut c_void, i32, u32, i32, *const c_void, usize, usize, usize);
            let set_buffer: Symbol<SetBuffer> = library.get(b"rtcSetSharedGeometryBuffer").ok()?;
            let set_flags: Symbol<unsafe extern "C" fn(*mut c_void, i32)> = library.get(b"rtcSetSceneFlags").ok()?;
            let set_quality: Symbol<unsafe extern "C" fn(*mut c_void, i32)> =
                library.get(b"rtcSetSceneBuildQuality").ok()?;
            let commit_geometry: Symbol<unsafe extern "C" fn(*mut c_void)> = library.get(b"rtcCommitGeometry").ok()?;
            let attach: Symbol<unsafe extern "C" fn(*mut c_void, *mut c_void) -> u32> =
                library.get(b"rtcAttachGeometry").ok()?;
            let commit: Symbol<unsafe extern "C" fn(*mut c_void)> = library.get(b"rtcCommitScene").ok()?;
            let device = new_device(c"threads=1".as_ptr());
            let scene = new_scene(device);
            let geometry = new_geometry(device, 0);
            let positions = mesh.positions.iter().flat_map(|p| p.to_array()).chain([0.0]);
            let positions: &'static [f32] = positions.collect::<Vec<f32>>().leak();
            let triangles: &'static [[u32; 3]] = mesh.triangles.clone().leak();
            let (index, vertex, uint3, float3, robust, high) = (0, 1, 0x5003, 0x9003, 4, 2);
            set_buffer(geometry, index, 0, uint3, triangles.as_ptr().cast(), 0, 12, triangles.len());
            set_buffer(geometry, vertex, 0, float3, positions.as_ptr().cast(), 0, 12, mesh.positions.len());
            commit_geometry(geometry);
            attach(scene, geometry);
            set_flags(scene, robust);
            set_quality(scene, high);
            commit(scene);
            Some(Self { library, scene })
        }
    }

    /// Sets `visible` to 1 for unblocked directions of the half-space.
    fn trace(&self, origin: Vec3, directions: &[Vec3], half: &HalfSpace, visible: &mut [u8]) {
        type Occluded = unsafe extern "C" fn(*const i32, *mut c_void, *mut Context, *mut Rays);
        // SAFETY: the function has this type in Embree 3.
        let occluded: Symbol<Occluded> = unsafe { self.library.get(b"rtcOccluded16") }.expect("Embree 3");
        let mut context = Context { flags: COHERENT, filter: null(), instance: INVALID, room: [0; 8] };
        for (sixteen, seen) in directions.chunks_exact(16).zip(visible.chunks_exact_mut(16)) {
            let wanted: [i32; 16] = std::array::from_fn(|lane| if half.has(sixteen[lane]) { -1 } else { 0 });
            if wanted == [0; 16] {
                continue;
            }
            let mut rays = Rays {
                origin: origin.to_array().map(|x| [x; 16]),
                near: [0.0; 16],
                direction: [0, 1, 2].map(|axis| std::array::from_fn(|lane| sixteen[lane][axis])),
                time: [0.0; 16],
                far: [f32::INFINITY; 16],
                mask: [u32::MAX; 16],
                id: [0; 16],
                flags: [0; 16],
            };
            // SAFETY: all pointers are to values that live here; the scene was committed.
            unsafe { occluded(wanted.as_ptr(), self.scene, &mut context, &mut rays) };
            for ((seen, wanted), far) in seen.iter_mut().zip(wanted).zip(rays.far) {
                *seen = u8::from(wanted != 0 && far >= 0.0);
            }
        }
    }
}
