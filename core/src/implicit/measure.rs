//! Times of implicit visibility, printed: `cargo test --release -p lapidary-core --lib implicit::measure -- --ignored --nocapture`.

use super::{
    tests::{Furnished, crowded, furnished},
    *,
};
use glam::Vec3;
use std::time::Instant;

/// The least time of some runs in milliseconds, which other load on the machine affects least.
fn least_ms(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let begin = Instant::now();
        run();
        begin.elapsed().as_secs_f64() * 1e3
    };
    (0..7).map(once).fold(f64::INFINITY, f64::min)
}

const HEAD: &str = "update, walk, views, one bounce, together, drag frame in ms; nanoseconds together / (N log2 N)";

/// Prints the timings of a scene; its last object is dragged.
fn print_times(label: u32, scene: Furnished) {
    let Furnished { mesh, mut forest } = scene;
    let update = least_ms(|| forest.update(&mesh.positions, &|_| true));
    let discs = forest.discs();
    let surfels = discs.discs().len();
    let walk = least_ms(|| drop(Bins::walk(discs, BinLayout::FINEST, &|_| true)));
    let bins = Bins::walk(discs, BinLayout::FINEST, &|_| true);
    let copy = least_ms(|| drop(bins.clone()));
    let closing = least_ms(|| drop(bins.clone().views())) - copy;
    let views = bins.views();
    let gray = vec![Vec3::splat(0.5); surfels];
    let lighting = Lighting { reflectance: &gray, emitted: &gray, received: &gray, sky: &|_| Vec3::ONE };
    let bounce = least_ms(|| drop(LeafLight::new(discs, &views, &lighting, 1)));
    let drag = Drag::begin(discs, BinLayout::FINEST, [discs.shape().trees().len() as u32 - 1].into());
    let frame = least_ms(|| drop(drag.frame(discs)));
    let together = update + walk + closing + bounce;
    let n = surfels as f64;
    let growth = 1e6 * together / (n * n.log2());
    println!("{label}: {update:.2} {walk:.1} {closing:.1} {bounce:.1} {together:.1} {frame:.1}; {growth:.0}");
}

#[test]
#[ignore = "prints times"]
fn times_of_four_sizes() {
    println!("surfels: {HEAD}");
    for surfels in [4096, 8192, 16_384, 32_768] {
        print_times(surfels, furnished(surfels));
    }
}

#[test]
#[ignore = "prints times"]
fn times_of_four_numbers_of_objects() {
    println!("objects of 8,192 surfels: {HEAD}");
    for objects in [1, 16, 128, 1024] {
        print_times(objects, crowded(objects - 1, 8192));
    }
}
