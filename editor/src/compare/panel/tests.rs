//! Requests of the strip, and positions of regions.

use super::*;
use lapidary_render::test_looks::plain_look;
use lapidary_studies::ladder::Cuts;

#[test]
fn a_region_moves_out_to_the_grid_and_stays_inside() {
    let panel = |region| ComparisonPanel { region: Some(region), ..Default::default() };
    let of = |region, size| panel(region).region_of(size);
    assert_eq!(of([0.26, 0.5, 0.49, 0.74], [100, 60]), Some(Region { x: 24, y: 28, width: 28, height: 20 }));
    assert_eq!(of([0.9, 0.9, 1.0, 1.0], [30, 30]), Some(Region { x: 24, y: 24, width: 6, height: 6 }));
    assert_eq!(of([0.5, 0.5, 0.5, 0.5], [40, 40]), Some(Region { x: 20, y: 20, width: 4, height: 4 }), "never empty");
    assert_eq!(of([-3.0, f32::NAN, 7.0, 9.0], [16, 16]), Some(Region { x: 0, y: 0, width: 16, height: 16 }));
    assert_eq!(ComparisonPanel::default().region_of([40, 40]), None);
    // A square file in a viewport twice as wide: the middle half of the viewport is all of its width.
    let inner = panel([0.25, 0.0, 0.75, 0.5]);
    assert_eq!(inner.region_in([40, 40], 2.0), Some(Region { x: 0, y: 0, width: 40, height: 24 }));
    assert_eq!(inner.region_in([80, 40], 2.0), inner.region_of([80, 40]), "of the viewport's shape");
}

#[test]
fn the_size_of_the_comparison_is_a_part_of_the_live_picture() {
    let mut panel = ComparisonPanel { region: Some([0.0, 0.0, 0.5, 0.5]), ..Default::default() };
    let asked = panel.request(None, plain_look(4)).unwrap();
    assert_eq!((asked.size(), asked.kind.clone()), ([16, 12], ReferenceKind::Samples));
    assert_eq!(asked.region, Some(Region { x: 0, y: 0, width: 12, height: 8 }));
    panel.kind = KindChoice::File;
    assert!(panel.request(None, plain_look(4)).is_none(), "no file was chosen");
    panel.file = Some("truth.exr".into());
    let asked = panel.request(None, plain_look(4)).unwrap();
    assert_eq!((asked.kind, asked.region), (ReferenceKind::File("truth.exr".into()), None), "a file has its own size");
}

#[test]
fn labels_say_what_both_sides_are() {
    let image = std::sync::Arc::new(lapidary_core::image::Image::filled([2, 2], glam::Vec3::ONE));
    let mut reference = ReferencePicture { image, step: 2, noise: None, finished: false, seconds: 1.0 };
    let mut panel = ComparisonPanel { kind: KindChoice::Paths, spp: 256, ..Default::default() };
    assert_eq!(panel.picture_label(Cuts::Once(64)), "A: illumination cut of 64 nodes");
    assert_eq!(panel.picture_label(Cuts::Lit(0.003)), "A: lit cuts");
    let label = panel.reference_label(&reference, Some(0.0213), 0.5);
    assert_eq!(label, "B: 256 light paths per pixel, noise 2.1 %, 50 % done");
    reference.finished = true;
    assert!(!panel.reference_label(&reference, None, 1.0).contains("done"));
    (panel.kind, panel.file) = (KindChoice::File, Some("/a/b/truth.exr".into()));
    assert_eq!(panel.reference_label(&reference, None, 1.0), "B: truth.exr");
}
