//! Light transport as a sparse matrix between functions of incident radiance (wavelet paper, 4.2).

use super::square::{Function, Node};
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// A function of incident radiance: of places on a patch and of directions.
///
/// It is the product of both functions of squares, over the root of π times the area of the patch. So the integral of its square over
/// the patch and over the cosine-weighted hemisphere is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RadianceFunction {
    /// Index of the patch.
    pub patch: u32,
    /// Over places.
    pub space: Function,
    /// Over directions.
    pub angle: Function,
}

/// A coefficient of transport (Eq. 4): how much of `receiver` one unit of `sender` becomes in one bounce, per color channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransportCoefficient {
    /// Light that arrives.
    pub receiver: RadianceFunction,
    /// Light that is reflected.
    pub sender: RadianceFunction,
    /// The coefficient.
    pub value: Vec3,
}

/// The functions of an operator, in ascending order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RadianceBasis(Vec<RadianceFunction>);

impl RadianceBasis {
    /// A basis of these functions; `None` unless they ascend.
    pub fn from_functions(functions: Vec<RadianceFunction>) -> Option<Self> {
        functions.is_sorted_by(|a, b| a < b).then_some(Self(functions))
    }

    /// All functions, in the order of their indices.
    pub fn functions(&self) -> &[RadianceFunction] {
        &self.0
    }

    /// The index of a function, if it is one of them.
    pub fn index_of(&self, function: &RadianceFunction) -> Option<u32> {
        self.0.binary_search(function).ok().map(|index| index as u32)
    }
}

/// Parts of a product that are computed side by side, whatever the number of threads.
const PARTS: usize = 8;

/// A sparse square matrix: for each sender, its receivers.
#[derive(Clone, Debug, PartialEq)]
pub struct Operator {
    /// First entry of each sender, and the end of the last.
    starts: Vec<usize>,
    /// Receiver and value; those of a sender in ascending order.
    entries: Vec<(u32, Vec3)>,
}

impl Operator {
    /// The matrix of some coefficients, and its functions. Coefficients of the same pair are added.
    pub fn of(mut coefficients: Vec<TransportCoefficient>) -> (RadianceBasis, Self) {
        coefficients.par_sort_unstable_by_key(|coefficient| (coefficient.sender, coefficient.receiver));
        let mut functions: Vec<_> = coefficients.iter().flat_map(|c| [c.receiver, c.sender]).collect();
        functions.par_sort_unstable();
        functions.dedup();
        let basis = RadianceBasis(functions);
        let mut columns = vec![Vec::<(u32, Vec3)>::new(); basis.0.len()];
        let index = |function| basis.index_of(function).expect("a function of the coefficients") as usize;
        for TransportCoefficient { receiver, sender, value } in &coefficients {
            let (column, receiver) = (&mut columns[index(sender)], index(receiver) as u32);
            match column.last_mut() {
                Some((last, sum)) if *last == receiver => *sum += *value,
                _ => column.push((receiver, *value)),
            }
        }
        (basis, Self::of_columns(columns))
    }

    /// The matrix that changes nothing.
    pub fn identity(functions: usize) -> Self {
        Self { starts: (0..=functions).collect(), entries: (0..functions as u32).map(|i| (i, Vec3::ONE)).collect() }
    }

    pub(super) fn of_columns(columns: Vec<Vec<(u32, Vec3)>>) -> Self {
        let mut starts = vec![0];
        starts.extend(columns.iter().scan(0, |sum, column| {
            *sum += column.len();
            Some(*sum)
        }));
        Self { starts, entries: columns.concat() }
    }

    /// A matrix of stored parts: the first entry of each sender and the end of the last, and all entries. `None` if they are not
    /// in order.
    pub fn from_parts(starts: Vec<usize>, entries: Vec<(u32, Vec3)>) -> Option<Self> {
        let functions = starts.len().checked_sub(1)?;
        let is_whole = starts[0] == 0 && starts[functions] == entries.len() && starts.is_sorted();
        let is_one =
            is_whole && entries.iter().all(|(receiver, value)| (*receiver as usize) < functions && value.is_finite());
        is_one.then_some(Self { starts, entries })
    }

    /// First entry of each sender, and the end of the last.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Receiver and value of each coefficient, sender by sender.
    pub fn entries(&self) -> &[(u32, Vec3)] {
        &self.entries
    }

    /// Number of functions.
    pub fn functions(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of coefficients.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether all coefficients are zero.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Receivers of a sender, and their coefficients.
    pub fn column(&self, sender: usize) -> &[(u32, Vec3)] {
        &self.entries[self.starts[sender]..self.starts[sender + 1]]
    }

    /// Only coefficients beyond a threshold in any channel (4.4).
    pub fn compressed(&self, threshold: f32) -> Self {
        let kept =
            |sender| self.column(sender).iter().copied().filter(|(_, value)| exceeds(*value, threshold)).collect();
        Self::of_columns((0..self.functions()).map(kept).collect())
    }

    /// This matrix after another one: its product with `first`, compressed.
    ///
    /// # Panics
    /// If their functions differ in number.
    pub fn after(&self, first: &Self, threshold: f32) -> Self {
        assert_eq!(self.functions(), first.functions(), "matrices over the same functions");
        let column = |sender| self.after_column(first.column(sender), threshold);
        Self::of_columns((0..self.functions()).into_par_iter().map(column).collect())
    }

    /// A column of a product: receivers of this matrix for the light of some functions, in ascending order, compressed.
    pub(super) fn after_column(&self, first: &[(u32, Vec3)], threshold: f32) -> Vec<(u32, Vec3)> {
        let mut sums = FxHashMap::<u32, Vec3>::default();
        for &(between, share) in first {
            for &(receiver, value) in self.column(between as usize) {
                *sums.entry(receiver).or_insert(Vec3::ZERO) += value * share;
            }
        }
        let mut kept: Vec<_> = sums.into_iter().filter(|(_, value)| exceeds(*value, threshold)).collect();
        kept.sort_unstable_by_key(|(receiver, _)| *receiver);
        kept
    }

    /// The sum of two matrices.
    ///
    /// # Panics
    /// If their functions differ in number.
    pub fn plus(&self, other: &Self) -> Self {
        assert_eq!(self.functions(), other.functions(), "matrices over the same functions");
        let column = |sender: usize| {
            let mut sums = [self.column(sender), other.column(sender)].concat();
            sums.sort_by_key(|(receiver, _)| *receiver);
            sums.dedup_by(|(later, value), (earlier, sum)| {
                let is_same = later == earlier;
                if is_same {
                    *sum += *value;
                }
                is_same
            });
            sums
        };
        Self::of_columns((0..self.functions()).map(column).collect())
    }

    /// Sum of the squared differences of all coefficients, over the channels.
    ///
    /// # Panics
    /// If their functions differ in number.
    pub fn squared_distance(&self, other: &Self) -> f64 {
        let negative = Self {
            starts: other.starts.clone(),
            entries: other.entries.iter().map(|(receiver, value)| (*receiver, -*value)).collect(),
        };
        self.plus(&negative).entries.iter().map(|(_, value)| f64::from(value.length_squared())).sum()
    }

    /// The light that arrives for the light `sent`, one value a function each. Zeros of `sent` cost nothing (5.2).
    ///
    /// # Panics
    /// If there is not one value for each function.
    pub fn apply(&self, sent: &[Vec3]) -> Vec<Vec3> {
        assert_eq!(sent.len(), self.functions(), "one value for each function");
        let of_part = |part: usize| {
            let mut received = vec![Vec3::ZERO; sent.len()];
            // Neighbors among the senders have columns of other lengths, so each part takes every so many.
            for sender in (part..sent.len()).step_by(PARTS).filter(|&sender| sent[sender] != Vec3::ZERO) {
                let light = sent[sender];
                self.column(sender).iter().for_each(|&(receiver, value)| received[receiver as usize] += value * light);
            }
            received
        };
        let parts: Vec<Vec<Vec3>> = (0..PARTS).into_par_iter().map(of_part).collect();
        let sum = |receiver: usize| parts.iter().map(|part| part[receiver]).sum();
        (0..sent.len()).map(sum).collect()
    }

    /// Number of links: groups of at most 256 coefficients whose functions have the same four supports (4.3).
    pub fn links(&self, basis: &RadianceBasis) -> usize {
        let support = |index: u32| {
            let RadianceFunction { patch, space, angle } = basis.0[index as usize];
            (patch, space.support(), angle.support())
        };
        let link = |sender: usize, receiver: u32| (support(sender as u32), support(receiver));
        type End = (u32, Node, Node);
        let links: FxHashSet<(End, End)> = (0..self.functions())
            .flat_map(|sender| self.column(sender).iter().map(move |(receiver, _)| link(sender, *receiver)))
            .collect();
        links.len()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.starts[..]) + size_of_val(&self.entries[..])) as u64
    }
}

/// Whether a channel is beyond a threshold.
fn exceeds(value: Vec3, threshold: f32) -> bool {
    value.abs().max_element() > threshold
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn function(patch: u32) -> RadianceFunction {
        RadianceFunction { patch, space: Function::CONSTANT, angle: Function::CONSTANT }
    }

    /// Random coefficients between constants of patches; each patch sends less than it gets.
    pub fn random(patches: u32, seed: u64) -> (RadianceBasis, Operator) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut value = || Vec3::new(rng.f32(), rng.f32(), rng.f32()) * (0.9 / patches as f32);
        let pairs = (0..patches).flat_map(|receiver| (0..patches).map(move |sender| (receiver, sender)));
        let coefficient = |(receiver, sender)| TransportCoefficient {
            receiver: function(receiver),
            sender: function(sender),
            value: value(),
        };
        Operator::of(pairs.map(coefficient).collect())
    }

    fn vector(functions: usize) -> Vec<Vec3> {
        (0..functions).map(|i| Vec3::new(i as f32, 1.0, (i * i % 7) as f32)).collect()
    }

    pub fn differ(a: &[Vec3], b: &[Vec3]) -> f32 {
        a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
    }

    #[test]
    fn products_and_sums_act_as_their_parts() {
        let ((_, a), (_, b)) = (random(12, 1), random(12, 2));
        let sent = vector(12);
        let twice = a.apply(&b.apply(&sent));
        assert!(differ(&a.after(&b, 0.0).apply(&sent), &twice) < 1e-5);
        assert!(differ(&b.after(&a, 0.0).apply(&sent), &twice) > 0.1, "negative control: the other order");
        let sum: Vec<Vec3> = a.apply(&sent).iter().zip(b.apply(&sent)).map(|(a, b)| *a + b).collect();
        assert!(differ(&a.plus(&b).apply(&sent), &sum) < 1e-5);
        assert_eq!(Operator::identity(12).apply(&sent), sent);
        assert_eq!(
            (a.squared_distance(&a), Operator::identity(2).squared_distance(&Operator::identity(2).compressed(2.0))),
            (0.0, 6.0)
        );
    }

    #[test]
    fn coefficients_of_a_pair_are_added_and_small_ones_left_out() {
        let coefficient =
            |receiver, value| TransportCoefficient { receiver: function(receiver), sender: function(7), value };
        let tiny = Vec3::new(0.0, -0.01, 0.0);
        let (basis, operator) =
            Operator::of(vec![coefficient(9, Vec3::X), coefficient(8, tiny), coefficient(9, Vec3::Y)]);
        let sender = basis.index_of(&function(7)).unwrap() as usize;
        let receiver = |patch| basis.index_of(&function(patch)).unwrap();
        assert_eq!(operator.column(sender), [(receiver(8), tiny), (receiver(9), Vec3::new(1.0, 1.0, 0.0))]);
        assert_eq!(operator.compressed(0.02).column(sender), [(receiver(9), Vec3::new(1.0, 1.0, 0.0))]);
        assert_eq!(operator.compressed(0.005), operator, "either sign counts");
        assert_eq!(basis.index_of(&function(1)), None);
    }

    #[test]
    fn functions_on_the_same_supports_are_one_link() {
        let wavelets: Vec<Function> = {
            let mut found = Vec::new();
            super::super::square::transform(&mut vec![(Node::ROOT.child(2), 1.0)], |function, _| found.push(function));
            found
        };
        let receiver = |&space: &Function| RadianceFunction { space, ..function(0) };
        let coefficient = |receiver| TransportCoefficient { receiver, sender: function(1), value: Vec3::ONE };
        let (basis, operator) = Operator::of(wavelets.iter().map(receiver).map(coefficient).collect());
        assert_eq!((operator.len(), operator.links(&basis)), (4, 1));
        let deeper = RadianceFunction { angle: Node::ROOT.child(1).smooth(), ..function(0) };
        let more = Operator::of([receiver(&wavelets[0]), deeper].map(coefficient).to_vec());
        assert_eq!(more.1.links(&more.0), 2, "negative control: another support");
    }
}
