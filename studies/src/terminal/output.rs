//! What commands print and write: text, errors in one line, JSON.

use super::with_options;
use anyhow::{Context, Result};
use std::io::Write;

/// Prints to standard output. A reader that left early is no error, a full disk is.
///
/// # Errors
/// Standard output that cannot be written.
pub fn print_out(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// An error and its causes in one line, with the options that would help. Most of our errors tell their cause themselves;
/// it is not said twice.
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

/// A value as indented JSON and a line's end.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn json_text(value: &impl serde::Serialize) -> Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// Writes a value as indented JSON, atomically.
///
/// # Errors
/// A file that cannot be written.
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
