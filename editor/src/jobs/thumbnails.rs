//! Small pictures for the library, made one after another on a thread, each once.

use egui::ColorImage;
use lapidary_studies::jobs::{Wake, guarded, spawn};
use std::{
    collections::HashSet,
    sync::mpsc::{Receiver, Sender, channel},
};

/// A small picture, or why there is none.
pub type Thumbnail = Result<ColorImage, String>;

/// Makes pictures for keys: paths and formulas.
pub struct Thumbnails {
    keys: Sender<String>,
    ready: Receiver<(String, Thumbnail)>,
    requested: HashSet<String>,
}

impl Thumbnails {
    /// Starts the thread that runs `make`; it ends with this.
    pub fn start(make: impl Fn(&str) -> anyhow::Result<ColorImage> + Send + 'static, wake: Wake) -> Self {
        let (keys, queue) = channel::<String>();
        let (sender, ready) = channel();
        spawn("thumbnails", move || {
            for key in queue {
                let thumbnail = guarded("drawing the thumbnail", || make(&key));
                if sender.send((key, thumbnail)).is_err() {
                    return;
                }
                wake();
            }
        });
        Self { keys, ready, requested: HashSet::new() }
    }

    /// Asks for a picture. May be called every frame: each is made once.
    pub fn request(&mut self, key: &str) {
        if self.requested.insert(key.to_owned()) {
            // The thread ends only with this.
            let _ = self.keys.send(key.to_owned());
        }
    }

    /// Makes pictures again at their next request, since their files have changed.
    pub fn forget(&mut self, is_stale: impl Fn(&str) -> bool) {
        self.requested.retain(|key| !is_stale(key));
    }

    /// Pictures made since the last call, with their keys.
    pub fn ready(&mut self) -> Vec<(String, Thumbnail)> {
        self.ready.try_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Color32;
    use lapidary_studies::jobs::testing::{silent, wait_for};

    /// A picture as wide as the key is long.
    fn make(key: &str) -> anyhow::Result<ColorImage> {
        match key {
            "missing" => anyhow::bail!("no such file"),
            "odd" => panic!("a mistake"),
            _ => Ok(ColorImage::filled([key.len(), 1], Color32::WHITE)),
        }
    }

    fn collect(thumbnails: &mut Thumbnails, count: usize) -> Vec<(String, Thumbnail)> {
        let mut ready = Vec::new();
        wait_for("the thumbnails", || {
            ready.extend(thumbnails.ready());
            (ready.len() >= count).then_some(())
        });
        ready
    }

    #[test]
    fn each_is_made_once_in_order_and_failures_stop_nothing() {
        let mut thumbnails = Thumbnails::start(make, silent());
        for key in ["abc", "missing", "odd", "abc", "ab"] {
            thumbnails.request(key);
        }
        let ready = collect(&mut thumbnails, 4);
        let keys: Vec<&str> = ready.iter().map(|(key, _)| key.as_str()).collect();
        assert_eq!(keys, ["abc", "missing", "odd", "ab"]);
        let width = |i: usize| ready[i].1.as_ref().map(|image| image.size[0]);
        assert_eq!((width(0), width(3)), (Ok(3), Ok(2)));
        assert_eq!(ready[1].1.as_ref().unwrap_err(), "no such file");
        assert!(ready[2].1.as_ref().unwrap_err().contains("a mistake"));
    }

    #[test]
    fn a_forgotten_one_is_made_again() {
        let mut thumbnails = Thumbnails::start(make, silent());
        thumbnails.request("abc");
        collect(&mut thumbnails, 1);
        thumbnails.request("abc");
        thumbnails.forget(|key| key == "abc");
        thumbnails.request("abc");
        assert_eq!(collect(&mut thumbnails, 1).len(), 1);
    }
}
