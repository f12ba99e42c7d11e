//! Smooth curves through a few chosen points.

use glam::Vec2;

/// Catmull-Rom curve through `points` with `per_span` steps between neighbors; both ends are kept.
pub fn through(points: &[Vec2], per_span: usize) -> Vec<Vec2> {
    let last = points.len() - 1;
    let mut curve = Vec::with_capacity(last * per_span + 1);
    for i in 0..last {
        // Mirrored end points keep the end tangents along the end spans.
        let before = if i == 0 { 2.0 * points[0] - points[1] } else { points[i - 1] };
        let after = if i + 1 == last { 2.0 * points[last] - points[last - 1] } else { points[i + 2] };
        let span = [before, points[i], points[i + 1], after];
        curve.extend((0..per_span).map(|k| catmull_rom(span, k as f32 / per_span as f32)));
    }
    curve.push(points[last]);
    curve
}

/// Centripetal Catmull-Rom (Barry and Goldman 1988): no loops or overshoot where points are unevenly spaced.
fn catmull_rom(p: [Vec2; 4], t: f32) -> Vec2 {
    let mut knots = [0.0; 4];
    for i in 0..3 {
        knots[i + 1] = knots[i] + p[i].distance(p[i + 1]).sqrt().max(1e-6);
    }
    let at = knots[1] + t * (knots[2] - knots[1]);
    let blend = |a: Vec2, b: Vec2, from: f32, to: f32| a.lerp(b, (at - from) / (to - from));
    let a1 = blend(p[0], p[1], knots[0], knots[1]);
    let a2 = blend(p[1], p[2], knots[1], knots[2]);
    let a3 = blend(p[2], p[3], knots[2], knots[3]);
    let b1 = blend(a1, a2, knots[0], knots[2]);
    let b2 = blend(a2, a3, knots[1], knots[3]);
    blend(b1, b2, knots[1], knots[2])
}

/// Points of a circular arc around `centre` from angle `from` to `to` (radians), both ends kept.
pub fn arc(centre: Vec2, radius: f32, from: f32, to: f32, steps: usize) -> Vec<Vec2> {
    let angle = |k: usize| from + (to - from) * k as f32 / steps as f32;
    (0..=steps).map(|k| centre + radius * Vec2::from_angle(angle(k))).collect()
}

/// Evenly spaced points on a straight line, both ends kept.
pub fn line(from: Vec2, to: Vec2, steps: usize) -> Vec<Vec2> {
    (0..=steps).map(|k| from.lerp(to, k as f32 / steps as f32)).collect()
}
