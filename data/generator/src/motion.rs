//! Motion in a scene: joints, a skin that follows them, a morph target, and clips.

use glam::{Quat, Vec3};

/// All motion of a scene.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Joints, parents first.
    pub joints: Vec<Joint>,
    /// The piece that follows them.
    pub skin: Skin,
    /// The piece that changes its shape.
    pub morph: Morph,
    /// Animations.
    pub clips: Vec<Clip>,
}

/// A joint without rotation at rest.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name shown to the artist.
    pub name: String,
    /// Its parent; none for the first joint.
    pub parent: Option<usize>,
    /// Position in the world in meters.
    pub position: Vec3,
}

/// A piece that follows joints.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Index of the piece.
    pub piece: usize,
    /// Four joints for each vertex.
    pub joints: Vec<[u16; 4]>,
    /// Their weights, which sum to 1.
    pub weights: Vec<[f32; 4]>,
}

/// A piece with one morph target.
#[derive(Clone, Debug, Default)]
pub struct Morph {
    /// Index of the piece.
    pub piece: usize,
    /// Offsets of positions, in meters.
    pub positions: Vec<Vec3>,
    /// Offsets of normals.
    pub normals: Vec<Vec3>,
}

/// A named animation.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Name shown to the artist.
    pub name: &'static str,
    /// Its channels.
    pub channels: Vec<Channel>,
}

/// Target of a channel.
#[derive(Clone, Copy, Debug)]
pub enum Moved {
    /// A joint by its index.
    Joint(usize),
    /// A placed piece by its index.
    Node(usize),
}

/// A property over time.
#[derive(Clone, Debug)]
pub struct Channel {
    /// The target.
    pub of: Moved,
    /// Property, as named in glTF.
    pub path: &'static str,
    /// Times of keyframes in seconds.
    pub times: Vec<f32>,
    /// Their values in sequence; for a spline, each between its tangents.
    pub values: Vec<f32>,
    /// Interpolation, as named in glTF.
    pub interpolation: &'static str,
}

/// Period of a swing in seconds.
pub const PERIOD: f32 = 2.0;

/// Times in seconds at which a swing is at its center or an end.
fn quarters() -> [f32; 5] {
    [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * PERIOD)
}

/// The sine of a swing at a time, and its slope per second.
fn swing(time: f32) -> (f32, f32) {
    let rate = std::f32::consts::TAU / PERIOD;
    // Exact values where the sine has them, so that the swing ends where it begins, to the bit.
    ((rate * time).sin().round(), rate * (rate * time).cos().round())
}

/// A joint that swings about Z by `degrees` to each side, on a spline.
pub fn swinging(joint: usize, degrees: f32) -> Channel {
    let mut values = Vec::new();
    for time in quarters() {
        let (sine, slope) = swing(time);
        let half = 0.5 * degrees.to_radians();
        let (sin, cos) = (half * sine).sin_cos();
        let tangent = [0.0, 0.0, cos * half * slope, -sin * half * slope];
        values.extend([tangent, [0.0, 0.0, sin, cos], tangent].concat());
    }
    Channel {
        of: Moved::Joint(joint),
        path: "rotation",
        times: quarters().into(),
        values,
        interpolation: "CUBICSPLINE",
    }
}

/// A morph target whose weight swings from 1 to -1.
pub fn waving(node: usize) -> Channel {
    let values = quarters().iter().map(|&time| swing(time).0).collect();
    Channel { of: Moved::Node(node), path: "weights", times: quarters().into(), values, interpolation: "LINEAR" }
}

/// A node that rotates once about the vertical.
pub fn turning(node: usize) -> Channel {
    let turn = |&time: &f32| Quat::from_rotation_y(std::f32::consts::TAU * time / PERIOD).to_array();
    let values = quarters().iter().flat_map(turn).collect();
    Channel { of: Moved::Node(node), path: "rotation", times: quarters().into(), values, interpolation: "LINEAR" }
}

/// A node that slides from `from` by `way` and back.
pub fn sliding(node: usize, from: Vec3, way: Vec3) -> Channel {
    let times = vec![0.0, 0.5 * PERIOD, PERIOD];
    let values = [from, from + way, from].iter().flat_map(Vec3::to_array).collect();
    Channel { of: Moved::Node(node), path: "translation", times, values, interpolation: "LINEAR" }
}
