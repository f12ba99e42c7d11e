//! The ball's light if no environment is in the picture: a neutral studio, so that a material can always be judged.

use lapidary_core::light_tree::LightTree;
use lapidary_interchange::environment;
use lapidary_render::{EnvironmentLight, Illumination, LightRig};
use std::sync::{Arc, OnceLock};

/// Samples of the studio's light, and most nodes of its cut: its lamps are large.
const LIGHTS: usize = 4096;
const CUT: u32 = 256;
/// Keeps white paint below white.
const INTENSITY: f32 = 0.6;

/// The studio under which the ball stands. Made at the first use, in some hundredths of a second.
pub fn light() -> Option<Arc<EnvironmentLight>> {
    static LIGHT: OnceLock<Option<Arc<EnvironmentLight>>> = OnceLock::new();
    LIGHT.get_or_init(make).clone()
}

fn make() -> Option<Arc<EnvironmentLight>> {
    let tree = LightTree::geometric(LIGHTS).ok()?;
    let (environment, _) = environment::from_spec("studio").ok()?;
    let illumination =
        Illumination { environment: Arc::new(environment), rotation: 0.0, intensity: INTENSITY, sun: None };
    Some(LightRig::new(&tree).lighting(&illumination, CUT).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_studio_is_bright_and_made_once() {
        let studio = light().unwrap();
        assert!(studio.nodes.radiance[1].min_element() > 0.05, "{}", studio.nodes.radiance[1]);
        assert!(Arc::ptr_eq(&studio, &light().unwrap()));
    }
}
