//! Times of implicit visibility, printed: `cargo test --release -p lapidary-core --lib implicit::measure -- --ignored --nocapture`.

use super::{
    bins::CubeBins,
    links::{Links, VertexForest},
    tests::{Furnished, furnished, tessellated},
    *,
};
use glam::Vec3;
use std::time::Instant;

/// The least of some runs in milliseconds, which others on the machine disturb least.
fn least_ms(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let begin = Instant::now();
        run();
        begin.elapsed().as_secs_f64() * 1e3
    };
    (0..7).map(once).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "prints times"]
fn times_of_four_sizes() {
    println!("surfels, build, update, walk, views, one bounce, together, drag frame in ms");
    for surfels in [4096, 8192, 16384, 32768] {
        let begin = Instant::now();
        let Furnished { mesh, mut forest } = furnished(surfels);
        let build = begin.elapsed().as_secs_f64() * 1e3;
        let update = least_ms(|| forest.update(&mesh.positions, &|_| true));
        let discs = forest.discs();
        let walk = least_ms(|| drop(Bins::walk(discs, 0.0, &|_| true)));
        let bins = Bins::walk(discs, 0.0, &|_| true);
        let copy = least_ms(|| drop(bins.clone()));
        let closing = least_ms(|| drop(bins.clone().views())) - copy;
        let views = bins.views();
        let grey = vec![Vec3::splat(0.5); surfels as usize];
        let lighting = Lighting { reflectance: &grey, emitted: &grey, received: &grey, sky: &|_| Vec3::ONE };
        let bounce = least_ms(|| drop(LeafLight::new(discs, &views, &lighting, 1)));
        let drag = Drag::begin(discs, 0.0, [2].into());
        let frame = least_ms(|| drop(drag.frame(discs)));
        let together = update + walk + closing + bounce;
        println!("{surfels} {build:.0} {update:.2} {walk:.1} {closing:.1} {bounce:.1} {together:.1} {frame:.1}");
    }
}

#[test]
#[ignore = "prints times"]
fn table_1_of_the_paper() {
    let mesh = tessellated(23);
    let begin = Instant::now();
    let mut forest = VertexForest::new(&mesh);
    println!("{} vertices, hierarchy {:.0} ms", mesh.positions.len(), begin.elapsed().as_secs_f64() * 1e3);
    let update = least_ms(|| forest.update(&mesh));
    println!("side, update, links, refine and push down, one bounce in ms, MB");
    for side in [8, 12, 16] {
        let (discs, bins) = (&forest.discs, CubeBins { side });
        let create = least_ms(|| drop(Links::create(discs, bins)));
        let links = Links::create(discs, bins);
        let copy = least_ms(|| drop(links.clone()));
        let push = least_ms(|| links.clone().refine_and_push_down(discs)) - copy;
        let mut pushed = links.clone();
        pushed.refine_and_push_down(discs);
        let grey = vec![glam::Vec3A::splat(0.5); discs.discs().len()];
        let light = least_ms(|| drop(pushed.irradiance(discs, &discs.pull(&grey), &|_| Vec3::ONE)));
        let mb = (discs.shape().nodes() * bins.len() * 8) as f64 / 1e6;
        println!("{side} {update:.1} {create:.0} {push:.0} {:.0} {mb:.0}", 2.0 * light);
    }
}
