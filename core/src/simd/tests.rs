use super::*;

/// All operations over all pairs of special numbers.
struct Everything;

const NUMBERS: [f32; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    1e-40,
    -3e-39,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1.0 + 1.0 / 4096.0,
    3e7,
    -87.3,
    1.0 / 3.0,
    88.8,
];

impl Kernel for Everything {
    type Output = Vec<[f32; 8]>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<[f32; 8]> {
        let mut out = Vec::new();
        for shift in 0..NUMBERS.len() {
            for half in [0, 8] {
                let a = L::new(std::array::from_fn(|i| NUMBERS[half + i]));
                let b = L::new(std::array::from_fn(|i| NUMBERS[(half + i + shift) % NUMBERS.len()]));
                let mask = a.simd_gt(b);
                let values = [
                    a + b,
                    a - b,
                    a * b,
                    a / b,
                    a * b - L::splat(1.0),
                    -a,
                    a & b,
                    a | b,
                    a.sqrt(),
                    a.abs(),
                    a.exp(),
                    a.fast_max(b),
                    a.fast_min(b),
                    a.at_least(0.5),
                    mask,
                    a.simd_ge(b),
                    a.simd_lt(b),
                    a.simd_le(b),
                    a.simd_ne(b),
                    mask.select(a, b),
                ];
                out.extend(values.map(L::to_array));
                out.push([mask.to_bitmask() as f32; 8]);
            }
        }
        let rows: [[f32; 8]; 8] = std::array::from_fn(|row| std::array::from_fn(|column| (8 * row + column) as f32));
        out.extend(L::transposed(std::array::from_fn(|row| &rows[row])).map(L::to_array));
        out
    }
}

/// The bits, with one pattern for all NaN: the NaN that an operation returns is unspecified.
fn bits(values: &[[f32; 8]]) -> Vec<u32> {
    values.iter().flatten().map(|v| if v.is_nan() { f32::NAN.to_bits() } else { v.to_bits() }).collect()
}

#[test]
fn all_instruction_sets_give_the_same_bits() {
    let portable = InstructionSet::PORTABLE.run(Everything);
    for set in InstructionSet::available() {
        assert_eq!(bits(&set.run(Everything)), bits(&portable), "{set:?}");
    }
    let mut other = portable.clone();
    other[2][2] = f32::from_bits(other[2][2].to_bits() + 1);
    assert_ne!(bits(&other), bits(&portable), "negative control: one bit");
    let a = 1.0_f32 + 1.0 / 4096.0;
    assert_ne!(a.mul_add(a, -1.0), a * a - 1.0, "negative control: a fused product is another number");
}

#[test]
fn columns_of_rows() {
    let rows: [[f32; 8]; 8] = std::array::from_fn(|row| std::array::from_fn(|column| (8 * row + column) as f32));
    let columns = f32x8::transposed(std::array::from_fn(|row| &rows[row]));
    assert_eq!(columns[3].to_array(), [3.0, 11.0, 19.0, 27.0, 35.0, 43.0, 51.0, 59.0]);
}
