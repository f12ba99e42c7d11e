//! Finds lights inside an object, which light nothing visible. Searches the visible rows only, and again only when a light or the
//! scene has changed.

use lapidary_core::lights::Light;
use lapidary_render::{Baked, is_buried};
use std::collections::HashMap;

/// Warning on such a light.
pub const NOTICE: &str = "This light is inside an object or a wall and lights nothing visible. Move it out.";

/// Results, by index in the list of lights.
#[derive(Default)]
pub struct Buried {
    scene: Option<Baked>,
    found: HashMap<usize, (Light, bool)>,
}

impl Buried {
    /// Whether the light at `index` is inside an object; false until known.
    pub fn contains(&mut self, scene: Option<&Baked>, index: usize, light: &Light) -> bool {
        let Some((scene, intersector)) = scene.and_then(|s| Some((s, s.intersector_if_ready()?))) else { return false };
        if !self.scene.as_ref().is_some_and(|known| known.is_same(scene)) {
            *self = Self { scene: Some(scene.clone()), found: HashMap::new() };
        }
        match self.found.get(&index) {
            Some((known, found)) if known == light => *found,
            _ => {
                let found = is_buried(&scene.dataset, intersector, light);
                self.found.insert(index, (light.clone(), found));
                found
            }
        }
    }
}
