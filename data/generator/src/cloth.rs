//! A square of linen, dropped over a block and the floor until it rests: the folds are computed, not drawn.
//!
//! Extended position-based dynamics (Macklin et al. 2016) with one iteration per small step ("Small Steps in Physics Simulation",
//! Macklin et al. 2019). Constraints are solved in a fixed order on one thread, so every run gives the same result.

use std::collections::HashMap;

use glam::{Quat, Vec2, Vec3, vec3};

use crate::mesh::Mesh;
use crate::noise;

/// The cloth, its support, and the duration of the fall.
#[derive(Clone, Copy, Debug)]
pub struct Drape {
    /// Vertices along each side.
    pub resolution: usize,
    /// Side of the square in meters.
    pub side: f32,
    /// Turn of the square around Y against the block, radians.
    pub turn: f32,
    /// Initial position of its center, above the block.
    pub centre: Vec3,
    /// Size of the block below; it stands on `y = 0` around the origin.
    pub block: Vec3,
    /// How far the cloth is gathered before it falls: 1 is flat, 0.9 pushes a tenth of its width into folds.
    pub gather: f32,
    /// Radius on top of the block that a heavy object will press flat.
    pub weight_radius: f32,
    /// Simulated time, seconds.
    pub seconds: f32,
}

/// Length of a step in seconds. Shorter steps stretch less.
const STEP: f32 = 1.0 / 600.0;
/// Steps between searches for particles that may touch.
const SEARCH_EVERY: usize = 10;
/// Distance that the cloth keeps from floor and block, meters.
pub const CLEARANCE: f32 = 0.003;
/// Radius of the block's edges for collision.
const BLOCK_ROUND: f32 = 0.012;
/// Coulomb friction against floor and block.
const FRICTION: f32 = 0.55;
/// Velocity kept per second in air.
const AIR_DRAG: f32 = 0.25;

struct Link {
    a: usize,
    b: usize,
    rest: f32,
    /// Inverse stiffness, m/N; zero does not stretch.
    compliance: f32,
}

struct Cloth {
    drape: Drape,
    spacing: f32,
    position: Vec<Vec3>,
    previous: Vec<Vec3>,
    links: Vec<Link>,
    near: Vec<(usize, usize)>,
}

/// Simulates the drape and returns the resting cloth as an open sheet; the block stands around the origin.
pub fn drape(drape: &Drape) -> Mesh {
    let mut cloth = Cloth::new(*drape);
    let steps = (drape.seconds / STEP) as usize;
    for step in 0..steps {
        if step % SEARCH_EVERY == 0 {
            cloth.find_near();
        }
        // The last quarter is overdamped, so that the cloth rests and does not sway.
        cloth.press(step as f32 / steps as f32);
        cloth.step(if 4 * step > 3 * steps { 0.97 } else { AIR_DRAG.powf(STEP) });
    }
    cloth.relax();
    cloth.mesh()
}

impl Cloth {
    fn new(drape: Drape) -> Cloth {
        let n = drape.resolution;
        let spacing = drape.side / (n - 1) as f32;
        let turn = Quat::from_rotation_y(drape.turn);
        let place = |i: usize| {
            let (x, z) = ((i % n) as f32 / (n - 1) as f32, (i / n) as f32 / (n - 1) as f32);
            let flat = vec3(x - 0.5, 0.0, z - 0.5) * drape.side * drape.gather;
            // A slightly wavy start determines the folds; a perfect plane would fall in perfect symmetry.
            let wave = 0.025 * noise::fractal(Vec2::new(x, z), (4, 4), 2, 11);
            drape.centre + turn * flat + Vec3::Y * wave
        };
        let position: Vec<Vec3> = (0..n * n).map(place).collect();
        let links = links(n, spacing);
        Cloth { drape, spacing, previous: position.clone(), position, links, near: Vec::new() }
    }

    /// Presses the parts below the weight onto the block, over the second half of the time.
    fn press(&mut self, progress: f32) {
        let top = self.drape.block.y + CLEARANCE;
        let lid = top + 0.06 * (1.6 - 2.0 * progress).max(0.0);
        for p in &mut self.position {
            if progress > 0.5 && p.y > lid && p.x.hypot(p.z) < self.drape.weight_radius {
                p.y = lid;
            }
        }
    }

    fn step(&mut self, keep: f32) {
        let fall = Vec3::NEG_Y * (9.81 * STEP * STEP);
        for (p, before) in self.position.iter_mut().zip(&mut self.previous) {
            // Speed limit of half a spacing per step: nothing tunnels through a neighbor.
            let moved = ((*p - *before) * keep + fall).clamp_length_max(0.4 * self.spacing);
            *before = *p;
            *p += moved;
        }
        self.solve_links();
        self.solve_near();
        self.solve_contacts();
    }

    fn solve_links(&mut self) {
        for link in &self.links {
            let apart = self.position[link.b] - self.position[link.a];
            let length = apart.length();
            // Particles have unit mass, so the compliance includes the mass.
            let move_by = (length - link.rest) / (2.0 + link.compliance / (STEP * STEP));
            let push = apart * (move_by / length.max(1e-9));
            self.position[link.a] += push;
            self.position[link.b] -= push;
        }
    }

    fn solve_near(&mut self) {
        let thickness = 0.95 * self.spacing;
        for pair in 0..self.near.len() {
            let (a, b) = self.near[pair];
            let apart = self.position[b] - self.position[a];
            let length = apart.length();
            if length < thickness && length > 0.0 {
                let push = apart * (0.5 * (thickness - length) / length);
                self.position[a] -= push;
                self.position[b] += push;
                self.rub(a, b);
            }
        }
    }

    /// Cloth on cloth loses a part of its relative motion.
    fn rub(&mut self, a: usize, b: usize) {
        let moved_a = self.position[a] - self.previous[a];
        let moved_b = self.position[b] - self.previous[b];
        let difference = 0.1 * (moved_a - moved_b);
        self.position[a] -= difference;
        self.position[b] += difference;
    }

    fn solve_contacts(&mut self) {
        for (p, before) in self.position.iter_mut().zip(&self.previous) {
            if p.y < CLEARANCE {
                *p = pushed_out(*p, *before, Vec3::Y, CLEARANCE - p.y);
            }
            let (depth, normal) = depth_in_block(*p, self.drape.block);
            if depth > 0.0 {
                *p = pushed_out(*p, *before, normal, depth);
            }
        }
    }

    /// Lists the pairs that could touch before the next search.
    fn find_near(&mut self) {
        let reach = 2.0 * self.spacing;
        let cell = |p: Vec3| (p / reach).floor().as_ivec3().to_array();
        let mut grid: HashMap<[i32; 3], Vec<usize>> = HashMap::new();
        for (i, p) in self.position.iter().enumerate() {
            grid.entry(cell(*p)).or_default().push(i);
        }
        let mut near = Vec::new();
        for i in 0..self.position.len() {
            let [x, y, z] = cell(self.position[i]);
            for k in 0..27 {
                let key = [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1];
                let others = grid.get(&key).map_or(&[][..], Vec::as_slice);
                let touching = others.iter().filter(|j| self.may_touch(i, **j, reach));
                near.extend(touching.map(|j| (i, *j)));
            }
        }
        self.near = near;
    }

    /// Pairs once, without neighbors in the weave: links keep those apart.
    fn may_touch(&self, i: usize, j: usize, reach: f32) -> bool {
        let n = self.drape.resolution;
        let apart = (i % n).abs_diff(j % n).max((i / n).abs_diff(j / n));
        i < j && apart > 1 && self.position[i].distance_squared(self.position[j]) < reach * reach
    }

    /// Smooths the particle scale away, then restores clearance.
    fn relax(&mut self) {
        let n = self.drape.resolution;
        for _ in 0..2 {
            let old = self.position.clone();
            for (i, p) in self.position.iter_mut().enumerate() {
                let (x, z) = (i % n, i / n);
                if x > 0 && z > 0 && x + 1 < n && z + 1 < n {
                    let mean = (old[i - 1] + old[i + 1] + old[i - n] + old[i + n]) * 0.25;
                    *p = p.lerp(mean, 0.5);
                }
            }
        }
        self.previous.clone_from(&self.position);
        self.solve_contacts();
    }

    fn mesh(&self) -> Mesh {
        let n = self.drape.resolution;
        let mut mesh = Mesh::default();
        for (i, p) in self.position.iter().enumerate() {
            let uv = Vec2::new((i % n) as f32, (i / n) as f32) / (n - 1) as f32;
            mesh.push(*p, Vec3::Y, uv);
        }
        for i in 0..n * n - n {
            if i % n + 1 < n {
                let i = i as u32;
                let n = n as u32;
                mesh.quad(i, i + n, i + n + 1, i + 1);
            }
        }
        mesh.smooth_normals();
        mesh
    }
}

/// Threads, diagonals and bending links of an `n` by `n` weave.
fn links(n: usize, spacing: f32) -> Vec<Link> {
    // (columns, rows, compliance): linen hardly stretches along the thread, yields on the bias, bends softly.
    let kinds: [(isize, isize, f32); 8] =
        [(1, 0, 0.0), (0, 1, 0.0), (1, 1, 2e-6), (-1, 1, 2e-6), (2, 0, 8e-5), (0, 2, 8e-5), (4, 0, 1e-3), (0, 4, 1e-3)];
    let mut links = Vec::new();
    for (dx, dz, compliance) in kinds {
        let rest = spacing * ((dx * dx + dz * dz) as f32).sqrt();
        for i in 0..n * n {
            let (x, z) = ((i % n) as isize + dx, (i / n) as isize + dz);
            if x >= 0 && (x as usize) < n && (z as usize) < n {
                links.push(Link { a: i, b: z as usize * n + x as usize, rest, compliance });
            }
        }
    }
    links
}

/// Depth below the clearance around the rounded block, and the way out.
fn depth_in_block(p: Vec3, block: Vec3) -> (f32, Vec3) {
    let local = p - Vec3::Y * (0.5 * block.y);
    let core = 0.5 * block - BLOCK_ROUND;
    let nearest = local.clamp(-core, core);
    let away = local - nearest;
    let distance = away.length();
    if distance > 0.0 {
        return (BLOCK_ROUND + CLEARANCE - distance, away / distance);
    }
    // Inside the core (only for a fast particle): out through the top.
    (core.y - local.y + BLOCK_ROUND + CLEARANCE, Vec3::Y)
}

/// Moves a point out of a solid and removes sliding up to the friction cone.
fn pushed_out(p: Vec3, before: Vec3, normal: Vec3, depth: f32) -> Vec3 {
    let out = p + normal * depth;
    let slid = (out - before).reject_from_normalized(normal);
    out - slid.clamp_length_max(FRICTION * depth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::assert_sound;

    fn small() -> Drape {
        Drape {
            resolution: 24,
            side: 0.8,
            turn: 0.7,
            centre: vec3(0.0, 0.3, 0.0),
            block: vec3(0.3, 0.2, 0.3),
            gather: 0.95,
            weight_radius: 0.05,
            seconds: 1.0,
        }
    }

    #[test]
    fn the_cloth_rests_on_block_and_floor() {
        let cloth = drape(&small());
        assert_sound(&cloth);
        assert!(cloth.lowest() > 0.5 * CLEARANCE);
        let deepest = cloth.positions.iter().map(|p| depth_in_block(*p, small().block).0).fold(0.0, f32::max);
        assert!(deepest < 1e-4, "{deepest}");
        assert!(cloth.positions.iter().any(|p| p.y > 0.2), "the cloth slid off");
    }

    #[test]
    fn the_drape_is_repeatable() {
        assert_eq!(drape(&small()), drape(&small()));
    }
}
