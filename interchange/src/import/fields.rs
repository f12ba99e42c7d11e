//! JSON of files, with errors that name the field in the user's words.

use serde::{Deserialize, de::IgnoredAny};
use serde_json::{Deserializer, Error, Value, error::Category};

/// Words of `serde` for kinds of values, and ours; the first that begins a text counts.
const KINDS: [(&str, &str); 15] = [
    ("null", "null"),
    ("unit", "null"),
    ("a boolean", "true or false"),
    ("boolean", "true or false"),
    ("map", "an object"),
    ("a map", "an object"),
    ("struct", "an object"),
    ("sequence", "a list"),
    ("a sequence", "a list"),
    ("an array of length", "a list of another length"),
    ("index into", "an index"),
    ("u", "a whole number from 0 on"),
    ("i", "a whole number"),
    ("f", "a number"),
    ("a string", "a text"),
];

/// The value in a JSON text.
///
/// # Errors
/// A text that is no JSON, with its line, or a field of another kind, by its place.
pub(super) fn parse<'a, T: Deserialize<'a>>(text: &'a [u8]) -> Result<T, String> {
    serde_json::from_slice(text).map_err(|error| match error.classify() {
        Category::Eof => format!("its JSON ends too early, in line {}", error.line()),
        _ => {
            let again = serde_path_to_error::deserialize::<_, T>(&mut Deserializer::from_slice(text));
            misfit(again, &error, serde_json::from_slice::<IgnoredAny>(text).is_ok())
        }
    })
}

/// The contents of a JSON value.
///
/// # Errors
/// A field of another kind, by its place.
pub(super) fn contents<'a, T: Deserialize<'a>>(value: &'a Value) -> Result<T, String> {
    T::deserialize(value).map_err(|error| misfit(serde_path_to_error::deserialize::<_, T>(value), &error, true))
}

/// What is wrong with a value that was read again to find the place of its error. Some values of a wrong kind are errors of
/// syntax to `serde_json`, although the whole text is JSON.
fn misfit<T>(again: Result<T, serde_path_to_error::Error<Error>>, error: &Error, is_json: bool) -> String {
    let path = again.err().map(|found| found.path().to_string()).filter(|path| path != ".");
    let place = path.as_ref().map_or_else(|| "it".to_owned(), |path| format!("\"{path}\""));
    let text = error.to_string();
    let text = text.split(" at line ").next().unwrap_or_default();
    if error.is_syntax() {
        return match text {
            "number out of range" => format!("{place} has a number out of range, in line {}", error.line()),
            "trailing characters" if path.is_some() => format!("{place} has more values than it needs"),
            _ if is_json => format!("{place} has a value of another kind than it needs"),
            _ => format!("its JSON is damaged: {error}"),
        };
    }
    if let Some(field) = text.strip_prefix("missing field ") {
        return format!("{place} lacks the field \"{}\"", field.trim_matches('`'));
    }
    let [of_type, of_value] = ["invalid type: ", "invalid value: "].map(|start| text.strip_prefix(start));
    let of_length = text.starts_with("invalid length ").then(|| text.replacen("invalid length", "sequence of", 1));
    match of_type.or(of_value).or(of_length.as_deref()).and_then(|kinds| kinds.split_once(", expected ")) {
        Some((found, expected)) => format!("{place} is {}, where {} is needed", kind(found), kind(expected)),
        None => format!("{place}: {text}"),
    }
}

/// The kind of a value in our words; a value stays as it is.
fn kind(text: &str) -> &str {
    if let Some((_, value)) = text.split_once(' ').filter(|(of, _)| ["string", "integer", "floating"].contains(of)) {
        return value.trim_start_matches("point ").trim_matches('`');
    }
    KINDS.into_iter().find(|(word, _)| text.starts_with(word)).map_or(text, |(_, ours)| ours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Box {
        sides: Vec<u8>,
        #[serde(default)]
        lids: HashMap<String, f32>,
    }

    #[test]
    fn errors_name_the_field_and_what_it_needs() {
        let told = |text: &str| parse::<Box>(text.as_bytes()).unwrap_err();
        assert_eq!(told(r#"{ "sides": [1, "x"] }"#), "\"sides[1]\" is \"x\", where a whole number from 0 on is needed");
        assert_eq!(told(r#"{ "sides": [-1] }"#), "\"sides[0]\" is -1, where a whole number from 0 on is needed");
        assert_eq!(told(r#"{ "sides": {} }"#), "\"sides\" is an object, where a list is needed");
        assert_eq!(told(r#"{ "sides": null }"#), "\"sides\" is null, where a list is needed");
        assert_eq!(
            told(r#"{ "sides": [], "lids": { "a": true } }"#),
            "\"lids.a\" is true or false, where a number is needed"
        );
        assert_eq!(told("[]"), "it is a list, where an object is needed");
        assert_eq!(told(r#"{ "sides": [1e999] }"#), "\"sides[0]\" has a number out of range, in line 1");
        assert_eq!(told("[[], {}] x"), "its JSON is damaged: trailing characters at line 1 column 10");
        assert_eq!(parse::<[[u8; 2]; 1]>(b"[[1, 2, 3]]").unwrap_err(), "\"[0]\" has more values than it needs");
        assert_eq!(told("{}"), "it lacks the field \"sides\"");
        assert_eq!(told("{ \"sides\": [],\n"), "its JSON ends too early, in line 2");
        assert_eq!(told("{ sides }"), "its JSON is damaged: key must be a string at line 1 column 3");
        let unknown = told(r#"{ "sides": [], "lid": 1 }"#);
        assert!(unknown.starts_with("\"lid\": unknown field `lid`, expected"), "{unknown}");
        assert_eq!(parse(b"{ \"sides\": [1] }"), Ok(Box { sides: vec![1], lids: HashMap::new() }), "negative control");
        let value: Value = serde_json::from_str(r#"{ "sides": [0.5] }"#).unwrap();
        assert_eq!(
            contents::<Box>(&value).unwrap_err(),
            "\"sides[0]\" is 0.5, where a whole number from 0 on is needed"
        );
    }
}
