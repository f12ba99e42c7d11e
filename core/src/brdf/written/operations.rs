//! Operators and functions of WGSL on values.

use super::values::{Flat, Val};
use naga::{BinaryOperator as Op, MathFunction as Math, RelationalFunction, ScalarKind as Kind, UnaryOperator};

pub fn unary(op: UnaryOperator, value: &Val) -> Val {
    let flat = match value {
        Val::Flat(flat) => flat,
        Val::Many(columns) => return Val::Many(columns.iter().map(|column| unary(op, column)).collect()),
    };
    Val::Flat(match (op, flat.kind) {
        (UnaryOperator::Negate, Kind::Float) => flat.map_f(|x| -x),
        (UnaryOperator::Negate, kind) => flat.map(kind, u32::wrapping_neg),
        (UnaryOperator::LogicalNot, kind) => flat.map(kind, |x| x ^ 1),
        (UnaryOperator::BitwiseNot, kind) => flat.map(kind, |x| !x),
    })
}

pub fn binary(op: Op, a: &Val, b: &Val) -> Val {
    match (a, b) {
        (Val::Flat(a), Val::Flat(b)) => Val::Flat(flat_binary(op, a, b)),
        (Val::Many(a), Val::Many(b)) if op == Op::Multiply => {
            Val::Many(b.iter().map(|column| Val::Flat(times_vector(a, &column.flat()))).collect())
        }
        (Val::Many(a), Val::Many(b)) => Val::Many(a.iter().zip(b).map(|(a, b)| binary(op, a, b)).collect()),
        (Val::Many(a), Val::Flat(b)) if b.len > 1 => Val::Flat(times_vector(a, b)),
        (Val::Many(a), b) => Val::Many(a.iter().map(|a| binary(op, a, b)).collect()),
        // A row vector times a matrix.
        (Val::Flat(a), Val::Many(b)) if a.len > 1 => {
            Val::Flat(Flat::floats(&b.iter().map(|column| a.dot(&column.flat())).collect::<Vec<_>>()))
        }
        (a, Val::Many(b)) => Val::Many(b.iter().map(|b| binary(op, a, b)).collect()),
    }
}

fn times_vector(columns: &[Val], vector: &Flat) -> Flat {
    let scaled = columns.iter().enumerate().map(|(i, column)| column.flat().map_f(|x| x * vector.f(i)));
    scaled.reduce(|a, b| a.zip_f(&b, |a, b| a + b)).unwrap_or(*vector)
}

fn flat_binary(op: Op, a: &Flat, b: &Flat) -> Flat {
    let kind = a.kind;
    let (f, i) = (f32::from_bits, |x: u32| x as i32);
    let compared = |order: fn(std::cmp::Ordering) -> bool| {
        a.zip(b, Kind::Bool, |a, b| {
            let ordering = match kind {
                Kind::Float => f(a).partial_cmp(&f(b)),
                Kind::Sint => Some(i(a).cmp(&i(b))),
                _ => Some(a.cmp(&b)),
            };
            ordering.is_some_and(order).into()
        })
    };
    match op {
        Op::Equal => compared(std::cmp::Ordering::is_eq),
        // NaN is unequal to everything.
        Op::NotEqual => flat_binary(Op::Equal, a, b).map(Kind::Bool, |x| x ^ 1),
        Op::Less => compared(std::cmp::Ordering::is_lt),
        Op::LessEqual => compared(std::cmp::Ordering::is_le),
        Op::Greater => compared(std::cmp::Ordering::is_gt),
        Op::GreaterEqual => compared(std::cmp::Ordering::is_ge),
        Op::And | Op::LogicalAnd => a.zip(b, kind, |a, b| a & b),
        Op::InclusiveOr | Op::LogicalOr => a.zip(b, kind, |a, b| a | b),
        Op::ExclusiveOr => a.zip(b, kind, |a, b| a ^ b),
        Op::ShiftLeft => a.zip(b, kind, |a, b| a.wrapping_shl(b)),
        Op::ShiftRight if kind == Kind::Sint => a.zip(b, kind, |a, b| i(a).wrapping_shr(b) as u32),
        Op::ShiftRight => a.zip(b, kind, |a, b| a.wrapping_shr(b)),
        Op::Add | Op::Subtract | Op::Multiply | Op::Divide | Op::Modulo => arithmetic(op, a, b),
    }
}

fn arithmetic(op: Op, a: &Flat, b: &Flat) -> Flat {
    match a.kind {
        Kind::Float => a.zip_f(b, |a, b| match op {
            Op::Add => a + b,
            Op::Subtract => a - b,
            Op::Multiply => a * b,
            Op::Divide => a / b,
            _ => a % b,
        }),
        // Division by zero gives the dividend, and remainder 0.
        Kind::Sint => a.zip(b, Kind::Sint, |a, b| {
            let (a, b) = (a as i32, b as i32);
            (match op {
                Op::Add => a.wrapping_add(b),
                Op::Subtract => a.wrapping_sub(b),
                Op::Multiply => a.wrapping_mul(b),
                Op::Divide => a.checked_div(b).unwrap_or(a),
                _ => a.checked_rem(b).unwrap_or(0),
            }) as u32
        }),
        kind => a.zip(b, kind, |a, b| match op {
            Op::Add => a.wrapping_add(b),
            Op::Subtract => a.wrapping_sub(b),
            Op::Multiply => a.wrapping_mul(b),
            Op::Divide => a.checked_div(b).unwrap_or(a),
            _ => a.checked_rem(b).unwrap_or(0),
        }),
    }
}

pub fn converted(value: &Val, kind: Kind, is_bitcast: bool) -> Val {
    let flat = match value {
        Val::Flat(flat) => flat,
        Val::Many(columns) => return Val::Many(columns.iter().map(|c| converted(c, kind, is_bitcast)).collect()),
    };
    if is_bitcast {
        return Val::Flat(Flat { kind, ..*flat });
    }
    let f = f32::from_bits;
    Val::Flat(flat.map(kind, |x| match (flat.kind, kind) {
        (from, to) if from == to => x,
        (Kind::Float, Kind::Sint) => f(x) as i32 as u32,
        (Kind::Float, Kind::Uint) => f(x) as u32,
        (Kind::Float, Kind::Bool) => (f(x) != 0.0).into(),
        (Kind::Sint, Kind::Float) => (x as i32 as f32).to_bits(),
        (_, Kind::Float) => (x as f32).to_bits(),
        (_, Kind::Bool) => (x != 0).into(),
        _ => x,
    }))
}

pub fn relational(fun: RelationalFunction, flat: &Flat) -> Flat {
    let mut parts = flat.bits[..flat.len as usize].iter();
    match fun {
        RelationalFunction::All => Flat::truth(parts.all(|&x| x != 0)),
        RelationalFunction::Any => Flat::truth(parts.any(|&x| x != 0)),
        RelationalFunction::IsNan => flat.map(Kind::Bool, |x| f32::from_bits(x).is_nan().into()),
        RelationalFunction::IsInf => flat.map(Kind::Bool, |x| f32::from_bits(x).is_infinite().into()),
    }
}

/// Whether [`math`] implements a function.
pub fn is_known(fun: Math) -> bool {
    use Math::*;
    matches!(
        fun,
        Abs | Min
            | Max
            | Clamp
            | Saturate
            | Cos
            | Cosh
            | Sin
            | Sinh
            | Tan
            | Tanh
            | Acos
            | Asin
            | Atan
            | Atan2
            | Asinh
            | Acosh
            | Atanh
            | Radians
            | Degrees
            | Ceil
            | Floor
            | Round
            | Fract
            | Trunc
            | Exp
            | Exp2
            | Log
            | Log2
            | Pow
            | Dot
            | Cross
            | Distance
            | Length
            | Normalize
            | FaceForward
            | Reflect
            | Refract
            | Sign
            | Fma
            | Mix
            | Step
            | SmoothStep
            | Sqrt
            | InverseSqrt
            | Transpose
            | Determinant
    )
}

/// Evaluates a function of up to three arguments; missing arguments repeat the first.
pub fn math(fun: Math, first: &Val, others: [&Val; 2]) -> Val {
    if let Val::Many(columns) = first {
        return of_matrix(fun, columns);
    }
    let (a, [b, c]) = (first.flat(), others.map(Val::flat));
    Val::Flat(match a.kind {
        Kind::Float => of_floats(fun, a, b, c),
        kind if fun == Math::Dot => {
            let products = a.zip(&b, kind, u32::wrapping_mul);
            Flat::scalar(kind, products.bits.into_iter().fold(0, u32::wrapping_add))
        }
        Kind::Sint => {
            let i = |x: u32| x as i32;
            match fun {
                Math::Abs => a.map(Kind::Sint, |x| i(x).wrapping_abs() as u32),
                Math::Sign => a.map(Kind::Sint, |x| i(x).signum() as u32),
                Math::Min => a.zip(&b, Kind::Sint, |a, b| i(a).min(i(b)) as u32),
                Math::Max => a.zip(&b, Kind::Sint, |a, b| i(a).max(i(b)) as u32),
                _ => a
                    .zip(&b, Kind::Sint, |a, b| i(a).max(i(b)) as u32)
                    .zip(&c, Kind::Sint, |a, c| i(a).min(i(c)) as u32),
            }
        }
        kind => match fun {
            Math::Min => a.zip(&b, kind, u32::min),
            Math::Max => a.zip(&b, kind, u32::max),
            Math::Clamp => a.zip(&b, kind, u32::max).zip(&c, kind, u32::min),
            _ => a,
        },
    })
}

fn of_matrix(fun: Math, columns: &[Val]) -> Val {
    let rows = columns[0].flat().len as usize;
    let at = |column: usize, row: usize| columns[column].flat().f(row);
    if fun == Math::Transpose {
        let row = |row| Val::Flat(Flat::floats(&(0..columns.len()).map(|c| at(c, row)).collect::<Vec<_>>()));
        return Val::Many((0..rows).map(row).collect());
    }
    let numbers: Vec<f32> = (0..rows).flat_map(|column| (0..rows).map(move |row| at(column, row))).collect();
    Val::Flat(Flat::float(match rows {
        2 => glam::Mat2::from_cols_slice(&numbers).determinant(),
        3 => glam::Mat3::from_cols_slice(&numbers).determinant(),
        _ => glam::Mat4::from_cols_slice(&numbers).determinant(),
    }))
}

fn of_floats(fun: Math, a: Flat, b: Flat, c: Flat) -> Flat {
    let scaled = |v: Flat, s: f32| v.map_f(|x| x * s);
    let minus = |a: Flat, b: Flat| a.zip_f(&b, |a, b| a - b);
    let length = |v: Flat| v.dot(&v).sqrt();
    match fun {
        Math::Min => a.zip_f(&b, f32::min),
        Math::Max => a.zip_f(&b, f32::max),
        Math::Clamp => a.zip_f(&b, f32::max).zip_f(&c, f32::min),
        Math::Atan2 => a.zip_f(&b, f32::atan2),
        Math::Pow => a.zip_f(&b, |x, y| if x < 0.0 { f32::NAN } else { x.powf(y) }),
        Math::Step => a.zip_f(&b, |edge, x| if x >= edge { 1.0 } else { 0.0 }),
        Math::Fma => a.zip_f(&b, |a, b| a * b).zip_f(&c, |ab, c| ab + c),
        Math::Mix => {
            let kept = a.zip_f(&c, |a, t| a * (1.0 - t));
            kept.zip_f(&b.zip_f(&c, |b, t| b * t), |a, b| a + b)
        }
        Math::SmoothStep => {
            let t = minus(c, a).zip_f(&minus(b, a), |x, range| (x / range).clamp(0.0, 1.0));
            t.map_f(|t| t * t * (3.0 - 2.0 * t))
        }
        Math::Dot => Flat::float(a.dot(&b)),
        Math::Cross => {
            let part = |i: usize, j: usize| a.f(i) * b.f(j) - a.f(j) * b.f(i);
            Flat::floats(&[part(1, 2), part(2, 0), part(0, 1)])
        }
        Math::Distance => Flat::float(length(minus(a, b))),
        Math::Length => Flat::float(length(a)),
        Math::Normalize => scaled(a, 1.0 / length(a)),
        Math::FaceForward => {
            if b.dot(&c) < 0.0 {
                a
            } else {
                scaled(a, -1.0)
            }
        }
        Math::Reflect => minus(a, scaled(b, 2.0 * b.dot(&a))),
        Math::Refract => {
            let (eta, cos) = (c.f(0), b.dot(&a));
            let k = 1.0 - eta * eta * (1.0 - cos * cos);
            let bent = minus(scaled(a, eta), scaled(b, eta * cos + k.max(0.0).sqrt()));
            if k < 0.0 { scaled(a, 0.0) } else { bent }
        }
        _ => a.map_f(|x| of_float(fun, x)),
    }
}

fn of_float(fun: Math, x: f32) -> f32 {
    match fun {
        Math::Abs => x.abs(),
        Math::Saturate => x.clamp(0.0, 1.0),
        Math::Cos => x.cos(),
        Math::Cosh => x.cosh(),
        Math::Sin => x.sin(),
        Math::Sinh => x.sinh(),
        Math::Tan => x.tan(),
        Math::Tanh => x.tanh(),
        Math::Acos => x.acos(),
        Math::Asin => x.asin(),
        Math::Atan => x.atan(),
        Math::Asinh => x.asinh(),
        Math::Acosh => x.acosh(),
        Math::Atanh => x.atanh(),
        Math::Radians => x.to_radians(),
        Math::Degrees => x.to_degrees(),
        Math::Ceil => x.ceil(),
        Math::Floor => x.floor(),
        Math::Round => x.round_ties_even(),
        Math::Fract => x - x.floor(),
        Math::Trunc => x.trunc(),
        Math::Exp => x.exp(),
        Math::Exp2 => x.exp2(),
        Math::Log => x.ln(),
        Math::Log2 => x.log2(),
        Math::Sign => {
            if x == 0.0 {
                0.0
            } else {
                x.signum()
            }
        }
        Math::Sqrt => x.sqrt(),
        Math::InverseSqrt => 1.0 / x.sqrt(),
        _ => f32::NAN,
    }
}
