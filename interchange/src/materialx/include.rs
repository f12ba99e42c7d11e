//! Documents that a document includes (`xi:include`): their elements take the place of the inclusion.

use super::read::{MOST_BYTES, MaterialXError, parsed};
use quick_xml::escape::escape;
use roxmltree::Node;

/// Largest number of documents within each other.
const MOST_DEPTH: usize = 8;

/// Largest number of inclusions.
const MOST_INCLUSIONS: usize = 256;

/// A document with all that it includes.
pub(crate) struct Expanded {
    pub text: String,
    /// Remarks on documents that are left out.
    pub remarks: Vec<String>,
}

/// Includes the documents that `text` names. `read` gives the text of one by its path from the folder of the first, or
/// the reason why it is not read. Lines of the first document keep their numbers.
///
/// # Errors
/// A text that is not XML.
pub(crate) fn expanded(
    text: String,
    read: impl FnMut(&str) -> Result<String, String>,
) -> Result<Expanded, MaterialXError> {
    if !text.contains("include") {
        return Ok(Expanded { text, remarks: Vec::new() });
    }
    let mut includer = Includer { read, inclusions: 0, bytes: text.len(), remarks: Vec::new() };
    let text = includer.expanded(&text, "", 0)?;
    Ok(Expanded { text, remarks: includer.remarks })
}

struct Includer<R> {
    read: R,
    inclusions: usize,
    /// Bytes of all texts so far.
    bytes: usize,
    remarks: Vec<String>,
}

impl<R: FnMut(&str) -> Result<String, String>> Includer<R> {
    /// The text with its inclusions, which are relative to `folder`.
    fn expanded(&mut self, text: &str, folder: &str, depth: usize) -> Result<String, MaterialXError> {
        parsed(text, |document| {
            let (mut whole, mut end) = (String::new(), 0);
            let text = document.input_text();
            for inclusion in document.root_element().children().filter(|node| node.tag_name().name() == "include") {
                let range = inclusion.range();
                whole += &text[end..range.start];
                let href = inclusion.attribute("href").unwrap_or_default();
                match self.included(&format!("{folder}{}", href.replace('\\', "/")), depth) {
                    Ok(elements) => whole += &elements,
                    Err(reason) => {
                        self.remarks.push(format!("the document \"{href}\", which it includes, is left out: {reason}"))
                    }
                }
                // An inclusion may take several lines.
                whole.extend(text[range.clone()].chars().filter(|c| *c == '\n'));
                end = range.end;
            }
            Ok(whole + &text[end..])
        })
    }

    /// The elements of another document, on one line.
    fn included(&mut self, path: &str, depth: usize) -> Result<String, String> {
        self.inclusions += 1;
        if depth == MOST_DEPTH || self.inclusions > MOST_INCLUSIONS {
            return Err(format!("more than {MOST_DEPTH} documents include each other, or {MOST_INCLUSIONS} in all"));
        }
        let text = (self.read)(path)?;
        let folder = path.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        let text = self.expanded(&text, &folder, depth + 1).map_err(|error| error.to_string())?;
        self.bytes += text.len();
        if self.bytes > MOST_BYTES {
            return Err(format!("together they have more than {} MB", MOST_BYTES >> 20));
        }
        let elements = parsed(&text, |document| Ok(elements(document.root_element(), &folder)));
        elements.map_err(|error| error.to_string())
    }
}

/// The text of the elements in a root. Each gets the root's color space, and a prefix of files from the root and its folder.
fn elements(root: Node, folder: &str) -> String {
    let prefix = format!("{folder}{}", root.attribute("fileprefix").unwrap_or_default());
    let inherited = [("fileprefix", prefix.as_str()), ("colorspace", root.attribute("colorspace").unwrap_or_default())];
    let mut all = String::new();
    for element in root.children().filter(Node::is_element) {
        let text = &root.document().input_text()[element.range()];
        let name = text.find(|c: char| c.is_whitespace() || "/>".contains(c)).unwrap_or(text.len());
        all += &text[..name];
        for (attribute, value) in inherited {
            if !value.is_empty() && !element.has_attribute(attribute) {
                all += &format!(" {attribute}=\"{}\"", escape(value));
            }
        }
        all += &text[name..];
    }
    all.replace(['\n', '\r'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    fn of(files: &[(&str, &str)]) -> Result<Expanded, MaterialXError> {
        let files: HashMap<&str, &str> = files.iter().copied().collect();
        expanded(files["main"].to_owned(), |path| {
            files.get(path).map(|text| (*text).to_owned()).ok_or_else(|| format!("{path} is not there"))
        })
    }

    const MAIN: &str = "<materialx>\n<xi:include\n href=\"lib/a.mtlx\"/>\n<own/></materialx>";

    #[test]
    fn elements_take_the_place_of_their_inclusion_with_prefix_and_color_space() {
        let a = "<?xml version=\"1.0\"?><materialx fileprefix=\"t&amp;x/\" colorspace=\"srgb_texture\" \
            xmlns:xi=\"http://www.w3.org/2001/XInclude\"><xi:include href=\"b.mtlx\"/><image name=\"i\"/>\n\
            <g colorspace=\"raw\">\n</g></materialx>";
        let found = of(&[("main", MAIN), ("lib/a.mtlx", a), ("lib/b.mtlx", "<materialx><b/></materialx>")]).unwrap();
        assert_eq!(found.remarks, [""; 0]);
        let image = "<image fileprefix=\"lib/t&amp;x/\" colorspace=\"srgb_texture\" name=\"i\"/>";
        assert!(found.text.contains(image), "{}", found.text);
        assert!(found.text.contains("<b colorspace=\"srgb_texture\" fileprefix=\"lib/\"/>"), "{}", found.text);
        assert!(found.text.contains("<g fileprefix=\"lib/t&amp;x/\" colorspace=\"raw\">"), "{}", found.text);
        let line = |text: &str| text.lines().position(|line| line.contains("<own"));
        assert_eq!((line(&found.text), line(MAIN)), (Some(3), Some(3)), "lines keep their numbers");
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
}
