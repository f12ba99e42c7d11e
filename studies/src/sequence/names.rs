//! File names of frames: `####` in a path stands for the number.

use anyhow::{Result, bail};
use lapidary_interchange::formats::{FileFormat, PictureFormat};
use std::path::{Path, PathBuf};

/// The files of a sequence in one format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameNames {
    folder: PathBuf,
    before: String,
    digits: usize,
    /// Text after the number, including the extension.
    after: String,
}

impl FrameNames {
    /// From a path whose file name has one run of `#`, such as `shots/frame.####.png`.
    ///
    /// # Errors
    /// A name without such a run or with several, or with the extension of no writable format.
    pub fn new(path: &Path) -> Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (Some(first), Some(last)) = (name.find('#'), name.rfind('#')) else {
            bail!(
                "the name of a sequence needs a place for the frame's number: write ####, as in frame.####.png ({})",
                path.display()
            );
        };
        let (before, after) = (&name[..first], &name[last + 1..]);
        if name[first..=last].contains(|c| c != '#') {
            bail!("the name of a sequence has one place for the frame's number, not several ({})", path.display());
        }
        // Test the whole path, because an extension alone counts as a name.
        if !after.contains('.') || !PictureFormat::of(path).is_some_and(PictureFormat::is_written) {
            bail!("frames are png, exr or hdr files; end the name in one of these ({})", path.display());
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok(Self { folder: folder.into(), before: before.into(), digits: last + 1 - first, after: after.into() })
    }

    /// The folder of all frames.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file of a frame, with a zero-padded number.
    pub fn path(&self, frame: u32) -> PathBuf {
        let Self { before, after, digits, .. } = self;
        self.folder.join(format!("{before}{frame:0digits$}{after}"))
    }

    /// The file that describes each frame.
    pub fn record_path(&self) -> PathBuf {
        let stem = self.before.trim_end_matches(['.', '_', '-', ' ']);
        self.folder.join(format!("{}.json", if stem.is_empty() { "sequence" } else { stem }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(path: &str) -> FrameNames {
        FrameNames::new(Path::new(path)).unwrap()
    }

    #[test]
    fn numbers_take_the_place_of_the_run() {
        assert_eq!(names("a/frame.####.png").path(7), Path::new("a/frame.0007.png"));
        assert_eq!(names("turn_##.v2.EXR").path(123), Path::new("./turn_123.v2.EXR"), "more digits than places");
        assert_eq!(names("####.exr").path(1), Path::new("./0001.exr"));
        assert_eq!(names("a/frame.####.png").record_path(), Path::new("a/frame.json"));
        assert_eq!(names("a/####.png").record_path(), Path::new("a/sequence.json"));
    }

    #[test]
    fn names_without_a_place_or_format_say_what_is_missing() {
        let message = |path: &str| FrameNames::new(Path::new(path)).unwrap_err().to_string();
        for bad in ["frame.png", "a/", "fra#me/x.png", ""] {
            assert!(message(bad).contains("####"), "{bad}");
        }
        assert!(message("a##b##.png").contains("not several"));
        for bad in ["frame.####", "frame.####.gif", "frame.####png"] {
            assert!(message(bad).contains("png, exr or hdr"), "{bad}");
        }
    }
}
