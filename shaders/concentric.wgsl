// The square as a disc (Shirley and Chiu 1997). Twin of core/src/sphere/concentric.rs.

const QUARTER_TURN_HALF: f32 = 0.785398163;

// Maps the square from -1 to 1 to the unit disc.
fn concentric(square: vec2<f32>) -> vec2<f32> {
    var radius = square.y;
    var angle = 2.0 * QUARTER_TURN_HALF;
    if abs(square.x) > abs(square.y) {
        radius = square.x;
        angle = QUARTER_TURN_HALF * (square.y / square.x);
    } else if square.y != 0.0 {
        angle = 2.0 * QUARTER_TURN_HALF - QUARTER_TURN_HALF * (square.x / square.y);
    }
    return radius * vec2(cos(angle), sin(angle));
}

// Maps the unit disc to the square from -1 to 1.
fn square_from_disc(disc: vec2<f32>) -> vec2<f32> {
    let lengths = abs(disc);
    let along = max(lengths.x, lengths.y);
    let across = min(lengths.x, lengths.y);
    let radius = length(disc);
    let turn = select(0.0, radius * atan(across / along) / QUARTER_TURN_HALF, along > 0.0);
    let square = select(vec2(turn, radius), vec2(radius, turn), lengths.x >= lengths.y);
    return select(square, -square, disc < vec2(0.0));
}
