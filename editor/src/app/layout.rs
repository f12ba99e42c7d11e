//! The layout: menus and tools at the top, the scene on the left, the inspector on the right, one status line at the
//! bottom, and the picture in the remaining area.

use super::{
    keyboard_map,
    keys::{self, Command},
    menus, notice,
    side_panels::{self, Edge},
    state::EditorState,
    status, toolbar,
};
use crate::{
    actions::Action,
    compare::{
        self,
        panel::{Stage, Subject},
    },
    document::{BackgroundKind, Unlit},
    lights,
    look::illumination,
    looks::{self, LooksContext},
    materials,
    pose::timeline::{self, TimelineContext},
    preferences::Preferences,
    scene::{self, SceneContext},
    view::{self, ViewContext},
    viewport::{self, Behind, ClickFor, ViewportContext, ViewportResponse, compare::Compared},
    workspace::{BakeStage, Inspector, Side, Tabs},
};
use egui::{CentralPanel, Frame, Margin, Panel, Rect, ScrollArea, Ui, pos2};
use lapidary_core::{dataset::BakeParts, lights::Light, material::Material};
use lapidary_render::{Baked, Illumination, Tier, ViewMode};

/// Least height of the comparison's strip in points, without and with its figures: two rows and four, the first of which may be
/// broken.
const STRIP: [(&str, f32); 2] = [("comparison", 84.0), ("comparison with figures", 160.0)];

/// Layout of a frame.
pub struct Laid {
    /// The viewport.
    pub viewport: ViewportResponse,
    /// The menu bar, if one of its menus is open.
    pub menus: Option<Rect>,
}

/// Shows everything.
pub fn show(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) -> Laid {
    let viewport_rect = state.interface.viewport_rect;
    let over_viewport = ui.input(|i| i.pointer.latest_pos().is_some_and(|p| viewport_rect.contains(p)));
    if keys::tab_pressed(ui.ctx(), over_viewport) {
        state.command(Command::TogglePanels, actions);
    }
    let menus = Panel::top("menus").show(ui, |ui| menus::show(ui, state, actions));
    let menus = menus.inner.then_some(menus.response.rect);
    Panel::bottom("status").show(ui, |ui| status::show(ui, state));
    let sides = if state.work.tabs.panels_hidden {
        None
    } else {
        Panel::top("tools").show(ui, |ui| toolbar::show(ui, state, actions));
        Some(if side_panels::are_strips(ui.ctx()) { show_strips(ui, state) } else { show_columns(ui, state, actions) })
    };
    let is_scrubbing = !state.work.tabs.panels_hidden && show_timeline(ui, state, actions);
    if state.comparison.panel.open {
        // Its height does not follow its contents: another size of the viewport would restart the reference.
        let (id, height) = STRIP[usize::from(state.comparison.panel.advanced)];
        let strip = Panel::bottom(id).resizable(true).default_size(height).size_range(height..=3.0 * height);
        strip.show(ui, |ui| scrolled(ui, |ui| show_comparison(ui, state, actions)));
    }
    let centre = CentralPanel::default().frame(Frame::NONE);
    let mut viewport = centre.show(ui, |ui| show_viewport(ui, state, actions)).inner;
    state.interface.viewport_rect = viewport.rect;
    state.interface.sides.is_dragged = false;
    match sides {
        Some(_) if side_panels::are_strips(ui.ctx()) => show_unfolded(ui, viewport.rect, state, actions),
        Some(rects) => drag_edges(ui, rects, state, actions),
        None => {}
    }
    viewport.moving |= is_scrubbing;
    viewport.size_px = state.interface.settled_size(ui.ctx(), state.work.viewport_size, viewport.size_px);
    state.work.viewport_size = viewport.size_px;
    if state.interface.keys_open {
        state.interface.keys_open = keyboard_map::show(ui.ctx());
    }
    Laid { viewport, menus }
}

/// Shows both panels beside the picture, and returns where.
fn show_columns(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) -> [Rect; 2] {
    let (panels, room) = (state.interface.sides, ui.available_width());
    let side = side_panels::column(ui, Edge::Left, &panels, room, |ui| show_side(ui, state, actions));
    [side, side_panels::column(ui, Edge::Right, &panels, room, |ui| show_inspector(ui, state, actions))]
}

/// Lets the user drag the inner edges of both panels. Their widths are kept at the end of a drag.
fn drag_edges(ui: &Ui, rects: [Rect; 2], state: &mut EditorState, actions: &mut Vec<Action>) {
    let panels = &mut state.interface.sides;
    let ended = Edge::BOTH.map(|edge| side_panels::drag_edge(ui, edge, panels, rects[edge as usize]));
    if ended.contains(&true) {
        let [side_width, inspector_width] = panels.widths;
        actions.push(Action::prefer(Preferences { side_width, inspector_width, ..state.work.preferences.clone() }));
    }
}

/// Shows the icon strips that replace both panels in a narrow window.
fn show_strips(ui: &mut Ui, state: &mut EditorState) -> [Rect; 2] {
    let Tabs { side, inspector, unfolded: [left, right], .. } = &mut state.work.tabs;
    let tabs = Side::ALL.map(|tab| (tab, tab.label(), side_panels::icon_of_side(tab)));
    let left = side_panels::strip(ui, Edge::Left, left, side, &tabs);
    let tabs = Inspector::ALL.map(|tab| (tab, tab.label(), side_panels::icon_of(tab)));
    [left, side_panels::strip(ui, Edge::Right, right, inspector, &tabs)]
}

/// Shows the panels opened over the picture.
fn show_unfolded(ui: &Ui, picture: Rect, state: &mut EditorState, actions: &mut Vec<Action>) {
    let (panels, [left, right]) = (state.interface.sides, state.work.tabs.unfolded);
    if left {
        side_panels::unfolded(ui.ctx(), Edge::Left, &panels, picture, |ui| show_side(ui, state, actions));
    }
    if right {
        side_panels::unfolded(ui.ctx(), Edge::Right, &panels, picture, |ui| show_inspector(ui, state, actions));
    }
}

fn tabs<T: Copy + PartialEq>(ui: &mut Ui, chosen: &mut T, all: &[(T, &str)]) {
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        for &(tab, label) in all {
            ui.selectable_value(chosen, tab, label);
        }
    });
    ui.separator();
}

fn scrolled(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        // Room for the scroll bar, so that it covers no number.
        Frame::NONE.inner_margin(Margin { right: 8, ..Margin::ZERO }).show(ui, contents);
    });
}

fn show_side(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    tabs(ui, &mut state.work.tabs.side, &Side::ALL.map(|tab| (tab, tab.label())));
    match state.work.tabs.side {
        Side::Scene => {
            let context = SceneContext {
                document: &state.work.document,
                scenes: state
                    .work
                    .scene
                    .source
                    .as_ref()
                    .map_or((&[], None), |source| (&source.report.scenes, source.report.default_scene.as_deref())),
                dataset: state.work.scene.rendered().map(|b| &*b.dataset),
                selected_object: state.work.selection.object,
                other_objects: &state.work.selection.others,
                posable: &state.pose.posable(&state.work),
                placing_pivot: state.pose.placing_pivot,
                selected_material: state.work.selection.material,
            };
            scrolled(ui, |ui| {
                let panel = (&mut state.interface.scene, &mut state.pose.pivot);
                scene::show(ui, panel, &context, actions);
            });
        }
        Side::Looks => {
            let context = LooksContext {
                document: &state.work.document,
                shown: state.work.scene.rendered().map(|baked| (baked, state.pose.poses_since(&state.work, baked))),
                size: state.work.viewport_size,
                factory: &state.work.factory,
                wake: &state.work.wake,
                is_calm: !ui.ctx().input(|input| input.pointer.any_down())
                    && !state.pose.timeline.playing
                    && !state.ladder.is_climbing(),
            };
            scrolled(ui, |ui| looks::show(ui, &mut state.looks, &context, actions));
        }
        Side::Library => {
            scrolled(ui, |ui| state.environments.show_library(ui, &state.work, &state.picture, actions));
        }
    }
}

fn show_inspector(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    tabs(ui, &mut state.work.tabs.inspector, &Inspector::ALL.map(|tab| (tab, tab.label())));
    match state.work.tabs.inspector {
        Inspector::Material => {
            scrolled(ui, |ui| materials::show(ui, &mut state.materials, &state.work, &state.picture, actions))
        }
        Inspector::Environment => scrolled(ui, |ui| {
            lights::environment_hint(ui, &state.work, actions);
            state.environments.show(ui, &state.work, &state.picture, actions);
        }),
        Inspector::Lights => {
            let suns = suns(state);
            let posed = state.pose.posed(&state.work, ui.ctx());
            let posed = posed.as_ref();
            scrolled(ui, |ui| lights::show(ui, &mut state.lights, &state.work, posed, &state.picture, &suns, actions));
        }
        Inspector::View => {
            let context = ViewContext { document: &state.work.document, focusing: state.interface.focusing };
            scrolled(ui, |ui| view::show(ui, &context, actions));
        }
        Inspector::Bake => scrolled(ui, |ui| state.baking.show(ui, &state.work, actions)),
    }
}

/// The suns of the environment as if they were switched on.
fn suns(state: &EditorState) -> Vec<Light> {
    // They shine where the environment does.
    let is_lit = state.work.scene.baked_parts().is_some_and(BakeParts::environment);
    let Some(environment) = state.environments.loaded().filter(|_| is_lit) else { return Vec::new() };
    let mut document = state.work.document.environment.clone();
    document.sun.enabled = true;
    let light = Illumination { sun: document.suns(), ..illumination(&state.work.document, environment.clone()) };
    light.suns()
}

/// Shows the timeline if the scene has clips. Returns whether its position is dragged.
fn show_timeline(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) -> bool {
    let Some(animation) = state.work.scene.animation().cloned() else { return false };
    let trouble = state.pose.trouble_in_time(&state.work);
    let context = TimelineContext { clips: &animation.clips, time: state.work.document.clip_time.as_ref(), trouble };
    let timeline = &mut state.pose.timeline;
    Panel::bottom("timeline").show(ui, |ui| timeline::show(ui, timeline, &context, actions)).inner
}

fn show_comparison(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    let is_moved = |baked: &Baked| !state.pose.poses_since(&state.work, baked).is_empty();
    let stage = match state.work.scene.seen() {
        BakeStage::Unshadowed => Stage::Unshadowed,
        _ if state.work.scene.rendered().is_some_and(is_moved) => Stage::Moved,
        BakeStage::Draft => Stage::Draft,
        BakeStage::Whole => Stage::Baked,
    };
    let (camera, shots) = (&state.work.document.camera, &state.work.document.bake.shots);
    let subject = Subject {
        stage,
        is_baking: state.baking.progress().is_some(),
        can_bake: state.work.scene.source.is_some(),
        camera: Some(camera).filter(|camera| !shots.iter().any(|shot| shot.camera == **camera)),
    };
    state.comparison.show(ui, subject, actions);
}

/// The note over the picture: a preview, a running bake, or opacity that differs from the bake.
fn words_over_picture(state: &EditorState, baked: &Baked) -> Option<&'static str> {
    if !state.pose.poses_since(&state.work, baked).is_empty() {
        let is_solved = state.picture.shown().is_some_and(|shown| shown.tier == Tier::Solved);
        return Some(match (is_solved, state.baking.is_updating()) {
            (true, true) => "Bounced light is solved for the moved objects. Their exact shadows are being baked",
            (true, false) => {
                "Bounced light is solved for the moved objects. Their shadows of the environment are a preview"
            }
            (false, true) => {
                "Preview: implicit visibility. Shadows of moved objects are coarse; exact ones are being baked"
            }
            (false, false) => {
                "Preview: implicit visibility. Shadows of moved objects are coarse; bake again for exact ones"
            }
        });
    }
    let opacity = || {
        let is_other = state.work.document.lets_through_otherwise(&baked.dataset.scene);
        is_other.then_some(match state.baking.is_updating() {
            true => "Opacity was edited; its shadows are being baked",
            false => "Opacity was edited; bake again to update its shadows",
        })
    };
    let shown = baked.dataset.settings.mode;
    state.baking.words(state.work.scene.seen(), shown).or_else(opacity)
}

/// What lies behind the picture: a picture covers the viewport.
fn behind(state: &EditorState) -> Behind {
    let plate = state.picture.backplate.texture();
    match (state.work.document.view.background, plate) {
        (BackgroundKind::Picture, Some((plate, texture))) => {
            let [left, top, right, bottom] = plate.covering(state.work.aspect());
            Behind::Plate(texture.id(), Rect::from_min_max(pos2(left, top), pos2(right, bottom)))
        }
        (BackgroundKind::Picture | BackgroundKind::Transparent, _) => Behind::Checker,
        _ => Behind::Nothing,
    }
}

/// What the next click in the viewport is for.
fn click_for(state: &mut EditorState) -> Option<ClickFor> {
    if state.interface.focusing {
        return Some(ClickFor::Focus);
    }
    if state.work.selected_light().is_some() {
        state.pose.placing_pivot = false;
        return state.lights.aiming.then_some(ClickFor::Aim);
    }
    // A wait for what is not selected any more is over.
    state.pose.placing_pivot &= !state.pose.posable(&state.work).is_empty();
    state.pose.placing_pivot.then_some(ClickFor::Pivot)
}

fn show_viewport(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) -> ViewportResponse {
    let click_for = click_for(state);
    let baked = state.work.scene.rendered();
    let posed = state.pose.posed(&state.work, ui.ctx());
    let mesh = posed.as_ref().map(|posed| &posed.dataset.scene.mesh);
    let busy = baked.and_then(|baked| words_over_picture(state, baked));
    let shown = state.picture.shown().filter(|_| baked.is_some());
    let accent = ui.visuals().selection.bg_fill;
    let compares = state.comparison.panel.open && shown.is_some();
    let size_px = state.work.viewport_size;
    let compared = compares.then(|| Compared {
        explained: state.explain.pixel().map(|pixel| pixel_share(pixel, size_px)),
        marks: state.explain.marks(),
        ..state.comparison.compared(state.work.document.view.cuts(), accent)
    });
    let context = ViewportContext {
        document: &state.work.document,
        picture: shown.and_then(|_| state.picture.texture()).map(|texture| texture.id()),
        picture_size: shown.map_or([1, 1], |s| s.size),
        faded: state.picture.faded(ui.ctx()),
        behind: behind(state),
        mesh,
        intersector: posed.as_ref().and_then(Baked::intersector_if_ready),
        scene_bounds: state.work.bounds.scene,
        selected_objects: state.work.selection.objects().collect(),
        selection_bounds: &state.work.bounds.selection,
        movable: state.pose.movable(&state.work),
        selected_light: state.work.selected_light(),
        shows_lights: state.lights.in_viewport,
        click_for,
        baked: state.work.scene.baked_parts(),
        sources: shown.and_then(|s| s.local.sources()),
        shows_clusters: state.lights.shows_clusters,
        accent,
        busy,
        // Without a picture the notice is shown instead, since it has buttons.
        placeholder: baked.is_none().then_some(""),
        stale: state.work.scene.is_stale(),
        compared,
    };
    let response = viewport::show(ui, &mut state.interface.viewport, &context, actions);
    if compares {
        let asked = compare::interact(ui, response.rect, &mut state.comparison.panel);
        actions.extend(asked.map(|share| Action::ExplainPixel(pixel_at(share, response.size_px))));
    }
    if let Some(unlit) = unlit(state) {
        notice::show_unlit(ui, response.rect, unlit, &mut state.work.tabs, actions);
    }
    if state.work.scene.rendered().is_none() {
        notice::show(ui, response.rect, state, actions);
    } else if state.work.scene.seen() == BakeStage::Unshadowed && state.baking.progress().is_none() {
        notice::show_below(ui, response.rect, state, actions);
    }
    response
}

/// Why the lit picture is black, if it is shown alone.
fn unlit(state: &EditorState) -> Option<Unlit> {
    let (document, baked) = (&state.work.document, state.work.scene.rendered()?);
    let is_alone = document.view.mode == ViewMode::Shaded && !state.comparison.panel.open;
    let shines = document.materials.iter().any(Material::shines);
    let unlit = is_alone.then(|| Unlit::of(&document.lights, shines, document.components, &baked.dataset)).flatten();
    unlit.filter(|_| state.picture.shown().is_some())
}

/// The pixel at a share of the width and height of a picture.
fn pixel_at([x, y]: [f32; 2], [width, height]: [u32; 2]) -> [u32; 2] {
    let pixel = |share: f32, side: u32| ((share * side as f32) as u32).min(side.saturating_sub(1));
    [pixel(x, width), pixel(y, height)]
}

/// The middle of a pixel, in shares of the picture.
fn pixel_share([x, y]: [u32; 2], [width, height]: [u32; 2]) -> [f32; 2] {
    [(x as f32 + 0.5) / width.max(1) as f32, (y as f32 + 0.5) / height.max(1) as f32]
}
