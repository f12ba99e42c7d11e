//! Values of the interpreter: scalars, vectors and composites.

use naga::{ScalarKind, TypeInner};

/// A scalar, or a vector of up to four.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    pub kind: ScalarKind,
    /// 1 for a scalar.
    pub len: u8,
    /// Bits of each component by its kind; true is 1.
    pub bits: [u32; 4],
}

/// Any value.
#[derive(Clone, Debug, PartialEq)]
pub enum Val {
    Flat(Flat),
    /// Columns of a matrix, members of a structure, elements of an array.
    Many(Vec<Val>),
}

impl Flat {
    pub fn scalar(kind: ScalarKind, bits: u32) -> Self {
        Self { kind, len: 1, bits: [bits, 0, 0, 0] }
    }

    pub fn float(x: f32) -> Self {
        Self::scalar(ScalarKind::Float, x.to_bits())
    }

    pub fn truth(is: bool) -> Self {
        Self::scalar(ScalarKind::Bool, is.into())
    }

    pub fn floats(numbers: &[f32]) -> Self {
        let mut bits = [0; 4];
        bits.iter_mut().zip(numbers).for_each(|(bits, x)| *bits = x.to_bits());
        Self { kind: ScalarKind::Float, len: numbers.len() as u8, bits }
    }

    pub fn f(&self, i: usize) -> f32 {
        f32::from_bits(self.bits[i])
    }

    /// Component `i`; a scalar has only one.
    pub fn at(&self, i: usize) -> u32 {
        self.bits[if self.len == 1 { 0 } else { i }]
    }

    pub fn is_true(&self) -> bool {
        self.bits[0] != 0
    }

    pub fn index(&self) -> usize {
        self.bits[0] as usize
    }

    /// Applies a function to each component and the corresponding one of another value.
    pub fn zip(&self, other: &Self, kind: ScalarKind, f: impl Fn(u32, u32) -> u32) -> Self {
        let len = self.len.max(other.len);
        Self { kind, len, bits: std::array::from_fn(|i| if i < len.into() { f(self.at(i), other.at(i)) } else { 0 }) }
    }

    pub fn map(&self, kind: ScalarKind, f: impl Fn(u32) -> u32) -> Self {
        self.zip(self, kind, |x, _| f(x))
    }

    pub fn map_f(&self, f: impl Fn(f32) -> f32) -> Self {
        self.map(ScalarKind::Float, |x| f(f32::from_bits(x)).to_bits())
    }

    pub fn zip_f(&self, other: &Self, f: impl Fn(f32, f32) -> f32) -> Self {
        self.zip(other, ScalarKind::Float, |a, b| f(f32::from_bits(a), f32::from_bits(b)).to_bits())
    }

    pub fn dot(&self, other: &Self) -> f32 {
        (0..self.len as usize).map(|i| self.f(i) * other.f(i)).sum()
    }
}

impl Val {
    pub fn flat(&self) -> Flat {
        match self {
            Self::Flat(flat) => *flat,
            // The validation of the module rules this out.
            Self::Many(_) => Flat::float(f32::NAN),
        }
    }

    /// A component, column, member or element; indices past the end give the last one, as on graphics cards that check bounds.
    pub fn part(&self, index: usize) -> Self {
        match self {
            Self::Flat(flat) => Self::Flat(Flat::scalar(flat.kind, flat.bits[index.min(flat.len as usize - 1)])),
            Self::Many(parts) => parts[index.min(parts.len() - 1)].clone(),
        }
    }

    /// The part at the end of a path.
    pub fn load(&self, path: &[usize]) -> Self {
        match (self, path) {
            (_, []) => self.clone(),
            (Self::Flat(_), &[index, ..]) => self.part(index),
            (Self::Many(parts), &[index, ref rest @ ..]) => parts[index.min(parts.len() - 1)].load(rest),
        }
    }

    /// Replaces the part at the end of a path.
    pub fn store(&mut self, path: &[usize], value: Self) {
        let Some((&index, rest)) = path.split_first() else {
            *self = value;
            return;
        };
        match self {
            Self::Flat(flat) => flat.bits[index.min(flat.len as usize - 1)] = value.flat().bits[0],
            Self::Many(parts) => {
                let last = parts.len() - 1;
                parts[index.min(last)].store(rest, value);
            }
        }
    }

    /// The zero of a type.
    pub fn zero(module: &naga::Module, ty: &TypeInner) -> Self {
        let of = |handle: naga::Handle<naga::Type>| Self::zero(module, &module.types[handle].inner);
        match *ty {
            TypeInner::Scalar(scalar) => Self::Flat(Flat::scalar(scalar.kind, 0)),
            TypeInner::Vector { size, scalar } => Self::Flat(Flat { kind: scalar.kind, len: size as u8, bits: [0; 4] }),
            TypeInner::Matrix { columns, rows, scalar } => {
                let column = Flat { kind: scalar.kind, len: rows as u8, bits: [0; 4] };
                Self::Many(vec![Self::Flat(column); columns as usize])
            }
            TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
                Self::Many(vec![of(base); count.get() as usize])
            }
            TypeInner::Struct { ref members, .. } => Self::Many(members.iter().map(|member| of(member.ty)).collect()),
            // Rejected when the module was read.
            _ => Self::Flat(Flat::float(f32::NAN)),
        }
    }
}
