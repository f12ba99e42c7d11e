//! Unreadable files are refused, unusable values are replaced, and nothing panics.

use super::*;

impl Project {
    /// The error of reading a file of this text.
    fn error(&self, text: &[u8]) -> SessionError {
        std::fs::write(self.file(), text).unwrap();
        load(&self.file()).unwrap_err()
    }
}

#[test]
fn newer_foreign_and_damaged_files_are_told_apart() {
    let project = Project::new();
    let newer = project.error(br#"{"lapidary_session": 7}"#).to_string();
    assert!(newer.contains("version 7") && newer.contains("up to 2"), "{newer}");
    for text in ["[]", "{}", r#"{"lapidary_session": "1"}"#, r#"{"lapidary_session": 0}"#] {
        assert!(matches!(project.error(text.as_bytes()), SessionError::Foreign { .. }), "{text}");
    }
    let damaged = project.error(b"{\"lapidary_session\": 1,\n \"scene\": NaN}").to_string();
    assert!(damaged.contains("line 2 column 1"), "{damaged}");
    let deep = "[".repeat(100_000);
    assert!(matches!(project.error(deep.as_bytes()), SessionError::Damaged { .. }));
    std::fs::File::create(project.file()).unwrap().set_len(65 << 20).unwrap();
    assert!(load(&project.file()).unwrap_err().to_string().contains("65 MB"));
    assert!(matches!(load(&project.path("none.lapidary")), Err(SessionError::Io { action: "read", .. })));
}

#[test]
fn a_truncated_file_is_refused_at_every_length_and_a_byte_order_mark_is_not_minded() {
    let project = Project::new();
    project.reloaded(&project.document());
    let text = std::fs::read(project.file()).unwrap();
    for length in (0..text.trim_ascii_end().len()).step_by(61) {
        assert!(matches!(project.error(&text[..length]), SessionError::Damaged { .. }), "length {length}");
    }
    std::fs::write(project.file(), [b"\xef\xbb\xbf", text.as_slice()].concat()).unwrap();
    assert!(load(&project.file()).is_ok());
}

#[test]
fn values_out_of_range_are_replaced_with_a_warning_each() {
    let project = Project::new();
    let loaded = project.changed(|json| {
        json["materials"][1]["parameters"]["roughness"] = json!(-4);
        json["materials"][1]["maps"]["bump"]["scale"] = json!([1e39, 2]);
        json["environment"]["intensity"] = json!(-1);
        json["environment"]["rotation_degrees"] = json!(null);
        json["view"]["aa"] = json!(0);
        json["view"]["illum_cut"] = json!(1_000_000);
        json["view"]["post"]["exposure"] = json!("bright");
        json["camera"]["target"] = json["camera"]["eye"].clone();
        json["bookmarks"][0]["fov_y_degrees"] = json!(500);
        json["bake"]["beta"] = json!(9);
        json["scene"] = json!(5);
    });
    assert_eq!(loaded.warnings.len(), 11, "{:#?}", loaded.warnings);
    assert_eq!(loaded.session.camera, None);
    let (document, _) = loaded.into_document(Some(&project.dataset.scene));
    let cloth = &document.materials[1];
    assert_eq!(cloth.parameters.number("roughness"), 0.0);
    assert_eq!(cloth.maps.get("bump").unwrap().scale, Vec2::new(1e6, 2.0));
    assert_eq!((document.environment.intensity, document.environment.rotation_degrees), (0.0, 0.0));
    assert_eq!((document.view.aa, document.view.illum_cut, document.view.post.exposure), (1, 32_768, 0.0));
    assert!((document.bookmarks[0].fov_y.to_degrees() - 170.0).abs() < 1e-3);
    assert_eq!((document.bake.beta, document.scene), (0.5, None));
}

#[test]
fn no_value_in_any_place_panics() {
    fn places(value: &Value, at: String, all: &mut Vec<String>) {
        match value {
            Value::Object(object) => object.iter().for_each(|(key, v)| places(v, format!("{at}/{key}"), all)),
            Value::Array(array) => array.iter().enumerate().for_each(|(i, v)| places(v, format!("{at}/{i}"), all)),
            _ => {}
        }
        all.push(at);
    }
    let project = Project::new();
    project.reloaded(&project.document());
    let (original, mut all) = (project.json(), Vec::new());
    places(&original, String::new(), &mut all);
    assert!(all.len() > 100);
    for (i, place) in all.iter().enumerate() {
        let odd = [json!(null), json!(-1e300), json!("\0"), json!([1, [2]]), json!({"x": {}}), json!(u64::MAX)];
        let mut changed = original.clone();
        *changed.pointer_mut(place).unwrap() = odd[i % odd.len()].clone();
        std::fs::write(project.file(), changed.to_string()).unwrap();
        if let Ok(loaded) = load(&project.file()) {
            let dataset = (i % 2 == 0).then_some(&project.dataset);
            let document = loaded.into_document(dataset.map(|d| &d.scene)).0;
            document.materials.iter().flat_map(|m| m.maps.slots()).for_each(|slot| {
                assert!((slot.texture as usize) < document.textures.len(), "{place}");
            });
        }
    }
}

#[test]
fn a_failed_write_keeps_the_old_file_and_says_what_to_do() {
    let project = Project::new();
    project.reloaded(&project.document());
    let before = std::fs::read(project.file()).unwrap();
    let below_a_file = project.file().join("x.lapidary");
    let error = save(&project.document(), &Unknown::default(), &below_a_file).unwrap_err().to_string();
    assert!(error.contains("permissions") && error.ends_with("x.lapidary)"), "{error}");
    assert_eq!(std::fs::read(project.file()).unwrap(), before);
}

#[test]
fn paths_to_nowhere_in_particular_are_missing_and_no_more() {
    let project = Project::new();
    let loaded = project.changed(|json| json["scene"] = json!("/../..//\0"));
    assert!(loaded.missing.iter().any(|m| m.what == "scene"));
}
