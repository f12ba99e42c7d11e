use super::*;
use crate::{
    implicit::{
        forest::{nodes::Disc, quadtrees::Slot},
        tests::{Furnished, furnished},
    },
    sphere::uniform_direction,
    threads::on_threads,
};
use glam::Vec3;
use std::f32::consts::PI;

/// A receiver at the origin that faces up, surrounded by discs, each an object.
fn scattered(count: usize) -> DiscForest {
    let mut rng = fastrand::Rng::with_seed(3);
    let receiver = Disc { position: Vec3::ZERO, normal: Vec3::Y, area: 0.01 };
    let disc = |_| Disc {
        position: uniform_direction(rng.f32(), rng.f32()) * (0.5 + 3.0 * rng.f32()),
        normal: uniform_direction(rng.f32(), rng.f32()),
        area: 0.3 * rng.f32() * rng.f32(),
    };
    let discs: Vec<Disc> = std::iter::once(receiver).chain((0..count).map(disc)).collect();
    DiscForest::new(&vec![1; discs.len()], discs)
}

/// The keys of a receiver, by testing the ray of every cell against every disc.
fn by_every_ray(forest: &DiscForest, overlap: f32) -> Vec<u32> {
    let (receiver, codes) = (forest.discs()[0], DistanceCodes::of(forest));
    let frame = BinLayout::FINEST.frame_of(&receiver);
    let mut keys = vec![EMPTY; BinLayout::FINEST.cells.len()];
    for (node, disc) in forest.discs().iter().enumerate().skip(1) {
        let offset = disc.position - receiver.position;
        if !(offset.dot(receiver.normal) > 0.0 && offset.dot(disc.normal) < 0.0) {
            continue;
        }
        let key = codes.key(offset.length_squared(), node as u32);
        for (cell, bin) in keys.iter_mut().enumerate() {
            let ray = frame * BinLayout::FINEST.cells.direction_of(cell);
            let distance = offset.dot(disc.normal) / ray.dot(disc.normal);
            let meets = distance > 0.0 && (ray * distance).distance(offset) <= overlap * (disc.area / PI).sqrt();
            if meets {
                *bin = (*bin).min(key);
            }
        }
    }
    keys
}

fn differing(a: &[u32], b: &[u32]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

#[test]
fn a_disc_enters_the_cells_whose_rays_meet_it_and_no_others() {
    for count in [1, 5, 40, 400] {
        let forest = scattered(count);
        let bins = Bins::of_leaves(&forest, BinLayout::FINEST, 0..1, &|_| true);
        let differ = differing(bins.of_leaf(0), &by_every_ray(&forest, cover::OVERLAP));
        assert!(differ <= 2, "rounding along edges only: {differ} of 400 with {count} discs");
    }
    let forest = scattered(400);
    let differ = differing(
        Bins::of_leaves(&forest, BinLayout::FINEST, 0..1, &|_| true).of_leaf(0),
        &by_every_ray(&forest, 1.2 * cover::OVERLAP),
    );
    assert!(differ > 5, "negative control: larger discs, {differ}");
}

#[test]
fn bins_depend_neither_on_instructions_nor_on_threads() {
    let Furnished { forest, .. } = furnished(1024);
    let forest = forest.discs();
    let bins = Bins::walk(forest, BinLayout::FINEST.turned(0.3), &|_| true);
    for instructions in InstructionSet::available() {
        assert_eq!(
            Bins::with_instructions(forest, BinLayout::FINEST.turned(0.3), 0..1024, &|_| true, instructions),
            bins
        );
    }
    for threads in [1, 3] {
        assert_eq!(on_threads(threads, || Bins::walk(forest, BinLayout::FINEST.turned(0.3), &|_| true)), bins);
    }
    assert_ne!(Bins::walk(forest, BinLayout::FINEST.turned(0.4), &|_| true), bins, "negative control: another turn");
}

#[test]
fn layers_together_are_the_whole_walk() {
    let Furnished { forest, .. } = furnished(1024);
    let forest = forest.discs();
    let layer = |of: u32| Bins::walk(forest, BinLayout::FINEST, &move |object| object == of);
    let whole = Bins::walk(forest, BinLayout::FINEST, &|_| true);
    assert_eq!(layer(0).nearer(&layer(1)).nearer(&layer(2)), whole);
    assert_ne!(layer(0).nearer(&layer(1)), whole, "negative control: one layer is missing");
}

#[test]
fn some_leaves_alone_see_what_they_see_among_all() {
    let Furnished { forest, .. } = furnished(1024);
    let forest = forest.discs();
    let whole = Bins::walk(forest, BinLayout::FINEST, &|_| true);
    let some = Bins::of_leaves(forest, BinLayout::FINEST, 100..200, &|_| true);
    assert!((100..200).all(|leaf| some.of_leaf(leaf) == whole.of_leaf(leaf)));
}

/// The nearest leaf in each cell by testing all leaves (implicit visibility, 3.1).
fn by_all_leaves(forest: &DiscForest, leaf: usize) -> Vec<u32> {
    let alone = DiscForest::new(&vec![1; forest.discs().len()], forest.discs().to_vec());
    Bins::of_leaves(&alone, BinLayout::FINEST, leaf as u32..leaf as u32 + 1, &|_| true)
        .of_leaf(leaf as u32)
        .iter()
        .map(|&key| node_of(key))
        .collect()
}

/// Share of the bins filled by both in which the same leaf is nearest, or a node at about its distance.
fn share_of_same(forest: &DiscForest, bins: &Bins) -> f32 {
    let (mut same, mut all) = (0, 0);
    for leaf in (0..forest.discs().len()).step_by(37) {
        let from = forest.discs()[leaf].position;
        for (&key, nearest) in bins.of_leaf(leaf as u32).iter().zip(by_all_leaves(forest, leaf)) {
            if key != EMPTY && nearest < forest.discs().len() as u32 {
                let (node, disc) = (forest.node(node_of(key)), forest.discs()[nearest as usize]);
                let apart = (node.center.distance(from) - disc.position.distance(from)).abs();
                same += usize::from(apart <= node.radius + disc.radius());
                all += 1;
            }
        }
    }
    same as f32 / all as f32
}

#[test]
fn the_nearest_in_each_bin_is_that_of_all_leaves() {
    let Furnished { forest, .. } = furnished(1024);
    let forest = forest.discs();
    let share = share_of_same(forest, &Bins::walk(forest, BinLayout::FINEST, &|_| true));
    assert!(share > 0.99, "{share}");
    let without = share_of_same(forest, &Bins::walk(forest, BinLayout::FINEST, &|object| object == 0));
    assert!(without < 0.97, "negative control: without what stands in the room, {without}");
}

#[test]
fn distant_objects_are_seen_as_nodes() {
    let Furnished { forest, .. } = furnished(4096);
    let forest = forest.discs();
    let bins = Bins::walk(forest, BinLayout::FINEST, &|_| true);
    let keys = (0..4096).flat_map(|leaf| bins.of_leaf(leaf)).filter(|&&key| key != EMPTY);
    let inner = keys.filter(|&&key| matches!(forest.shape().slot(node_of(key)), Slot::Inner(_))).count();
    assert!(inner > 4096 * 40, "{inner} bins of 1.6 million");
}
