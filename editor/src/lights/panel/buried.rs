//! Finds lights inside an object, which light nothing visible, and whether the selected one lights anything in view. Searches the
//! visible rows only, and again only when a light, the scene or the view has changed.

use lapidary_core::lights::Light;
use lapidary_render::{Baked, View, is_buried, lights_view};
use std::collections::HashMap;

/// Warning on such a light.
pub const NOTICE: &str = "This light is inside an object or a wall and lights nothing visible. Move it out.";

/// Warning on a light whose light does not reach the view.
pub const LIGHTS_NOTHING: &str = "This light reaches nothing that the camera sees. Move it or aim it elsewhere.";

/// Results, by index in the list of lights.
#[derive(Default)]
pub struct Buried {
    scene: Option<Baked>,
    found: HashMap<usize, (Light, bool)>,
    /// Whether a light lights nothing in a view.
    in_view: Option<(Light, View, bool)>,
}

impl Buried {
    /// Whether the light at `index` is inside an object; false until known.
    pub fn contains(&mut self, scene: Option<&Baked>, index: usize, light: &Light) -> bool {
        let Some((scene, intersector)) = scene.and_then(|s| Some((s, s.intersector_if_ready()?))) else { return false };
        if !self.scene.as_ref().is_some_and(|known| known.is_same(scene)) {
            *self = Self { scene: Some(scene.clone()), ..Self::default() };
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

    /// Whether a light lights nothing in a view; false until known.
    pub fn lights_nothing(&mut self, scene: Option<&Baked>, light: &Light, view: &View) -> bool {
        let Some((scene, intersector)) = scene.and_then(|s| Some((s, s.intersector_if_ready()?))) else { return false };
        match &self.in_view {
            Some((of, seen, found)) if of == light && seen == view => *found,
            _ => {
                let found = !lights_view(&scene.dataset, intersector, light, view);
                self.in_view = Some((light.clone(), view.clone(), found));
                found
            }
        }
    }
}
