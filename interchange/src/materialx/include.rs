//! Documents that a document includes (`xi:include`): their elements take the place of the inclusion.

use super::{
    places::{Composed, Places, Run, lines},
    read::{MOST_BYTES, MaterialXError, parsed},
};
use quick_xml::escape::escape;
use roxmltree::Node;
use std::rc::Rc;

/// Largest number of documents within each other.
const MOST_DEPTH: usize = 8;

/// Largest number of inclusions.
const MOST_INCLUSIONS: usize = 256;

/// The documents around one, and the memory for them. Errors are reasons why a document is left out.
pub(crate) trait Library {
    /// The text of a document, by its path from the folder of the first.
    fn read(&mut self, path: &str) -> Result<String, String>;

    /// Takes bytes before they are allocated.
    fn take(&mut self, bytes: usize) -> Result<(), String>;
}

/// A document with all that it includes.
pub(crate) struct Expanded {
    pub text: String,
    /// Remarks on documents that are left out.
    pub remarks: Vec<String>,
    /// Where its lines come from.
    pub places: Rc<Places>,
}

impl Expanded {
    /// A document that includes nothing.
    pub fn of(text: String) -> Self {
        Self { text, remarks: Vec::new(), places: Rc::default() }
    }
}

/// Includes the documents that `text` names.
///
/// # Errors
/// A text that is not XML.
pub(crate) fn expanded(text: String, library: &mut impl Library) -> Result<Expanded, MaterialXError> {
    if !text.contains("include") {
        return Ok(Expanded::of(text));
    }
    let mut includer =
        Includer { library, inclusions: 0, bytes: text.len(), documents: Vec::new(), remarks: Vec::new() };
    let whole = includer.expanded(&text, "", None, 0)?;
    let places = Rc::new(Places { documents: includer.documents, runs: whole.runs });
    Ok(Expanded { text: whole.text, remarks: includer.remarks, places })
}

struct Includer<'a, L> {
    library: &'a mut L,
    inclusions: usize,
    /// Bytes of all texts so far.
    bytes: usize,
    /// Paths of the included documents.
    documents: Vec<String>,
    remarks: Vec<String>,
}

impl<L: Library> Includer<'_, L> {
    /// The text of a document with its inclusions, which are relative to `folder`.
    fn expanded(
        &mut self,
        text: &str,
        folder: &str,
        document: Option<u32>,
        depth: usize,
    ) -> Result<Composed, MaterialXError> {
        parsed(text, |parsed| {
            let (mut whole, mut end, mut line) = (Composed::default(), 0, 1);
            let text = parsed.input_text();
            for inclusion in parsed.root_element().children().filter(|node| node.tag_name().name() == "include") {
                let range = inclusion.range();
                whole.push(&text[end..range.start], document, line);
                let href = inclusion.attribute("href").unwrap_or_default();
                match self.included(&format!("{folder}{}", href.replace('\\', "/")), depth) {
                    Ok(elements) => whole.append(elements),
                    Err(reason) => {
                        self.remarks.push(format!("the document \"{href}\", which it includes, is left out: {reason}"))
                    }
                }
                line += lines(&text[end..range.end]);
                end = range.end;
            }
            whole.push(&text[end..], document, line);
            Ok(whole)
        })
    }

    /// The elements of another document.
    fn included(&mut self, path: &str, depth: usize) -> Result<Composed, String> {
        self.inclusions += 1;
        if depth == MOST_DEPTH || self.inclusions > MOST_INCLUSIONS {
            return Err(format!("more than {MOST_DEPTH} documents include each other, or {MOST_INCLUSIONS} in all"));
        }
        let text = self.library.read(path)?;
        self.library.take(text.len())?;
        let folder = path.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        let document = self.documents.len() as u32;
        self.documents.push(path.to_owned());
        let whole = self.expanded(&text, &folder, Some(document), depth + 1).map_err(|error| error.to_string())?;
        let elements = parsed(&whole.text, |document| Ok(self.elements(document.root_element(), &folder, &whole.runs)));
        elements.map_err(|error| error.to_string())?
    }

    /// The elements in a root. Each gets the root's color space, and a prefix of files from the root and its folder.
    fn elements(&mut self, root: Node, folder: &str, runs: &[Run]) -> Result<Composed, String> {
        let prefix = format!("{folder}{}", root.attribute("fileprefix").unwrap_or_default());
        let space = root.attribute("colorspace").unwrap_or_default();
        let inherited = [("fileprefix", prefix.as_str()), ("colorspace", space)]
            .map(|(name, value)| (name, value, format!(" {name}=\"{}\"", escape(value))));
        let (mut all, mut end, mut line) = (Composed::default(), 0, 1);
        for element in root.children().filter(Node::is_element) {
            let (whole, range) = (root.document().input_text(), element.range());
            line += lines(&whole[end..range.start]);
            let text = &whole[range.clone()];
            let is_missing =
                |(name, value, _): &&(&str, &str, String)| !value.is_empty() && !element.has_attribute(*name);
            let missing = || inherited.iter().filter(is_missing).map(|(.., attribute)| attribute.as_str());
            self.grow(text.len() + missing().map(str::len).sum::<usize>())?;
            let name = text.find(|c: char| c.is_whitespace() || "/>".contains(c)).unwrap_or(text.len());
            let parts: Vec<&str> = [&text[..name]].into_iter().chain(missing()).chain([&text[name..]]).collect();
            let (document, line_there) = Run::origin(runs, line);
            all.push(&parts.concat(), document, line_there);
            line += lines(text);
            end = range.end;
        }
        Ok(all)
    }

    /// Counts the text of an element before it is made. The root's attributes are repeated on each element, so a short document
    /// can have a long text.
    fn grow(&mut self, bytes: usize) -> Result<(), String> {
        self.bytes += bytes;
        if self.bytes > MOST_BYTES {
            return Err(format!("together they have more than {} MB", MOST_BYTES >> 20));
        }
        // It is held twice: among the elements of its document, and in the one that includes it.
        self.library.take(2 * (bytes + size_of::<Run>()))
    }
}

#[cfg(test)]
mod tests;
