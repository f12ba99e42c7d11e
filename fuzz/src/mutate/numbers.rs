//! Numbers at which readers break: signs, limits of types, infinities, sizes that overflow.

use crate::choices::Choices;

/// Numbers as text and in JSON.
pub const TEXTS: [&str; 30] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-7",
    "1e-38",
    "1e-45",
    "1e9",
    "1e12",
    "1e19",
    "3.4e38",
    "3.5e38",
    "1e308",
    "-1e308",
    "1e999",
    "nan",
    "inf",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9007199254740992",
    "9223372036854775808",
    "18446744073709551615",
];

/// Numbers as integers of any width.
const INTEGERS: [u64; 16] = [
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0xffff,
    0x1_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x1_0000_0000,
    1 << 63,
    u64::MAX,
];

/// Numbers in single precision.
pub const FLOATS: [f32; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-45,
    1e-38,
    1e-7,
    1e6,
    1e9,
    1.1e9,
    1e12,
    1e19,
    f32::MAX,
    -f32::MAX,
    f32::INFINITY,
    f32::NAN,
];

/// Overwrites the first bytes with a number, or as many bytes as there are.
pub fn overwrite(bytes: &mut [u8], choices: &mut Choices) {
    let number = if choices.one_in(3) { u64::from(choices.of(&FLOATS).to_bits()) } else { *choices.of(&INTEGERS) };
    let width = *choices.of(&[1, 2, 4, 4, 8]);
    let little = number.to_le_bytes();
    let mut written = little[..width].to_vec();
    if choices.one_in(3) {
        written.reverse();
    }
    let width = width.min(bytes.len());
    bytes[..width].copy_from_slice(&written[..width]);
}
