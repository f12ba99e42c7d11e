//! The strip under the viewport: the reference, the view of both pictures, and their differences.

mod figures;
#[cfg(test)]
mod tests;
mod verdict;

pub use verdict::{Stage, Subject};

use crate::{
    actions::{Action, CompareAction, LadderAction},
    viewport::compare::CompareView,
};
use egui::{Align2, Button, ComboBox, DragValue, ProgressBar, Ui, UiBuilder, vec2};
use lapidary_core::image::Region;
use lapidary_render::{Baked, Look, ViewMode, compare::map::ErrorMap};
use lapidary_studies::{
    jobs::{
        comparison::{ComparisonRequest, OtherLook, ReferenceKind, ReferencePicture},
        measure::{Measured, ShownMap},
    },
    ladder::Cuts,
};
use std::path::{Path, PathBuf};

/// Pixels of the live picture along each axis per pixel of the comparison.
const SCALES: [(u32, &str); 4] = [(1, "Full size"), (2, "1/2 size"), (4, "1/4 size"), (8, "1/8 size")];
/// Most samples per pixel of a view in two looks.
const SAMPLES_OF_LOOKS: u32 = 4;
/// Samples per pixel of pictures through an open lens.
const SAMPLES_OF_LENS: u32 = 16;
/// Grid of regions in pixels, so that coarse references have pixels in them.
const GRID: u32 = 4;
/// Width in points of the button that pauses and resumes tracing.
const PAUSE_WIDTH: f32 = 50.0;
/// Width in points of the button that ends the comparison.
const CLOSE: f32 = 22.0;

/// Kind of reference, without its settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KindChoice {
    /// All light samples.
    #[default]
    Samples,
    /// Light paths.
    Paths,
    /// A picture file.
    File,
    /// Another look of the scene.
    Look,
}

/// Effect of the next drag or click in the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tool {
    /// A drag draws the region: where it began, in shares of the viewport, and the rectangle so far.
    Region(Option<([f32; 2], [f32; 4])>),
    /// A click explains the pixel.
    Why,
}

/// State of the strip.
#[derive(Clone, Debug)]
pub struct ComparisonPanel {
    /// Whether anything is compared.
    pub open: bool,
    /// Kind of reference.
    pub kind: KindChoice,
    /// Light paths per pixel.
    pub spp: u32,
    /// The picture file.
    pub file: Option<PathBuf>,
    /// The name of the other look, and the look as it is now.
    pub look: Option<(String, Option<OtherLook>)>,
    /// See [`ComparisonRequest::scale`].
    pub scale: u32,
    /// How both are shown.
    pub view: CompareView,
    /// The reference is shown while the key is held.
    pub flicker: bool,
    /// Position of the line between both, as a share of the width.
    pub swipe: f32,
    /// Which error is mapped.
    pub map: ShownMap,
    /// The error at the end of the map's colors, if kept.
    pub top: Option<f32>,
    /// Pixels without surfaces do not count.
    pub surfaces_only: bool,
    /// The part that counts, in shares of the viewport: left, top, right, bottom.
    pub region: Option<[f32; 4]>,
    /// Tool of the pointer.
    pub tool: Option<Tool>,
    /// Whether figures and settings are shown.
    pub advanced: bool,
}

impl Default for ComparisonPanel {
    fn default() -> Self {
        Self {
            open: false,
            kind: KindChoice::default(),
            spp: 64,
            file: None,
            look: None,
            scale: 4,
            view: CompareView::default(),
            flicker: false,
            swipe: 0.5,
            map: ShownMap::Error(ErrorMap::default()),
            top: None,
            surfaces_only: true,
            region: None,
            tool: None,
            advanced: false,
        }
    }
}

impl ComparisonPanel {
    /// The view shown now.
    pub fn shown_view(&self) -> CompareView {
        if self.flicker { CompareView::Reference } else { self.view }
    }

    /// The request for the live picture; `None` if no file was chosen yet.
    pub fn request(&self, baked: Option<Baked>, mut look: Look) -> Option<ComparisonRequest> {
        // Settings without effect on the comparison do not restart it.
        (look.view.mode, look.view.wireframe) = (ViewMode::Shaded, false);
        let kind = match self.kind {
            KindChoice::Samples => ReferenceKind::Samples,
            KindChoice::Paths => ReferenceKind::Paths { spp: self.spp },
            KindChoice::File => ReferenceKind::File(self.file.clone()?),
            KindChoice::Look => ReferenceKind::Look(self.look.as_ref()?.1.clone()?),
        };
        match kind {
            ReferenceKind::Samples | ReferenceKind::Paths { .. } => {
                look.view.aa = look.view.camera.lens.least_samples().min(SAMPLES_OF_LENS);
            }
            // Smooth edges, soon: the live picture takes the cores, too.
            ReferenceKind::Look(_) => look.view.aa = look.view.aa.min(SAMPLES_OF_LOOKS),
            ReferenceKind::File(_) => {}
        }
        // Two looks are by cuts, and as fast as the live picture.
        let scale = if self.kind == KindChoice::Look { 1 } else { self.scale };
        let mut request = ComparisonRequest { baked, look, kind, scale, region: None };
        if self.kind != KindChoice::File {
            request.region = self.region_of(request.size());
        }
        Some(request)
    }

    /// The region drawn over the viewport: the one being dragged, else the measured one.
    pub fn drawn_region(&self) -> Option<[f32; 4]> {
        match self.tool {
            Some(Tool::Region(Some((_, part)))) => Some(part),
            _ => self.region,
        }
    }

    /// The region in pixels of a picture as high as the viewport of shape `aspect` (width over height), and of any width.
    pub fn region_in(&self, size: [u32; 2], aspect: f32) -> Option<Region> {
        let wider = aspect * size[1] as f32 / size[0].max(1) as f32;
        let across = |x: f32| 0.5 + (x - 0.5) * wider;
        let [left, top, right, bottom] = self.region?;
        Self { region: Some([across(left), top, across(right), bottom]), ..self.clone() }.region_of(size)
    }

    /// The region in pixels of a picture of the viewport's shape, moved out to the grid.
    pub fn region_of(&self, size: [u32; 2]) -> Option<Region> {
        let [left, top, right, bottom] = self.region?;
        let low = |share: f32, side: u32| (share.clamp(0.0, 1.0) * side as f32) as u32 / GRID * GRID;
        let high = |share: f32, side: u32| ((share.clamp(0.0, 1.0) * side as f32) as u32 + 1).next_multiple_of(GRID);
        let (x, y) = (low(left, size[0]), low(top, size[1]));
        let (width, height) = (high(right, size[0]).saturating_sub(x), high(bottom, size[1]).saturating_sub(y));
        Region { x, y, width, height }.within(size)
    }

    /// Label in place of a reference that is not there yet.
    pub fn waiting_label(&self) -> &'static str {
        match self.kind {
            KindChoice::Look => "B: the look is being rendered",
            _ => "B: the reference is being traced",
        }
    }

    fn look_name(&self) -> &str {
        self.look.as_ref().map_or("no look", |(name, _)| name)
    }

    /// Label of the picture.
    pub fn picture_label(&self, cuts: Cuts) -> String {
        match cuts.size() {
            _ if self.kind == KindChoice::Look => "A: as shown".into(),
            Some(_) => format!("A: illumination cut of {}", cuts.label()),
            None => "A: lit cuts".into(),
        }
    }

    /// Label of the reference, with its noise in the measured part.
    pub fn reference_label(&self, reference: &ReferencePicture, noise: Option<f64>, progress: f32) -> String {
        let done = if reference.finished { String::new() } else { format!(", {:.0} % done", 100.0 * progress) };
        match self.kind {
            KindChoice::Samples => format!("B: all light samples, traced{done}"),
            KindChoice::Paths => {
                let noise = noise.map(|n| format!(", noise {:.1} %", 100.0 * n)).unwrap_or_default();
                format!("B: {} light paths per pixel{noise}{done}", self.spp)
            }
            KindChoice::File => format!("B: {}", file_name(self.file.as_deref())),
            KindChoice::Look => format!("B: {}", self.look_name()),
        }
    }
}

fn file_name(path: Option<&Path>) -> String {
    path.and_then(Path::file_name).map_or("no file".into(), |name| name.to_string_lossy().into_owned())
}

/// Contents of the strip.
pub struct ComparisonContext<'a> {
    /// The figures, once there are some.
    pub measured: Option<&'a Measured>,
    /// Share of the reference that is done.
    pub progress: f32,
    /// Whether tracing was paused.
    pub paused: bool,
    /// Whether tracing waits for other work.
    pub held: bool,
    /// Whether there is something to pause.
    pub tracing: bool,
    /// Why there is no comparison.
    pub problem: Option<&'a str>,
    /// What is compared.
    pub subject: Subject<'a>,
}

/// Shows the strip: the pictures, what they say, and on request the figures.
pub fn show(ui: &mut Ui, panel: &mut ComparisonPanel, context: &ComparisonContext, actions: &mut Vec<Action>) {
    ui.add_space(2.0);
    close(ui, panel);
    ui.horizontal_wrapped(|ui| {
        ui.set_max_width(ui.available_width() - CLOSE - ui.spacing().item_spacing.x);
        reference(ui, panel, actions);
        if matches!(panel.kind, KindChoice::Samples | KindChoice::Paths) {
            tracing(ui, context, actions);
        }
        ui.separator();
        views(ui, panel, context.measured);
        ui.separator();
        let help = "Figures of the differences, settings of the reference, and where errors come from";
        ui.toggle_value(&mut panel.advanced, "Advanced").on_hover_text(help);
    });
    verdict::show(ui, panel, context, actions);
    if panel.advanced {
        ui.horizontal_wrapped(|ui| advanced(ui, panel, actions));
        figures::show(ui, panel, context.measured);
    }
    let not_finite = context.measured.map_or(0, |measured| measured.metrics.non_finite_pixels);
    if not_finite > 0 {
        let text = format!("{not_finite} pixels are not finite; they are magenta and left out");
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    ui.add_space(2.0);
}

/// Settings of the reference, and what explains errors.
fn advanced(ui: &mut Ui, panel: &mut ComparisonPanel, actions: &mut Vec<Action>) {
    settings(ui, panel);
    let help = "Renders the view with growing light cuts and with lit cuts, and says which is enough";
    if ui.button("Which cut size is enough?").on_hover_text(help).clicked() {
        actions.push(Action::Ladder(LadderAction::Start));
    }
    let asking = panel.tool == Some(Tool::Why);
    let help = "Click a pixel in the viewport to see its cuts, nodes and light, and the causes of its error";
    if ui.selectable_label(asking, "Why is a pixel so?").on_hover_text(help).clicked() {
        panel.tool = if asking { None } else { Some(Tool::Why) };
    }
}

/// The button that ends the comparison, in the corner, where no changing width can push it under the pointer.
fn close(ui: &mut Ui, panel: &mut ComparisonPanel) {
    let size = vec2(CLOSE, ui.spacing().interact_size.y);
    let corner = Align2::RIGHT_TOP.align_size_within_rect(size, ui.available_rect_before_wrap());
    let button = Button::new("×").frame(false);
    let mut corner = ui.new_child(UiBuilder::new().max_rect(corner).id_salt("close"));
    if corner.add_sized(size, button).on_hover_text("End the comparison (C)").clicked() {
        (panel.open, panel.tool) = (false, None);
    }
}

fn waiting(panel: &ComparisonPanel) -> &'static str {
    match panel.kind {
        KindChoice::File if panel.file.is_none() => {
            "Choose a picture of this view to compare with, scene-linear if possible"
        }
        KindChoice::Look => "Rendering the view in both looks",
        _ => "Tracing the first pass of the reference",
    }
}

fn reference(ui: &mut Ui, panel: &mut ComparisonPanel, actions: &mut Vec<Action>) {
    let kinds = [
        (
            KindChoice::Samples,
            "Light samples",
            "Trace all light samples at every pixel, to measure the error of the cuts",
        ),
        (KindChoice::Paths, "Light paths", "Trace light paths, to measure the whole error, with some noise"),
        (KindChoice::File, "Picture file", "Use a picture of this view from another program"),
    ];
    let look = format!("Look \"{}\"", panel.look_name());
    let look = panel.look.is_some().then_some((KindChoice::Look, look.as_str(), "Show the view in this look, by cuts"));
    let kinds: Vec<_> = kinds.into_iter().chain(look).collect();
    let chosen = kinds.iter().find(|k| k.0 == panel.kind).map_or("", |k| k.1);
    let combo = ComboBox::from_id_salt("reference").selected_text(chosen).show_ui(ui, |ui| {
        for &(kind, label, help) in &kinds {
            ui.selectable_value(&mut panel.kind, kind, label).on_hover_text(help);
        }
    });
    combo.response.on_hover_text("Reference to compare with").accessible_name("Reference");
    if panel.kind != KindChoice::File {
        return;
    }
    if ui.button(file_name(panel.file.as_deref())).on_hover_text("Choose another picture").clicked() {
        actions.push(Action::Compare(CompareAction::Reference(None)));
    }
}

/// Size and light paths of the reference.
fn settings(ui: &mut Ui, panel: &mut ComparisonPanel) {
    if panel.kind == KindChoice::Paths {
        let spp = DragValue::new(&mut panel.spp).range(1..=1_000_000).speed(1.0).suffix(" paths");
        ui.add(spp)
            .accessible_name("Paths per pixel")
            .on_hover_text("Light paths per pixel: four times as many halve the noise");
    }
    if panel.kind == KindChoice::Look {
        return;
    }
    let size = SCALES.iter().find(|s| s.0 == panel.scale).map_or("", |s| s.1);
    let combo = ComboBox::from_id_salt("comparison size").width(80.0).selected_text(size).show_ui(ui, |ui| {
        for (scale, label) in SCALES {
            ui.selectable_value(&mut panel.scale, scale, label);
        }
    });
    let help = "Size of both compared pictures. Light samples are slow at full size";
    combo.response.on_hover_text(help).accessible_name("Comparison size");
}

/// Of constant width, so that nothing beside it moves when tracing begins or ends.
fn tracing(ui: &mut Ui, context: &ComparisonContext, actions: &mut Vec<Action>) {
    let finished = context.measured.filter(|m| m.reference.finished);
    let text = match finished {
        _ if !context.tracing => String::new(),
        Some(measured) => format!("{:.1} s", measured.reference.seconds),
        None if context.held => format!("{:.0} %, waits", 100.0 * context.progress),
        None => format!("{:.0} %", 100.0 * context.progress),
    };
    let help = if context.held {
        "Tracing of the reference, which waits while cut sizes are tried"
    } else {
        "Tracing of the reference"
    };
    ui.add(ProgressBar::new(context.progress).desired_width(90.0).text(text)).on_hover_text(help);
    let label = if context.paused { "Go on" } else { "Pause" };
    let button = Button::new(label).min_size(vec2(PAUSE_WIDTH, 0.0));
    if ui.add_enabled(context.tracing && finished.is_none(), button).clicked() {
        actions.push(Action::Compare(CompareAction::Pause(!context.paused)));
    }
}

fn views(ui: &mut Ui, panel: &mut ComparisonPanel, measured: Option<&Measured>) {
    for (view, label, help) in CompareView::ALL {
        ui.selectable_value(&mut panel.view, view, label).on_hover_text(help);
    }
    if panel.view != CompareView::Difference {
        return;
    }
    let combo = ComboBox::from_id_salt("error map").width(110.0).selected_text(panel.map.title()).show_ui(ui, |ui| {
        for map in ShownMap::ALL {
            if ui.selectable_value(&mut panel.map, map, map.title()).on_hover_text(map_meaning(map)).changed() {
                panel.top = None;
            }
        }
    });
    combo.response.accessible_name("Error map");
    let help = "Keep the color range, to compare maps before and after an edit";
    if ui.add(Button::selectable(panel.top.is_some(), "Keep range")).on_hover_text(help).clicked() {
        panel.top = if panel.top.is_some() { None } else { measured.map(|m| m.field.top) };
    }
}

fn map_meaning(map: ShownMap) -> &'static str {
    let ShownMap::Error(map) = map else {
        return "Error predicted from the variances of the clusters, without a reference";
    };
    match map {
        ErrorMap::Relative => "Difference divided by the reference: dark parts count as much as bright ones",
        ErrorMap::Absolute => "Difference in scene-linear units",
        ErrorMap::Signed => "Orange where the picture is too bright, blue where it is too dark",
        ErrorMap::Flip => "Difference visible when flipping between both pictures",
    }
}
