//! The last request is the one that arrives.

use super::*;
use glam::Vec3;
use lapidary_core::image::Image;
use lapidary_interchange::image;
use lapidary_studies::jobs::testing::{silent, wait_for};

fn next(loader: &mut Loader) -> LoadResult {
    wait_for("a file", || loader.results().pop())
}

fn formula(spec: &str) -> Source {
    Source::Environment { spec: spec.into(), color_space: ColorSpace::Srgb }
}

#[test]
fn every_source_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    image::write(&Image::filled([2, 2], Vec3::ONE), &path("t.png")).unwrap();
    std::fs::write(path("m.json"), r#"{"maps": {"base_color": {"file": "t.png"}}}"#).unwrap();
    let mut loader = Loader::new(silent());
    loader.load(Topic::Environment, formula("constant:2"));
    let Ok(Loaded::Environment { environment, .. }) = next(&mut loader).result else { panic!("no environment") };
    assert_eq!(environment.radiance(Vec3::Y), Vec3::splat(2.0));
    loader.load(Topic::Reload(path("t.png")), Source::Texture(path("t.png")));
    let Ok(Loaded::Texture(texture)) = next(&mut loader).result else { panic!("no texture") };
    for (own, expected) in [(Vec::new(), 1), (vec![texture], 1)] {
        let source = Source::Material { path: path("m.json"), textures: own, allow_outside: false };
        loader.load(Topic::Material(0), source);
        let Ok(Loaded::Material { material, textures, .. }) = next(&mut loader).result else { panic!("no material") };
        assert_eq!((material.name.as_str(), textures.len()), ("m", expected));
        assert!(material.maps.get("base_color").is_some());
    }
}

#[test]
fn the_latest_load_on_a_topic_wins_and_topics_are_apart() {
    let mut loader = Loader::new(silent());
    let other = Topic::Map { material: 1, map: "bump" };
    loader.load(other.clone(), Source::Texture("missing.png".into()));
    for i in 1..=5 {
        loader.load(Topic::Environment, formula(&format!("constant:{i}")));
    }
    let mut results = Vec::new();
    wait_for("both topics", || {
        results.extend(loader.results());
        (results.len() == 2).then_some(())
    });
    std::thread::sleep(std::time::Duration::from_millis(50));
    assert!(loader.results().is_empty(), "four were dropped");
    let light = results.iter().find(|r| r.topic == Topic::Environment).unwrap();
    assert_eq!(light.id, 6);
    assert!(matches!(&light.result, Ok(Loaded::Environment { environment, .. }) if environment.name == "constant:5"));
    assert!(results.iter().any(|r| r.topic == other));
}

#[test]
fn errors_say_which_file() {
    let mut loader = Loader::new(silent());
    loader.load(Topic::Environment, formula("missing.hdr"));
    let error = next(&mut loader).result.unwrap_err();
    assert!(error.contains("missing.hdr"), "{error}");
}
