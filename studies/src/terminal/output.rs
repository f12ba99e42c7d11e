//! Output of commands: text, one-line errors, JSON.

use super::with_options;
use anyhow::{Context, Result};
use std::io::Write;

/// Prints to standard output. A closed reader is not an error, a full disk is.
///
/// # Errors
/// Standard output cannot be written.
pub fn print_out(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// An error and its causes in one line, with helpful options. Most of our errors include their cause, which is not repeated.
pub fn error_text(error: &anyhow::Error) -> String {
    let mut causes = error.chain().map(with_options);
    let mut text = causes.next().unwrap_or_default();
    for cause in causes {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// A value as indented JSON with a newline.
///
/// # Errors
/// A value that JSON cannot represent.
pub fn json_text(value: &impl serde::Serialize) -> Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// Writes a value as indented JSON, atomically.
///
/// # Errors
/// An unwritable file.
pub fn write_json(path: &std::path::Path, value: &impl serde::Serialize) -> Result<()> {
    lapidary_core::output::write_atomically(path, json_text(value)?.as_bytes())
        .with_context(|| format!("cannot write {}; check the folder and the free space", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_told_once() {
        let cause = || anyhow::anyhow!("no space left");
        assert_eq!(error_text(&cause().context("cannot write")), "cannot write: no space left");
        assert_eq!(
            error_text(&cause().context("cannot write: no space left (a.cuts)")),
            "cannot write: no space left (a.cuts)"
        );
    }
}
