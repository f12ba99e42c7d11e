//! Recomputes the links of single receivers, for verification.

use super::{
    gather::{Gatherer, Row},
    refine::{Criterion, is_examined},
};
use lapidary_core::{dataset::MeshlessSettings, meshless::Basis, surfel::Surface};
use rayon::prelude::*;

/// Recomputes the links of some receivers with new rays, including all their ancestors, on which they depend. The result equals a
/// bake's bit for bit.
pub fn recompute_links(
    surface: &dyn Surface,
    basis: &Basis,
    settings: &MeshlessSettings,
    receivers: &[usize],
) -> Vec<(usize, Row)> {
    let gatherer = Gatherer::new(surface, basis, settings.rays);
    let criterion = Criterion::new(basis, settings.epsilon);
    let mut rows = vec![Row::new(); basis.len()];
    let needed = with_ancestors(basis, receivers);
    for level in 0..basis.levels() {
        let range = basis.level(level);
        let of_level: Vec<usize> = needed.iter().copied().filter(|i| range.contains(i)).collect();
        let gather = |scratch: &mut _, &receiver: &usize| {
            if !is_examined(basis, receiver, level, &rows) {
                return Row::new();
            }
            let (mut row, is_root) = gatherer.gather(scratch, receiver, level, &rows);
            criterion.prune(&mut row, is_root, level);
            row
        };
        let found: Vec<Row> = of_level.par_iter().map_init(|| gatherer.scratch(), gather).collect();
        of_level.into_iter().zip(found).for_each(|(receiver, row)| rows[receiver] = row);
    }
    needed.into_iter().map(|receiver| (receiver, std::mem::take(&mut rows[receiver]))).collect()
}

/// The functions with their ancestors: all functions of coarser levels that reach their points or their parents' points.
fn with_ancestors(basis: &Basis, functions: &[usize]) -> Vec<usize> {
    let mut needed = vec![false; basis.len()];
    functions.iter().for_each(|&i| needed[i] = true);
    let mut parents = Vec::new();
    for level in (1..basis.levels()).rev() {
        for i in basis.level(level).filter(|&i| needed[i]).collect::<Vec<_>>() {
            let point = &basis.points()[i];
            parents.clear();
            (0..level).for_each(|coarser| basis.values(coarser, point.position, point.normal, &mut parents));
            parents.iter().for_each(|p| needed[p.0 as usize] = true);
        }
    }
    (0..basis.len()).filter(|&i| needed[i]).collect()
}
