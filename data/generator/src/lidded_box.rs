//! A wooden box and its loose lid, each one closed surface.
//!
//! Both are a rounded box whose top surface is replaced by a step: inward and down to a floor or, for the lid, which is
//! made upside down, up to a panel that fits into the box and blocks light.

use glam::{Affine3A, Mat3, Vec2, Vec3, vec2, vec3};

use crate::mesh::Mesh;
use crate::noise::lerp;
use crate::rounded_box::{even_lines, rounded_box, steps_across};

/// Outer width, height and depth of the box without its lid, and the thickness of its walls and its floor.
const OUTSIDE: Vec3 = vec3(0.56, 0.26, 0.36);
const WALL: f32 = 0.018;
/// Overhang of the lid on each side, its thickness, and the depth of its panel in the box.
const OVERHANG: f32 = 0.010;
const LID: f32 = 0.026;
const PANEL: f32 = 0.014;
/// Gap between the lid and the rim, and between its panel and the walls: the surfaces never touch, and no light enters.
const GAP: f32 = 0.0005;
const PLAY: f32 = 0.0015;
/// Radius of edges, and the largest cell size of flats.
const EDGE: f32 = 0.003;
const CELL: f32 = 0.08;

/// The lid's origin in the box's frame: on its hinge line.
pub const HINGE: Vec3 = vec3(0.0, OUTSIDE.y + GAP, -0.5 * OUTSIDE.z - OVERHANG);

/// The box without its lid: floor and four walls. It stands on `y = 0` around the origin, its front to +Z.
pub fn open_box() -> Mesh {
    let (top, floor, quarter) = (0.5 * OUTSIDE.y, WALL - 0.5 * OUTSIDE.y, vec2(-1.0, 1.0));
    let corner = vec2(WALL - EDGE, top - EDGE);
    let rim = [
        Section::new(vec2(EDGE, top), Vec2::Y),
        Section::new(corner.with_y(top), Vec2::Y),
        Section::new(corner + EDGE * vec2(1.0, 1.0).normalize(), quarter),
        Section::new(vec2(WALL, corner.y), Vec2::NEG_X),
    ];
    let rows = steps_across(0.5 * (corner.y - floor), CELL);
    let wall = |k: usize| Section::new(vec2(WALL, lerp(corner.y, floor, k as f32 / rows as f32)), Vec2::NEG_X);
    let inside: Vec<Section> = rim.into_iter().chain((1..=rows).map(wall)).collect();
    stepped(OUTSIDE, &[inside]).shifted(Vec3::Y * top)
}

/// The lid: a slab with a panel below. Its origin is the [`HINGE`], its underside lies at `y = 0`, its front to +Z.
pub fn lid() -> Mesh {
    let size = vec3(OUTSIDE.x + 2.0 * OVERHANG, LID, OUTSIDE.z + 2.0 * OVERHANG);
    let (under, step) = (0.5 * LID, OVERHANG + WALL + PLAY);
    let corner = vec2(step + EDGE, under + PANEL - EDGE);
    let underside = vec![Section::new(vec2(EDGE, under), Vec2::Y), Section::new(vec2(step, under), Vec2::Y)];
    let panel = vec![
        Section::new(vec2(step, under), Vec2::X),
        Section::new(vec2(step, corner.y), Vec2::X),
        Section::new(corner + EDGE * vec2(-1.0, 1.0).normalize(), Vec2::ONE),
        Section::new(vec2(corner.x, under + PANEL), Vec2::Y),
    ];
    let turned_over = Affine3A::from_mat3(Mat3::from_diagonal(vec3(1.0, -1.0, -1.0)));
    stepped(size, &[underside, panel]).moved(turned_over).shifted(vec3(0.0, under, 0.5 * size.z))
}

/// A point of the step's section, the same on all four sides.
#[derive(Clone, Copy)]
struct Section {
    /// Meters inward from the side, and height above the center.
    at: Vec2,
    /// Unit normal: outward and up.
    normal: Vec2,
}

impl Section {
    fn new(at: Vec2, normal: Vec2) -> Section {
        Section { at, normal: normal.normalize() }
    }
}

/// A rounded box around the origin whose top surface is replaced by a step along `runs`, mitered in its corners and
/// closed by a flat at their end. Runs are smooth and meet in creases.
fn stepped(size: Vec3, runs: &[Vec<Section>]) -> Mesh {
    let mut mesh = rounded_box(size, EDGE, CELL).without_flat(Vec3::Y);
    let half = 0.5 * size;
    let steps = [half.x, half.z].map(|half| steps_across(half - EDGE, CELL));
    for run in runs {
        for side in 0..4 {
            push_side(&mut mesh, half, steps, side, run);
        }
    }
    if let Some(end) = runs.last().and_then(|run| run.last()) {
        push_flat(&mut mesh, half, steps, end.at);
    }
    mesh
}

/// The step of one side, from outside inward.
fn push_side(mesh: &mut Mesh, half: Vec3, steps: [usize; 2], side: usize, run: &[Section]) {
    let out = [Vec3::Z, Vec3::X, Vec3::NEG_Z, Vec3::NEG_X][side];
    let right = Vec3::Y.cross(out);
    let [length, depth] = [right, out].map(|axis| half.dot(axis.abs()));
    let mut travelled = 0.0;
    let mut outer: Option<(Vec2, Vec<u32>)> = None;
    for section in run {
        let Vec2 { x: inset, y: height } = section.at;
        travelled += outer.as_ref().map_or(0.0, |(at, _)| at.distance(section.at));
        let normal = out * section.normal.x + Vec3::Y * section.normal.y;
        let row: Vec<u32> = even_lines(length - inset, steps[side % 2])
            .into_iter()
            .map(|x| mesh.push(right * x + out * (depth - inset) + Vec3::Y * height, normal, vec2(x, travelled)))
            .collect();
        if let Some((_, outer)) = &outer {
            stitch(mesh, outer, &row);
        }
        outer = Some((section.at, row));
    }
}

/// The flat that closes the step, seen from above.
fn push_flat(mesh: &mut Mesh, half: Vec3, steps: [usize; 2], at: Vec2) {
    let columns = even_lines(half.x - at.x, steps[0]);
    let rows: Vec<Vec<u32>> = even_lines(half.z - at.x, steps[1])
        .into_iter()
        .map(|z| columns.iter().map(|x| mesh.push(vec3(*x, at.y, -z), Vec3::Y, vec2(*x, -z))).collect())
        .collect();
    rows.windows(2).for_each(|pair| stitch(mesh, &pair[0], &pair[1]));
}

/// Joins two rows of vertices that run to the right, `near` below `far` in the picture.
fn stitch(mesh: &mut Mesh, near: &[u32], far: &[u32]) {
    for (a, b) in near.windows(2).zip(far.windows(2)) {
        mesh.quad(a[0], a[1], b[1], b[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3Swizzles;

    use crate::mesh::checks::{assert_closed, assert_sound, volume};

    /// Smallest and largest coordinates of the vertices for which `keep` holds.
    fn bounds(mesh: &Mesh, keep: impl Fn(Vec3) -> bool) -> [Vec3; 2] {
        let kept = || mesh.positions.iter().copied().filter(|p| keep(*p));
        [kept().fold(Vec3::INFINITY, Vec3::min), kept().fold(Vec3::NEG_INFINITY, Vec3::max)]
    }

    /// Whether `mesh` has a cavity: it takes less than half the volume of its outline.
    fn is_hollow(mesh: &Mesh) -> bool {
        let [low, high] = bounds(mesh, |_| true);
        volume(mesh) < 0.5 * (high - low).element_product()
    }

    /// Whether `outer` contains `inner` seen from above.
    fn covers(outer: [Vec3; 2], inner: [Vec3; 2]) -> bool {
        outer[0].xz().cmple(inner[0].xz()).all() && outer[1].xz().cmpge(inner[1].xz()).all()
    }

    #[test]
    fn both_are_closed() {
        for mesh in [open_box(), lid()] {
            assert_sound(&mesh);
            assert_closed(&mesh);
        }
    }

    #[test]
    fn the_box_is_hollow() {
        let mesh = open_box();
        let cavity = (OUTSIDE - vec3(2.0 * WALL, WALL, 2.0 * WALL)).element_product();
        let wood = OUTSIDE.element_product() - cavity;
        assert!((volume(&mesh) / wood - 1.0).abs() < 0.02, "{} for {wood}", volume(&mesh));
        assert!(is_hollow(&mesh) && !is_hollow(&rounded_box(OUTSIDE, EDGE, CELL)));
    }

    #[test]
    fn the_lid_covers_the_box_and_its_panel_fits() {
        let (open_box, lid) = (open_box(), lid().shifted(HINGE));
        let (walls, slab) = (bounds(&open_box, |_| true), bounds(&lid, |p| p.y > OUTSIDE.y));
        assert!(covers(slab, walls) && !covers(walls, slab));
        let gap = slab[0].y - walls[1].y;
        assert!(gap > 0.0 && gap < 1e-3, "{gap}");
        let (cavity, panel) = (OUTSIDE.with_y(0.0) * 0.5 - WALL, bounds(&lid, |p| p.y < OUTSIDE.y));
        assert!(covers([-cavity, cavity], panel) && panel[0].y < OUTSIDE.y - 0.01);
        assert!(!covers([-cavity, cavity], panel.map(|p| p * 1.02)), "the panel is loose");
    }
}
