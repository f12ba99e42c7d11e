//! All settings of a picture of a baked scene, and the work for a change of look.

use crate::{
    Appearance, Backplate, Baked, BrdfSampling, Components, Illumination, Marks, Pixels, Post, Renderer, Solution,
    Stale, View, ViewMode, light::situation::Changes, shade::background::caught_per_radiance,
};
use lapidary_core::{
    cut::lit::DEFAULT_TAU,
    ground::Ground,
    lights::Light,
    material::Material,
    scene::{Scene, pose::Poses},
};
use std::sync::Arc;

/// All settings of a picture of a baked scene. Clones share texels and maps.
#[derive(Clone, Debug)]
pub struct Look {
    /// Objects away from their baked place.
    pub poses: Poses,
    /// Materials and textures.
    pub appearance: Appearance,
    /// The environment with rotation and intensity; its map is compared by address.
    pub illumination: Illumination,
    /// Local lights.
    pub lights: Arc<[Light]>,
    /// Light components in the picture.
    pub components: Components,
    /// How bounced light is computed; the dataset must have this solution.
    pub solution: Solution,
    /// Most nodes of the illumination cut, for sampling without lit cuts.
    pub illum_cut: u32,
    /// Largest share of a vertex's light that a node of its lit cut moves, for [`BrdfSampling::Lit`]; 0 keeps the stored cuts.
    pub tau: f32,
    /// How the BRDF is sampled.
    pub sampling: BrdfSampling,
    /// Camera, size, samples per pixel, and the background.
    pub view: View,
    /// Exposure and tone curve of the display; scene-linear files ignore them.
    pub post: Post,
    /// A picture behind a transparent picture, in files of display values.
    pub backplate: Option<Arc<Backplate>>,
}

impl Look {
    /// Whether the ground, if any, catches shadows over the background.
    pub fn catches_shadows(&self) -> bool {
        let Illumination { environment, intensity, .. } = &self.illumination;
        caught_per_radiance(&self.view, environment, *intensity, self.components.environment).is_some()
    }

    /// Solution of bounced light in its picture: a view of one shows that one's own.
    pub fn shown_solution(&self) -> Solution {
        match self.view.mode {
            ViewMode::Gloss => Solution::CutsGloss,
            mode if mode.is_of_basis() => Solution::Meshless,
            _ => self.solution,
        }
    }

    /// A renderer for the scene with the look's materials and poses, or in its baked poses if these are invalid; missing materials
    /// and maps are replaced.
    pub fn renderer(&self, baked: &Baked) -> Renderer {
        let mut renderer = Renderer::new(baked.posed(&self.poses).unwrap_or_else(|_| baked.clone()));
        renderer.set_appearance(self.appearance.fitted(&renderer.dataset.scene.materials).0);
        renderer
    }

    /// A scene as baked, under an environment alone, with an illumination cut of 256 nodes.
    pub fn under_environment(scene: &Scene, view: View, illumination: Illumination) -> Self {
        Self {
            poses: Poses::default(),
            appearance: Appearance::of(scene),
            illumination,
            lights: Arc::default(),
            components: Components { environment: true, ..Components::NONE },
            solution: Solution::default(),
            illum_cut: 256,
            tau: DEFAULT_TAU,
            sampling: BrdfSampling::default(),
            view,
            post: Post::default(),
            backplate: None,
        }
    }
}

/// Work of a renderer for another look. Each step needs the earlier ones, and only set steps are redone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Redo {
    /// The scene's lighting. After a pose the renderer gets everything again.
    pub light: Changes,
    /// The shown light: components, and the solution of bounced light.
    pub shown: bool,
    /// Another picture under the same light: another camera, size, background or quantity.
    pub view: bool,
    /// Pixels (deferred pass and merge), by shown surface and part of the light.
    pub pixels: Stale,
    /// Exposure and tone curve over the finished pixels.
    pub display: bool,
}

impl Redo {
    /// Everything, as after opening a scene.
    pub const ALL: Self = Self { light: Changes::ALL, shown: true, view: true, pixels: Stale::ALL, display: true };
    /// Nothing.
    pub const NOTHING: Self =
        Self { light: Changes::NONE, shown: false, view: false, pixels: Stale::NOTHING, display: false };

    /// Work for showing `new` after `old`.
    pub fn between(old: &Look, new: &Look) -> Self {
        // All fields by name, so that no new one is forgotten.
        let Look {
            poses,
            appearance,
            illumination,
            lights,
            components,
            solution,
            illum_cut,
            tau,
            sampling,
            view,
            post,
            // It lies under what is displayed.
            backplate: _,
        } = old;
        let light = Changes {
            poses: *poses != new.poses,
            appearance: !appearance.is_same(&new.appearance),
            // The illumination cut belongs to the environment's light, and sources and senders receive light through it.
            environment: !illumination.is_same(&new.illumination) || *illum_cut != new.illum_cut,
            lights: *lights != new.lights,
            gathering: (*illum_cut, *tau) != (new.illum_cut, new.tau),
            // `LitScene` takes it at rest.
            eye: false,
        };
        let shown =
            *components != new.components || *solution != new.solution || old.shown_solution() != new.shown_solution();
        let is_new = light.poses || *sampling != new.sampling;
        let pixels = if is_new { Stale::ALL } else { Self::stale(old, new, light) };
        let view = *view != new.view;
        let display = view || pixels.any() || *post != new.post;
        Self { light, shown, view, pixels, display }
    }

    /// Whether anything must be rendered.
    pub fn renders(self) -> bool {
        self.view || self.pixels.any()
    }

    /// Samples that are invalid even in the same view.
    fn stale(old: &Look, new: &Look, changes: Changes) -> Stale {
        let Components { environment, direct, indirect } = new.components;
        let looks = Self::changed_looks(old, new);
        let (sky, lights) = (changes.environment || changes.gathering, changes.lights);
        // A ground that catches shadows reflects the background, and is an ordinary surface without an environment.
        let catches = new.view.ground == Ground::Shadow;
        let ground = catches && (sky || environment != old.components.environment);
        let bounced = sky || lights || old.solution != new.solution;
        // Emission is shown with local lights, but summed with the values that need no merge.
        let shines = || new.appearance.materials.iter().any(Material::shines);
        let lamps = direct != old.components.direct && shines();
        let background = environment != old.components.environment || environment && sky || lamps;
        Stale {
            environment: looks.and(Pixels::all_if(background)),
            // `LitScene` adds the pixels that the light of a changed material reaches.
            bounce: looks.and(Pixels::all_if(indirect != old.components.indirect || indirect && (bounced || ground))),
            direct: looks.and(Pixels::all_if(direct != old.components.direct || direct && ground)),
            lights: direct && lights || Self::shows_other_suns(old, new, changes),
            surfaces: old.appearance.opacities() != new.appearance.opacities(),
        }
    }

    /// Whether the shown suns differ.
    fn shows_other_suns(old: &Look, new: &Look, changes: Changes) -> bool {
        let may_differ = changes.environment || old.components.environment != new.components.environment;
        let shown = |look: &Look| if look.components.environment { look.illumination.suns() } else { Vec::new() };
        may_differ && shown(old) != shown(new)
    }

    /// Pixels that show a changed material.
    fn changed_looks(old: &Look, new: &Look) -> Pixels {
        match old.appearance.changed_materials(&new.appearance) {
            None => Pixels::All,
            Some(changed) if changed.is_empty() => Pixels::Nothing,
            Some(changed) => Pixels::Showing(Marks::of_materials(changed)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Background, test_looks::look};
    use lapidary_core::{
        environment::Environment,
        image::Image,
        scene::pose::Pose,
        texture::{Texels, Texture},
    };
    use std::sync::Arc;

    /// Steps redone after an edit of a look.
    fn redone(edit: impl FnOnce(&mut Look)) -> Redo {
        let old = look();
        let mut new = old.clone();
        edit(&mut new);
        Redo::between(&old, &new)
    }

    #[test]
    fn an_edit_redoes_what_depends_on_it_and_nothing_else() {
        const DISPLAY: Redo = Redo { display: true, ..Redo::NOTHING };
        const VIEW: Redo = Redo { view: true, ..DISPLAY };
        let shown = |pixels| Redo { shown: true, pixels, ..DISPLAY };
        let changed = |light, pixels| Redo { light, pixels, ..DISPLAY };
        let all = |environment, bounce, direct| {
            let [environment, bounce, direct] = [environment, bounce, direct].map(Pixels::all_if);
            Stale { environment, bounce, direct, ..Stale::NOTHING }
        };
        let sky = |light| changed(light, all(true, true, false));
        let [environment, gathering] =
            [sky(Changes { environment: true, ..Changes::NONE }), sky(Changes { gathering: true, ..Changes::NONE })];
        let cut = sky(Changes { environment: true, gathering: true, ..Changes::NONE });
        assert_eq!(redone(|_| ()), Redo::NOTHING);
        assert_eq!(
            redone(|look| look.poses.set(0, Pose { scale: 2.0, ..Pose::AS_BAKED })),
            changed(Changes { poses: true, ..Changes::NONE }, Stale::ALL)
        );
        assert_eq!(redone(|look| look.post.exposure = 1.0), DISPLAY);
        assert_eq!(redone(|look| look.view.camera.eye.x += 1.0), VIEW);
        assert_eq!(redone(|look| look.view.aa = 4), VIEW);
        assert_eq!(redone(|look| look.view.background = Background::Transparent), VIEW);
        assert_eq!(redone(|look| look.sampling = BrdfSampling::Once), Redo { pixels: Stale::ALL, ..DISPLAY });
        assert_eq!(redone(|look| look.components.environment = false), shown(all(true, false, false)));
        assert_eq!(redone(|look| look.components.indirect = false), shown(all(false, true, false)));
        assert_eq!(redone(|look| look.components.direct = false), shown(all(false, false, true)));
        assert_eq!(redone(|look| look.solution = Solution::Meshless), shown(all(false, true, false)));
        let lights = Stale { lights: true, ..all(false, true, false) };
        let lit = Changes { lights: true, ..Changes::NONE };
        assert_eq!(redone(|look| look.lights = Arc::default()), changed(lit, lights));
        assert_eq!(redone(|look| look.illumination.rotation += 0.1), environment);
        assert_eq!(
            redone(|look| look.illumination.environment = Arc::new((*look.illumination.environment).clone())),
            environment
        );
        assert_eq!(redone(|look| look.illum_cut = 7), cut);
        assert_eq!(redone(|look| look.tau = 0.5), gathering);
    }

    #[test]
    fn what_shines_is_shown_with_local_lights() {
        let before = look();
        let mut lamp = before.clone();
        lamp.appearance.materials[0].set_emission(glam::Vec3::ONE);
        let mut without = lamp.clone();
        without.components.direct = false;
        assert_eq!(Redo::between(&lamp, &without).pixels.environment, Pixels::All);
        let shown = Pixels::Showing(Marks::of_materials([0]));
        assert_eq!(Redo::between(&before, &lamp).pixels.environment, shown, "a lamp that is switched on");
        let dark = redone(|look| look.components.direct = false);
        assert_eq!(dark.pixels.environment, Pixels::Nothing, "negative control: nothing shines");
    }

    #[test]
    fn suns_move_with_their_environment() {
        let size = [256, 128];
        let sunny = Image::from_fn(size, |x, y| glam::Vec3::splat(if (x, y) == (9, 40) { 1e6 } else { 1.0 }));
        let mut old = look();
        old.illumination.environment = Arc::new(Environment::new("sunny".into(), sunny));
        old.illumination.sun = Some(Default::default());
        let lights = |edit: fn(&mut Look)| {
            let mut new = old.clone();
            edit(&mut new);
            Redo::between(&old, &new).pixels.lights
        };
        assert!(lights(|look| look.illumination.rotation += 0.1) && lights(|look| look.illumination.sun = None));
        assert!(lights(|look| look.components.environment = false));
        assert!(!lights(|look| look.view.camera.eye.x += 1.0) && !lights(|look| look.components.indirect = false));
        old.illumination.sun = None;
        let turned = Look { illumination: Illumination { rotation: 1.0, ..old.illumination.clone() }, ..old.clone() };
        assert!(!Redo::between(&old, &turned).pixels.lights, "negative control");
    }

    #[test]
    fn a_material_concerns_the_pixels_that_show_it() {
        let showing = |materials: &[usize]| {
            let pixels = Pixels::Showing(Marks::of_materials(materials.iter().copied()));
            Stale { environment: pixels, bounce: pixels, direct: pixels, ..Stale::NOTHING }
        };
        let light = Changes { appearance: true, ..Changes::NONE };
        let appearance = |pixels| Redo { light, pixels, display: true, ..Redo::NOTHING };
        let rough = redone(|look| look.appearance.materials[1].parameters.set("roughness", 0.1));
        assert_eq!(rough, appearance(showing(&[1])));
        // Both maps had no picture.
        let texture = Texture::new("t", [1, 1], Texels::F32(vec![[0.5; 4]]));
        let mapped = redone(|look| look.appearance.textures = vec![Arc::new(texture)]);
        assert_eq!(mapped, appearance(showing(&[0, 1])));
        assert_eq!(
            redone(|look| look.appearance.materials.truncate(1)),
            appearance(Stale { lights: false, ..Stale::ALL })
        );
    }

    #[test]
    fn equal_lights_and_materials_in_another_place_are_the_same() {
        let same = redone(|look| {
            look.lights = look.lights.to_vec().into();
            look.appearance.materials = look.appearance.materials.to_vec();
        });
        assert_eq!(same, Redo::NOTHING);
    }
}
