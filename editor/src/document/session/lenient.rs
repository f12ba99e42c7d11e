//! Reads JSON that people and other versions write, value by value over a template, so that one bad value spoils no other. Unknown
//! keys are kept for writing back.

use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Map, Value};

/// Keys of a file that this version does not know, in the shape of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unknown(pub(super) Map<String, Value>);

impl Unknown {
    /// Adds the keys that `written` lacks.
    pub(super) fn merge_into(&self, written: &mut Map<String, Value>) {
        merge_objects(written, &self.0);
    }
}

fn merge_objects(written: &mut Map<String, Value>, unknown: &Map<String, Value>) {
    for (key, value) in unknown {
        match (written.get_mut(key), value) {
            (None, value) => {
                written.insert(key.clone(), value.clone());
            }
            (Some(Value::Object(written)), Value::Object(unknown)) => merge_objects(written, unknown),
            (Some(Value::Array(written)), Value::Array(unknown)) => merge_lists(written, unknown),
            _ => {}
        }
    }
}

/// Matches entries by name, preferably in the same place.
fn merge_lists(written: &mut [Value], unknown: &[Value]) {
    for (i, entry) in written.iter_mut().enumerate() {
        let same = |other: &&Value| other.get("name") == entry.get("name");
        let found = unknown.get(i).filter(same).or_else(|| unknown.iter().find(same));
        if let (Some(Value::Object(found)), Value::Object(entry)) = (found.cloned(), entry) {
            merge_objects(entry, &found);
        }
    }
}

/// `template` with all valid values of `given`, and the keys of `given` that it lacks. Nested objects are read the same
/// way. `at` is the position of `given` in warnings.
pub fn read_leniently<T: Serialize + DeserializeOwned>(
    given: &Value,
    template: T,
    at: &str,
    warnings: &mut Vec<String>,
) -> (T, Map<String, Value>) {
    let Value::Object(given) = given else {
        warnings.push(refusal(if at.is_empty() { "the whole" } else { at }, given));
        return (template, Map::new());
    };
    let root = serde_json::to_value(&template).expect("parts of a session have text as keys");
    let mut overlay = Overlay { root, accepts: |root: &Value| T::deserialize(root).is_ok(), warnings };
    let unknown = overlay.object(given, "", at);
    let read = T::deserialize(&overlay.root).unwrap_or(template);
    (read, unknown)
}

/// Text of a warning about an invalid value.
pub(super) fn refusal(at: &str, given: &Value) -> String {
    let mut text = given.to_string();
    if let Some((end, _)) = text.char_indices().nth(40) {
        text.truncate(end);
        text.push_str("...");
    }
    format!("{at} cannot be {text}; the default is used")
}

struct Overlay<'a, F> {
    root: Value,
    accepts: F,
    warnings: &'a mut Vec<String>,
}

impl<F: Fn(&Value) -> bool> Overlay<'_, F> {
    /// Puts the values of `given` in their places below `pointer`; returns those without a place.
    fn object(&mut self, given: &Map<String, Value>, pointer: &str, at: &str) -> Map<String, Value> {
        let mut unknown = Map::new();
        for (key, value) in given {
            let pointer = format!("{pointer}/{}", key.replace('~', "~0").replace('/', "~1"));
            let at = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
            match (self.root.pointer_mut(&pointer), value) {
                (None, value) => {
                    unknown.insert(key.clone(), value.clone());
                }
                (Some(Value::Object(_)), Value::Object(inner)) => {
                    let inner = self.object(inner, &pointer, &at);
                    if !inner.is_empty() {
                        unknown.insert(key.clone(), inner.into());
                    }
                }
                (Some(_), value) => self.replace(value, &pointer, &at),
            }
        }
        unknown
    }

    fn replace(&mut self, value: &Value, pointer: &str, at: &str) {
        let Some(place) = self.root.pointer_mut(pointer) else { return };
        let before = std::mem::replace(place, value.clone());
        if (self.accepts)(&self.root) {
            return;
        }
        self.warnings.push(refusal(at, value));
        if let Some(place) = self.root.pointer_mut(pointer) {
            *place = before;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::ViewSettings;
    use serde_json::json;

    #[test]
    fn one_bad_value_costs_no_other_and_unknown_keys_are_kept() {
        let given = json!({
            "aa": "many", "illum_cut": 64, "lens": {"f": 2}, "post": {"exposure": 1.5, "tone_map": "sepia", "grain": 1},
            "post/exposure": 7,
        });
        let mut warnings = Vec::new();
        let (view, unknown) = read_leniently(&given, ViewSettings::default(), "view", &mut warnings);
        assert_eq!((view.aa, view.illum_cut, view.post.exposure), (16, 64, 1.5));
        assert_eq!(Value::from(unknown), json!({"lens": {"f": 2}, "post": {"grain": 1}, "post/exposure": 7}));
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert_eq!(warnings[0], "view.aa cannot be \"many\"; the default is used");
        assert!(warnings[1].starts_with("view.post.tone_map"));
    }

    #[test]
    fn what_is_no_object_is_refused_as_a_whole() {
        let mut warnings = Vec::new();
        let long = "x".repeat(100);
        let (view, _) = read_leniently(&json!([long]), ViewSettings::default(), "view", &mut warnings);
        assert_eq!(view, ViewSettings::default());
        assert!(warnings[0].len() < 90, "{warnings:?}");
    }

    #[test]
    fn list_entries_are_merged_by_name() {
        let unknown = json!({"materials": [{"name": "a", "coat": 1}, {"name": "b", "coat": 2}]});
        let Value::Object(unknown) = unknown else { unreachable!() };
        let mut written = Map::new();
        written.insert("materials".into(), json!([{"name": "b"}, {"name": "c"}, {"name": "a", "coat": 9}]));
        Unknown(unknown).merge_into(&mut written);
        assert_eq!(written["materials"], json!([{"name": "b", "coat": 2}, {"name": "c"}, {"name": "a", "coat": 9}]));
    }
}
