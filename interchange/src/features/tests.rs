use super::*;
use std::{fs, path::Path};

/// The lines around the table in the guide.
const AROUND: [&str; 2] = ["<!-- features: made by the test guide_has_the_table -->\n", "<!-- end of features -->\n"];

/// With this environment variable the test writes the guide.
const WRITE: &str = "LAPIDARY_WRITE_GUIDE";

#[test]
fn guide_has_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/guide.md");
    let guide = fs::read_to_string(&path).unwrap();
    let [(before, rest), (_, after)] = AROUND.map(|line| guide.split_once(line).expect("a guide with a place for it"));
    let made = format!("{before}{}{}{}{after}", AROUND[0], table(), AROUND[1]);
    assert!(rest.contains(AROUND[1]));
    if std::env::var_os(WRITE).is_some() {
        fs::write(&path, made).unwrap();
        return;
    }
    assert!(
        made == guide,
        "the table of features in docs/guide.md is old; run: {WRITE}=1 cargo test -p lapidary-interchange guide_has_the_table"
    );
}

#[test]
fn every_format_has_features_and_no_word_is_in_two_of_them() {
    for format in Format::ALL {
        let features: Vec<Feature> = all().filter(|feature| feature.format == format).collect();
        assert!(features.iter().any(|feature| feature.support == Support::Read), "{format:?}");
        if format == Format::MaterialX {
            continue; // Surfaces share names of inputs.
        }
        let mut known = HashSet::new();
        for key in features.iter().flat_map(|feature| feature.keys.split_whitespace()) {
            assert!(known.insert(key.to_ascii_lowercase()), "{format:?} has `{key}` twice");
        }
    }
}

#[test]
fn lost_features_are_told_in_a_sentence() {
    let of = |support| Feature { format: Format::Gltf, keys: "A b", name: "horns", support };
    let names = ["x".to_owned()];
    assert_eq!(
        of(Support::LeftOut("cut them")).warning("materials", &names).unwrap(),
        "the materials \"x\" have horns, which are left out; cut them"
    );
    assert_eq!(
        of(Support::Approximated("which show as dots")).warning("nodes", &names).unwrap(),
        "the nodes \"x\" have horns, which show as dots"
    );
    assert_eq!(of(Support::LeftOut("cut them")).warning("materials", &[]), None);
    assert_eq!([Support::Read, Support::Unneeded("none")].map(|s| of(s).warning("nodes", &names)), [None, None]);
    assert!(of(Support::Read).has("B") && !of(Support::Read).has("c"));
}
