//! Folders of preferences, autosaves and caches, by the conventions of each system.

use anyhow::{Context, Result};
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

/// Folders of the program; they need not exist yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folders {
    /// Preferences and lists, worth a backup.
    pub config: PathBuf,
    /// Autosaves: belong to this machine.
    pub state: PathBuf,
    /// Files that can be made again.
    pub cache: PathBuf,
}

/// Conventions for folders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum System {
    /// The XDG base directory specification.
    Xdg,
    MacOs,
    Windows,
}

impl Folders {
    /// Automatic bakes.
    pub fn bakes(&self) -> PathBuf {
        self.cache.join("bakes")
    }

    /// Compiled pipelines of graphics adapters.
    pub fn pipelines(&self) -> PathBuf {
        self.cache.join("pipelines")
    }

    /// Below `LAPIDARY_HOME` if set, else in the system's places.
    ///
    /// # Errors
    /// An environment without a home folder.
    pub fn find() -> Result<Self> {
        let system = if cfg!(windows) {
            System::Windows
        } else if cfg!(target_os = "macos") {
            System::MacOs
        } else {
            System::Xdg
        };
        Self::from_variables(system, |name| std::env::var_os(name)).context(
            "this user has no home folder, so preferences and autosaves cannot be kept; set the variable LAPIDARY_HOME to \
             a folder for them",
        )
    }

    fn from_variables(system: System, variable: impl Fn(&str) -> Option<OsString>) -> Option<Self> {
        let folder = |name: &str| variable(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        if let Some(home) = folder("LAPIDARY_HOME") {
            return Some(Self::below(&std::path::absolute(&home).unwrap_or(home)));
        }
        match system {
            System::Xdg => Self::xdg(folder),
            System::MacOs => folder("HOME").map(|home| {
                let support = home.join("Library/Application Support/Lapidary");
                Self { state: support.join("state"), config: support, cache: home.join("Library/Caches/Lapidary") }
            }),
            System::Windows => {
                let home = |below: &str| folder("USERPROFILE").map(|home| home.join("AppData").join(below));
                let config = folder("APPDATA").or_else(|| home("Roaming"))?.join("Lapidary");
                let local = folder("LOCALAPPDATA").or_else(|| home("Local"))?.join("Lapidary");
                Some(Self { config, state: local.join("state"), cache: local.join("cache") })
            }
        }
    }

    fn below(home: &Path) -> Self {
        Self { config: home.join("config"), state: home.join("state"), cache: home.join("cache") }
    }

    fn xdg(folder: impl Fn(&str) -> Option<PathBuf>) -> Option<Self> {
        let place = |name: &str, default: &str| {
            // The specification requires relative paths to be ignored.
            let given = folder(name).filter(|path| path.is_absolute());
            given.or_else(|| folder("HOME").map(|home| home.join(default))).map(|place| place.join("lapidary"))
        };
        Some(Self {
            config: place("XDG_CONFIG_HOME", ".config")?,
            state: place("XDG_STATE_HOME", ".local/state")?,
            cache: place("XDG_CACHE_HOME", ".cache")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folders(system: System, variables: &[(&str, &str)]) -> Option<[String; 3]> {
        let value = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| OsString::from(v));
        let text = |path: PathBuf| path.to_string_lossy().replace('\\', "/");
        Folders::from_variables(system, value).map(|f| [f.config, f.state, f.cache].map(text))
    }

    #[test]
    #[cfg(unix)]
    fn one_variable_overrides_all_systems() {
        for system in [System::Xdg, System::MacOs, System::Windows] {
            let found = folders(system, &[("LAPIDARY_HOME", "/l"), ("HOME", "/h"), ("XDG_CONFIG_HOME", "/c")]);
            assert_eq!(found.unwrap(), ["/l/config", "/l/state", "/l/cache"]);
        }
    }

    #[test]
    #[cfg(unix)]
    fn xdg_variables_count_if_they_are_absolute_and_not_empty() {
        let home = ("HOME", "/h");
        let found =
            folders(System::Xdg, &[home, ("XDG_CONFIG_HOME", "/c"), ("XDG_STATE_HOME", ""), ("LAPIDARY_HOME", "")]);
        assert_eq!(found.unwrap(), ["/c/lapidary", "/h/.local/state/lapidary", "/h/.cache/lapidary"]);
        let found = folders(System::Xdg, &[home, ("XDG_CACHE_HOME", "here")]);
        assert_eq!(found.unwrap()[2], "/h/.cache/lapidary");
        assert!(folders(System::Xdg, &[("XDG_CONFIG_HOME", "/c")]).is_none());
    }

    #[test]
    fn the_other_systems_have_their_own_places() {
        let mac = folders(System::MacOs, &[("HOME", "/Users/a")]).unwrap();
        assert_eq!(mac[0], "/Users/a/Library/Application Support/Lapidary");
        assert_eq!(mac[2], "/Users/a/Library/Caches/Lapidary");
        let windows = folders(System::Windows, &[("APPDATA", "C:/r"), ("USERPROFILE", "C:/Users/a")]).unwrap();
        assert_eq!(windows[..2], ["C:/r/Lapidary", "C:/Users/a/AppData/Local/Lapidary/state"]);
        assert!(folders(System::Windows, &[("HOME", "/h")]).is_none());
    }
}
