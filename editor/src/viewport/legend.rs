//! Legend of a view mode's colors, in the lower right corner of the picture.
//!
//! The colors match the renderers': magma for counts, sRGB for base color, plain values for normals and roughness.

use super::ViewportContext;
use crate::{document::Component, widgets::units::grouped};
use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Shape, Stroke, Vec2, pos2, vec2};
use glam::{Mat3, Vec3};
use lapidary_core::{camera::Camera, color::srgb_from_linear, dataset::BakeParts};
use lapidary_render::{
    BasisView, BrdfSampling, ViewMode,
    compare::map::{ErrorField, ErrorMap, magma},
    shows_source_cuts,
};

/// Distance to the edges of the picture, and padding of the legend.
const MARGIN: f32 = 12.0;
const PADDING: f32 = 10.0;

/// Size of a color bar in points, and of the ball.
const BAR: Vec2 = vec2(240.0, 10.0);
const BALL_RADIUS: f32 = 26.0;

const TEXT: Color32 = Color32::from_gray(235);
const FONT: FontId = FontId::proportional(11.0);
/// Height of a line of that font.
const LINE: f32 = 14.0;

/// Paints the legend of the view into `rect`; the lit picture needs one only if clusters are drawn over it.
pub fn paint(painter: &Painter, rect: Rect, context: &ViewportContext) {
    let view = &context.document.view;
    match (view.mode, context.clusters()) {
        (ViewMode::Shaded, None) => {}
        (ViewMode::Shaded, Some(sources)) => {
            let (points, clusters) = (grouped(sources.leaves() as u64), grouped(sources.cut.len() as u64));
            let colors = "Bounced light: one color per cluster".to_owned();
            words(painter, rect, &[colors, format!("{points} points in {clusters} clusters")]);
        }
        (ViewMode::Normals, _) => ball(painter, rect, &context.document.camera),
        (mode, _) if mode.is_of_bounce() => words(painter, rect, &of_bounce(mode, view.basis)),
        (mode, _) => {
            let gathered = Gathered::of(mode, context);
            bar(painter, rect, &ColorScale::of(mode, view.sampling, view.illum_cut, gathered));
        }
    }
}

/// Legend of a view of a part of bounced light, in two lines.
fn of_bounce(mode: ViewMode, basis: BasisView) -> [String; 2] {
    let second = match mode {
        ViewMode::BasisLevel | ViewMode::Gloss => "Red adds light, blue subtracts it",
        ViewMode::BasisFunction => "Red where it is 1, gray where it is 0",
        _ => "One color per level; red is the coarsest",
    };
    let number = match mode {
        ViewMode::BasisLevel => format!(" {}", basis.level),
        ViewMode::BasisFunction => format!(" {}", grouped(basis.function.into())),
        _ => String::new(),
    };
    [format!("{}{number}", mode.label()), second.into()]
}

/// Legend of an error map.
pub fn errors(painter: &Painter, rect: Rect, field: &ErrorField) {
    let color: fn(f32) -> Color32 = match field.kind {
        ErrorMap::Signed => |place| color(ErrorMap::Signed.color(ErrorMap::Signed.error_at(place))),
        _ => |place| color(magma(place)),
    };
    bar(painter, rect, &ColorScale { title: field.title.into(), color, ticks: field.ticks(4) });
}

/// Light that is counted.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gathered {
    environment: bool,
    bounce: bool,
}

impl Gathered {
    fn of(mode: ViewMode, context: &ViewportContext) -> Self {
        let Some(baked) = context.baked else { return Self { environment: false, bounce: false } };
        if mode == ViewMode::VisibilityCut {
            return Self::baked(baked);
        }
        let environment = baked.environment() && context.document.components.shows(Component::Environment);
        Self { environment, bounce: context.sources.is_some() }
    }

    /// Light of the cuts in a bake.
    fn baked(mode: BakeParts) -> Self {
        Self { environment: mode.environment(), bounce: shows_source_cuts(mode) }
    }

    fn words(self) -> &'static str {
        match (self.environment, self.bounce) {
            (true, true) => ", environment and bounced light",
            (true, false) => ", environment",
            (false, true) => ", bounced light",
            (false, false) => ": no light is gathered by cuts",
        }
    }
}

/// A color bar and its labels.
struct ColorScale {
    title: String,
    color: fn(f32) -> Color32,
    /// Labels from left to right, evenly spaced.
    ticks: Vec<String>,
}

impl ColorScale {
    fn of(mode: ViewMode, sampling: BrdfSampling, illum_cut: u32, gathered: Gathered) -> Self {
        let fractions = || ["0", "0.25", "0.5", "0.75", "1"].map(String::from).into();
        let (color, ticks): (fn(f32) -> Color32, _) = match mode {
            ViewMode::Albedo => (|x| gray(srgb_from_linear(x)), fractions()),
            ViewMode::Roughness => (gray, fractions()),
            _ => (|x| color(magma(x)), count_ticks(mode.count_top(sampling, illum_cut))),
        };
        let of_what = if mode.is_count() { gathered.words() } else { "" };
        Self { title: format!("{}{of_what}", mode.label()), color, ticks }
    }
}

/// Quarters of the range. The plus marks that all counts above the top have the same color.
fn count_ticks(top: f32) -> Vec<String> {
    let quarters = (0..=4).map(|i| format!("{:.0}", top * i as f32 / 4.0));
    quarters.enumerate().map(|(i, tick)| if i == 4 { tick + "+" } else { tick }).collect()
}

fn gray(x: f32) -> Color32 {
    color(Vec3::splat(x))
}

/// A display value, 0 to 1.
fn color(display: Vec3) -> Color32 {
    let [r, g, b] = (display.clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round().to_array().map(|x| x as u8);
    Color32::from_rgb(r, g, b)
}

fn bar(painter: &Painter, rect: Rect, scale: &ColorScale) {
    let area = panel(painter, rect, BAR + vec2(2.0 * PADDING, 2.0 * LINE + 4.0));
    let top_left = pos2(area.center().x - 0.5 * BAR.x, area.top());
    text(painter, top_left, Align2::LEFT_TOP, &scale.title);
    let bar = Rect::from_min_size(top_left + vec2(0.0, LINE + 2.0), BAR);
    painter.add(Shape::mesh(gradient(bar, scale.color)));
    let last = (scale.ticks.len() - 1) as f32;
    for (i, tick) in scale.ticks.iter().enumerate() {
        let x = bar.left() + bar.width() * i as f32 / last;
        painter.vline(x, bar.bottom()..=bar.bottom() + 3.0, Stroke::new(1.0, TEXT));
        text(painter, pos2(x, bar.bottom() + 3.0), Align2::CENTER_TOP, tick);
    }
}

/// Lines of text.
fn words(painter: &Painter, rect: Rect, lines: &[String]) {
    let area = panel(painter, rect, vec2(BAR.x, LINE * lines.len() as f32));
    for (i, line) in lines.iter().enumerate() {
        text(painter, area.left_top() + vec2(0.0, LINE * i as f32), Align2::LEFT_TOP, line);
    }
}

fn gradient(bar: Rect, color: fn(f32) -> Color32) -> Mesh {
    const STEPS: u32 = 64;
    let mut mesh = Mesh::default();
    for i in 0..=STEPS {
        let x = i as f32 / STEPS as f32;
        let at = bar.left() + x * bar.width();
        mesh.colored_vertex(pos2(at, bar.top()), color(x));
        mesh.colored_vertex(pos2(at, bar.bottom()), color(x));
    }
    for i in (0..2 * STEPS).step_by(2) {
        mesh.add_triangle(i, i + 1, i + 2);
        mesh.add_triangle(i + 2, i + 1, i + 3);
    }
    mesh
}

/// A ball that shows the color of each normal as the camera sees it, with the world's axes around it.
fn ball(painter: &Painter, rect: Rect, camera: &Camera) {
    let side = 2.0 * (BALL_RADIUS + LINE);
    let center = panel(painter, rect, vec2(side, side)).center();
    let world_from_view = camera.world_from_view();
    painter.add(Shape::mesh(ball_mesh(center, world_from_view)));
    painter.circle_stroke(center, BALL_RADIUS, Stroke::new(1.0, TEXT));
    for (axis, name) in [(Vec3::X, "X"), (Vec3::Y, "Y"), (Vec3::Z, "Z")] {
        let view = world_from_view.transpose() * axis;
        let at = center + (BALL_RADIUS + 0.5 * LINE) * vec2(view.x, -view.y);
        // Axes that point away are dimmed.
        let strength = if view.z > -0.05 { 1.0 } else { 0.45 };
        painter.text(at, Align2::CENTER_CENTER, name, FONT, TEXT.gamma_multiply(strength));
    }
}

fn ball_mesh(center: Pos2, world_from_view: Mat3) -> Mesh {
    const RINGS: u32 = 8;
    const SECTORS: u32 = 32;
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        for sector in 0..SECTORS {
            let angle = sector as f32 / SECTORS as f32 * std::f32::consts::TAU;
            let place = ring as f32 / RINGS as f32 * vec2(angle.cos(), angle.sin());
            mesh.colored_vertex(center + BALL_RADIUS * place, ball_color(place, world_from_view));
        }
    }
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let next = (sector + 1) % SECTORS;
            let [a, b] = [ring * SECTORS, (ring + 1) * SECTORS];
            mesh.add_triangle(a + sector, b + sector, b + next);
            mesh.add_triangle(a + sector, b + next, a + next);
        }
    }
    mesh
}

/// The color at a point of the unit disc (y downward): the normal of the ball there.
fn ball_color(place: Vec2, world_from_view: Mat3) -> Color32 {
    let toward_eye = (1.0 - place.length_sq()).max(0.0).sqrt();
    let normal = world_from_view * Vec3::new(place.x, -place.y, toward_eye);
    color(0.5 + 0.5 * normal)
}

/// Darkens a panel for `content` in the corner, and returns the content's rectangle.
fn panel(painter: &Painter, rect: Rect, content: Vec2) -> Rect {
    let size = content + Vec2::splat(2.0 * PADDING);
    let panel = Align2::RIGHT_BOTTOM.align_size_within_rect(size, rect.shrink(MARGIN));
    painter.rect_filled(panel, 4.0, Color32::from_black_alpha(150));
    panel.shrink(PADDING)
}

fn text(painter: &Painter, at: Pos2, align: Align2, text: &str) {
    painter.text(at, align, text, FONT, TEXT);
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENVIRONMENT: Gathered = Gathered { environment: true, bounce: false };

    #[test]
    fn counts_say_what_they_are_of_and_other_views_do_not() {
        let title = |mode, baked| ColorScale::of(mode, BrdfSampling::Refine, 256, Gathered::baked(baked)).title;
        let of_cuts = |baked| title(ViewMode::VisibilityCut, baked);
        assert_eq!(of_cuts(BakeParts::ENVIRONMENT), "Visibility cut size, environment");
        assert_eq!(of_cuts(BakeParts::INDIRECT), "Visibility cut size, bounced light");
        assert_eq!(of_cuts(BakeParts::ALL), of_cuts(BakeParts::ENVIRONMENT));
        assert_eq!(of_cuts(BakeParts::MESHLESS), "Visibility cut size: no light is gathered by cuts");
        assert_eq!(title(ViewMode::Roughness, BakeParts::INDIRECT), "Roughness");
    }

    #[test]
    fn counts_run_from_nothing_to_the_top_in_quarters() {
        let of = |mode, sampling, illum_cut| ColorScale::of(mode, sampling, illum_cut, ENVIRONMENT).ticks;
        let ticks = |mode: ViewMode, illum_cut| of(mode, BrdfSampling::Refine, illum_cut);
        assert_eq!(of(ViewMode::MergedCut, BrdfSampling::Lit, 250)[4], "512+", "lit cuts merge no illumination cut");
        assert_eq!(ticks(ViewMode::VisibilityCut, 4096), ["0", "128", "256", "384", "512+"]);
        assert_eq!(ticks(ViewMode::MergedCut, 250), ["0", "250", "500", "750", "1000+"]);
        assert_eq!(ticks(ViewMode::MergedCut, 1)[4], "512+", "no finer than the least range");
        assert_eq!(ticks(ViewMode::Roughness, 250)[4], "1");
    }

    #[test]
    fn views_of_the_basis_say_what_of_it_they_show() {
        let of = |mode| of_bounce(mode, BasisView { level: 2, function: 12_345 })[0].clone();
        assert_eq!(of(ViewMode::BasisLevel), "Basis level 2");
        assert_eq!(of(ViewMode::BasisFunction), "Basis function 12,345");
        assert_eq!(of(ViewMode::BasisCoefficients), "Basis coefficients");
    }

    #[test]
    fn ramps_have_the_colours_of_the_picture() {
        let at = |mode, x| (ColorScale::of(mode, BrdfSampling::Refine, 256, ENVIRONMENT).color)(x);
        assert_eq!(at(ViewMode::Roughness, 0.5), Color32::from_gray(128));
        assert_eq!(at(ViewMode::Albedo, 0.5), Color32::from_gray(188), "base color is encoded");
        assert_eq!(at(ViewMode::BrdfEvaluations, 0.0), Color32::from_rgb(0, 0, 4));
        assert_eq!(at(ViewMode::BrdfEvaluations, 1.0), Color32::from_rgb(252, 253, 191));
        let mesh = gradient(Rect::from_min_size(Pos2::ZERO, BAR), gray);
        assert!(mesh.is_valid());
        assert_eq!(mesh.vertices.last().map(|v| v.color), Some(Color32::WHITE));
    }

    #[test]
    fn the_ball_turns_against_the_camera() {
        let from = |eye: Vec3| Camera::look_at(eye, Vec3::ZERO, 40.0).world_from_view();
        let center = |eye: Vec3| ball_color(Vec2::ZERO, from(eye));
        assert_eq!(center(Vec3::Z), Color32::from_rgb(128, 128, 255));
        assert_eq!(center(Vec3::X), Color32::from_rgb(255, 128, 128));
        assert_eq!(center(Vec3::NEG_X), Color32::from_rgb(0, 128, 128));
        assert_eq!(ball_color(vec2(1.0, 0.0), from(Vec3::Z)), Color32::from_rgb(255, 128, 128), "right is +X");
        assert_eq!(ball_color(vec2(0.0, -1.0), from(Vec3::Z)), Color32::from_rgb(128, 255, 128), "up is +Y");
        assert!(ball_mesh(Pos2::ZERO, from(Vec3::Z)).is_valid());
    }
}
