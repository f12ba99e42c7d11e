//! Solid angles in the 12 bits of a packed node's value.

use std::sync::LazyLock;

/// Largest solid angle that a source can fill, in steradians: a hemisphere.
pub const LARGEST_SOLID_ANGLE: f32 = 2.0 * std::f32::consts::PI;
/// Range of the code in powers of two; smaller solid angles count as hidden.
const ORDERS: f32 = 30.0;
const CODES: f32 = 4094.0;

/// Codes a solid angle in 12 bits: 0 for none, else its logarithm in steps of half a percent.
pub fn solid_angle_code(steradians: f32) -> u16 {
    if !(steradians > LARGEST_SOLID_ANGLE * (-ORDERS).exp2()) {
        return 0;
    }
    let orders = (steradians / LARGEST_SOLID_ANGLE).min(1.0).log2() + ORDERS;
    1 + (orders * (CODES / ORDERS) + 0.5) as u16
}

/// The solid angle in steradians of a code.
#[inline(always)]
pub fn solid_angle(code: u16) -> f32 {
    if code == 0 { 0.0 } else { LARGEST_SOLID_ANGLE * (f32::from(code - 1) * (ORDERS / CODES) - ORDERS).exp2() }
}

/// The solid angles of all codes: a table is faster than a power.
pub fn solid_angles() -> &'static [f32; 4096] {
    static SOLID_ANGLES: LazyLock<[f32; 4096]> = LazyLock::new(|| std::array::from_fn(|code| solid_angle(code as u16)));
    &SOLID_ANGLES
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angles_keep_half_a_percent() {
        assert_eq!((solid_angle_code(0.0), solid_angle_code(f32::NAN), solid_angle(0)), (0, 0, 0.0));
        assert_eq!(solid_angle_code(100.0), 4095, "no code leaves the 12 bits");
        let mut x = 1.1e-8;
        while x < LARGEST_SOLID_ANGLE {
            assert!((solid_angle(solid_angle_code(x)) / x - 1.0).abs() < 2.7e-3, "{x}");
            x *= 1.07;
        }
    }
}
