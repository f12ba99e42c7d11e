//! Tries a BRDF on some directions when it is read: with its defaults, at the bounds of its parameters, and between.

use super::{Written, WrittenError, instrument::MOST_STEPS, is_value};
use crate::{
    brdf::{Parameters, Value, Values},
    sphere::{cosine_direction, uniform_direction},
};
use glam::Vec3;

/// Number of parameter settings to try.
const SETTINGS: u64 = 8;
/// Pairs of directions per setting.
const PAIRS: usize = 48;
/// Largest relative difference between both directions without a remark.
const RECIPROCITY: f32 = 1e-3;
/// Largest albedo without a remark.
const MOST_ALBEDO: f32 = 1.02;

/// Evaluates the BRDF. Returns remarks, in sentences.
///
/// # Errors
/// Invalid values, or a function that does not terminate.
pub fn try_out(written: &Written) -> Result<Vec<String>, WrittenError> {
    let mut random = fastrand::Rng::with_seed(1);
    let mut is_reciprocal = true;
    for setting in 0..SETTINGS {
        let values = values(written, setting, &mut random);
        let arguments = written.arguments(&values);
        for pair in 0..PAIRS {
            let [wi, wo] = directions(pair, &mut random);
            let refused = |what: String| {
                let numbers: Vec<String> = written
                    .parameters()
                    .iter()
                    .scan(0, |first, p| {
                        let value = values.at(*first, p);
                        *first += p.numbers();
                        Some(match value {
                            Value::Number(x) => format!("{} = {x}", p.name),
                            Value::Color(c) => format!("{} = {} {} {}", p.name, c.x, c.y, c.z),
                        })
                    })
                    .collect();
                WrittenError::whole(format!("{what} for wi = {wi}, wo = {wo} and {}", numbers.join(", ")))
            };
            let endless = || refused(format!("it does not end within {MOST_STEPS} turns of loops and calls"));
            let (value, is_cut) = written.evaluated(&arguments, wi, wo).map_err(|_| endless())?;
            if is_cut {
                return Err(endless());
            }
            if !is_value(value) {
                return Err(refused(format!("it gives {value}, which is not a reflectance")));
            }
            let back = written.value(&arguments, wo, wi).unwrap_or(value);
            is_reciprocal &= (value - back).length() <= RECIPROCITY * value.length().max(1e-3);
        }
    }
    let most = written.estimate(&self::values(written, 0, &mut random)).most_albedo();
    let gains = (most > MOST_ALBEDO)
        .then(|| format!("it reflects up to {most:.2} times the light that it receives, with its defaults"));
    let differs = (!is_reciprocal).then(|| "it is not reciprocal: light and eye may not change places".to_owned());
    Ok(gains.into_iter().chain(differs).collect())
}

/// The defaults, the lower bounds, the upper bounds, and numbers between.
fn values(written: &Written, setting: u64, random: &mut fastrand::Rng) -> Values {
    let mut told = Parameters::default();
    for p in written.parameters() {
        let [low, high] = p.range;
        let mut number = || match setting {
            1 => low,
            2 => high,
            _ => low + (high - low) * random.f32(),
        };
        let color = Vec3::new(number(), number(), number());
        let value = if p.is_color() { Value::Color(color) } else { Value::Number(color.x) };
        told.set(p.name, if setting == 0 { p.default } else { value });
    }
    Values::of(written.parameters(), &told)
}

/// A random pair, one near the mirror direction, or a grazing one.
fn directions(pair: usize, random: &mut fastrand::Rng) -> [Vec3; 2] {
    let mut above = || cosine_direction(random.f32(), random.f32());
    let (a, b) = (above(), above());
    let upper = |d: Vec3| Vec3::new(d.x, d.y, d.z.max(1e-3)).normalize();
    match pair {
        0 => [Vec3::Z, Vec3::Z],
        1..16 => [a, Vec3::new(-a.x, -a.y, a.z)].map(upper),
        16..24 => [a, Vec3::new(b.x, b.y, 0.02 * b.z)].map(upper),
        24..32 => [upper(a), upper(uniform_direction(b.x.abs(), b.y.abs()))],
        _ => [a, b].map(upper),
    }
}
