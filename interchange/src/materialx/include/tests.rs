use super::*;
use std::collections::HashMap;

/// Documents by their paths, and the bytes that are left for them.
struct Shelf<'a>(HashMap<&'a str, &'a str>, usize);

impl Library for Shelf<'_> {
    fn read(&mut self, path: &str) -> Result<String, String> {
        self.0.get(path).map(|text| (*text).to_owned()).ok_or_else(|| format!("{path} is not there"))
    }

    fn take(&mut self, bytes: usize) -> Result<(), String> {
        self.1 = self.1.checked_sub(bytes).ok_or("no room")?;
        Ok(())
    }
}

fn within(bytes: usize, files: &[(&str, &str)]) -> Result<Expanded, MaterialXError> {
    let mut shelf = Shelf(files.iter().copied().collect(), bytes);
    expanded(shelf.0["main"].to_owned(), &mut shelf)
}

fn of(files: &[(&str, &str)]) -> Result<Expanded, MaterialXError> {
    within(1 << 20, files)
}

const MAIN: &str = "<materialx>\n<xi:include\n href=\"lib/a.mtlx\"/>\n<own/></materialx>";

#[test]
fn elements_take_the_place_of_their_inclusion_with_prefix_and_color_space() {
    let a = "<?xml version=\"1.0\"?><materialx fileprefix=\"t&amp;x/\" colorspace=\"srgb_texture\" \
        xmlns:xi=\"http://www.w3.org/2001/XInclude\"><xi:include href=\"b.mtlx\"/><image name=\"i\"/>\n\
        <g colorspace=\"raw\">\n</g></materialx>";
    let found = of(&[("main", MAIN), ("lib/a.mtlx", a), ("lib/b.mtlx", "<materialx>\n<b/></materialx>")]).unwrap();
    assert_eq!(found.remarks, [""; 0]);
    let image = "<image fileprefix=\"lib/t&amp;x/\" colorspace=\"srgb_texture\" name=\"i\"/>";
    assert!(found.text.contains(image), "{}", found.text);
    assert!(found.text.contains("<b colorspace=\"srgb_texture\" fileprefix=\"lib/\"/>"), "{}", found.text);
    assert!(found.text.contains("<g fileprefix=\"lib/t&amp;x/\" colorspace=\"raw\">"), "{}", found.text);
    let place = |part: &str| {
        let line = found.text.lines().position(|line| line.contains(part)).unwrap();
        found.places.words(line as u32 + 1)
    };
    assert_eq!([place("<materialx"), place("<own")], ["line 1", "line 4"]);
    assert_eq!([place("<b "), place("<image")], ["line 2 of \"lib/b.mtlx\"", "line 1 of \"lib/a.mtlx\""]);
    assert_eq!([place("<g "), place("</g>")], ["line 2 of \"lib/a.mtlx\"", "line 3 of \"lib/a.mtlx\""]);
}

#[test]
fn circles_missing_and_damaged_documents_are_left_out_by_name() {
    let remarks = |a: &str| {
        let found = of(&[("main", MAIN), ("lib/a.mtlx", a)]).unwrap();
        assert!(found.text.contains("<own/>") && found.text.len() < 1000, "{}", found.text);
        found.remarks.join("\n")
    };
    let circle = remarks("<materialx><xi:include href=\"a.mtlx\"/><xi:include href=\"a.mtlx\"/></materialx>");
    assert!(circle.contains("include each other") && circle.lines().count() <= MOST_INCLUSIONS, "{circle}");
    let missing = remarks("<materialx><xi:include href=\"c.mtlx\"/></materialx>");
    assert_eq!(missing, "the document \"c.mtlx\", which it includes, is left out: lib/c.mtlx is not there");
    assert!(remarks("<materialx><a></materialx>").contains("line 1: it is not well-formed"));
    assert_eq!(remarks("<materialx/>"), "", "negative control");
    assert!(of(&[("main", "<include")]).is_err());
}

#[test]
fn what_elements_inherit_is_counted_before_it_is_repeated() {
    let prefix = "a".repeat(100_000);
    let document = |count: usize| format!("<materialx fileprefix=\"{prefix}\">{}</materialx>", "<a/>".repeat(count));
    let remarks = |count: usize, bytes: usize| {
        let found = within(bytes, &[("main", MAIN), ("lib/a.mtlx", &document(count))]).unwrap();
        assert!(found.text.len() < 2_000_000 && found.text.contains("<own/>"));
        found.remarks.join("\n")
    };
    // Of 100 MB, of 2 MB in a smaller room, and of 1 MB.
    assert!(remarks(1000, usize::MAX).contains("together they have more than 64 MB"));
    assert!(remarks(20, 2_000_000).ends_with("is left out: no room"));
    assert_eq!(remarks(10, 4_000_000), "", "negative control");
}
