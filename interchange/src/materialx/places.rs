//! The document and line that each line of a document with its inclusions comes from.

/// The origin of the lines of a document. One that includes nothing has its own lines, and no runs.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// Paths of the included documents.
    pub documents: Vec<String>,
    /// In the order of the lines.
    pub runs: Vec<Run>,
}

/// Lines that follow each other in both texts; each run ends where the next begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// Its first line, from 1.
    first: u32,
    /// Index of the included document; `None` for the first one.
    document: Option<u32>,
    /// The line there, from 1.
    line: u32,
}

impl Run {
    /// The document and line that a line comes from.
    pub fn origin(runs: &[Self], line: u32) -> (Option<u32>, u32) {
        let before = runs.partition_point(|run| run.first <= line);
        let run = before.checked_sub(1).map(|last| runs[last]);
        run.map_or((None, line), |run| (run.document, run.line + line - run.first))
    }
}

impl Places {
    /// A line in words, with its document if that is included.
    pub fn words(&self, line: u32) -> String {
        match Run::origin(&self.runs, line) {
            (Some(document), line) => format!("line {line} of \"{}\"", self.documents[document as usize]),
            (None, line) => format!("line {line}"),
        }
    }
}

/// A text of parts of several documents, each line of one.
#[derive(Default)]
pub(super) struct Composed {
    pub text: String,
    pub runs: Vec<Run>,
    /// Line ends in the text.
    ends: u32,
}

impl Composed {
    /// Adds a part that begins on a line of a document.
    pub fn push(&mut self, part: &str, document: Option<u32>, line: u32) {
        self.end_line();
        self.push_run(Run { first: self.ends + 1, document, line });
        self.text.push_str(part);
        self.ends += lines(part);
    }

    /// Adds another text.
    pub fn append(&mut self, other: Self) {
        self.end_line();
        other.runs.iter().for_each(|run| self.push_run(Run { first: self.ends + run.first, ..*run }));
        self.text.push_str(&other.text);
        self.ends += other.ends;
    }

    fn end_line(&mut self) {
        if !self.text.is_empty() && !self.text.ends_with('\n') {
            self.text.push('\n');
            self.ends += 1;
        }
    }

    fn push_run(&mut self, run: Run) {
        if self.runs.is_empty() || Run::origin(&self.runs, run.first) != (run.document, run.line) {
            self.runs.push(run);
        }
    }
}

/// The number of line ends in a text.
pub(super) fn lines(text: &str) -> u32 {
    text.bytes().filter(|byte| *byte == b'\n').count() as u32
}
