//! Colors, spacing and type of the window: calm grays and one accent, so that the picture is the only loud thing on the
//! screen. Grays are neutral, because a tinted surround shifts how colors in the picture are seen.

use crate::preferences::{Preferences, Theme};
use egui::{
    Color32, Context, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, Style, TextStyle, Visuals,
    style::{ScrollStyle, Selection, WidgetVisuals, Widgets},
    vec2,
};

/// Least and greatest scale of the interface that the window offers.
pub const SCALE: std::ops::RangeInclusive<f32> = 0.75..=2.0;
/// Steps of the scale.
pub const SCALE_STEP: f32 = 0.125;

/// The grays of a theme, from the ground up, and its accent.
struct Palette {
    panel: u8,
    /// Text fields.
    well: u8,
    /// Behind the picture: never bright, which would dazzle beside it.
    stage: u8,
    control: u8,
    hovered: u8,
    active: u8,
    line: u8,
    text: u8,
    weak: u8,
    strong: u8,
    accent: Color32,
    on_accent: Color32,
    warning: Color32,
    error: Color32,
}

const DARK: Palette = Palette {
    panel: 40,
    well: 26,
    stage: 26,
    control: 58,
    hovered: 70,
    active: 84,
    line: 56,
    text: 208,
    weak: 152,
    strong: 240,
    accent: Color32::from_rgb(52, 104, 168),
    on_accent: Color32::from_rgb(244, 247, 252),
    warning: Color32::from_rgb(232, 180, 92),
    error: Color32::from_rgb(240, 122, 108),
};

const LIGHT: Palette = Palette {
    panel: 222,
    well: 244,
    stage: 208,
    control: 204,
    hovered: 192,
    active: 178,
    line: 198,
    text: 38,
    weak: 88,
    strong: 8,
    accent: Color32::from_rgb(38, 98, 170),
    on_accent: Color32::from_rgb(250, 252, 255),
    warning: Color32::from_rgb(134, 82, 0),
    error: Color32::from_rgb(176, 32, 24),
};

/// Gives the context both themes, and shows the preferred one at the preferred scale.
pub fn apply(ctx: &Context, preferences: &Preferences) {
    for (theme, palette) in [(egui::Theme::Dark, &DARK), (egui::Theme::Light, &LIGHT)] {
        ctx.set_style_of(theme, style(theme, palette));
    }
    ctx.set_theme(match preferences.theme {
        Theme::Dark => egui::Theme::Dark,
        Theme::Light => egui::Theme::Light,
    });
    // The window has its own keys for the scale, which keeps it within bounds and remembers it.
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
    ctx.set_zoom_factor(preferences.ui_scale.clamp(*SCALE.start(), *SCALE.end()));
}

/// The next scale up or down.
pub fn scaled(scale: f32, steps: i32) -> f32 {
    let step = (scale / SCALE_STEP).round() as i32 + steps;
    (step as f32 * SCALE_STEP).clamp(*SCALE.start(), *SCALE.end())
}

fn style(theme: egui::Theme, palette: &Palette) -> Style {
    let mut style = theme.default_style();
    style.visuals = visuals(theme, palette);
    style.spacing.item_spacing = vec2(6.0, 5.0);
    style.spacing.button_padding = vec2(7.0, 2.0);
    style.spacing.interact_size.y = 21.0;
    style.spacing.menu_margin = Margin::same(6);
    style.spacing.indent = 14.0;
    style.spacing.scroll = ScrollStyle::thin();
    style.animation_time = 0.08;
    // A drag over the panels selects no labels; text worth copying is made selectable one by one.
    style.interaction.selectable_labels = false;
    let sized = |size, family| FontId::new(size, family);
    style.text_styles = [
        (TextStyle::Small, sized(11.0, FontFamily::Proportional)),
        (TextStyle::Body, sized(13.0, FontFamily::Proportional)),
        (TextStyle::Button, sized(13.0, FontFamily::Proportional)),
        (TextStyle::Heading, sized(16.0, FontFamily::Proportional)),
        (TextStyle::Monospace, sized(12.0, FontFamily::Monospace)),
    ]
    .into();
    style
}

fn visuals(theme: egui::Theme, palette: &Palette) -> Visuals {
    let gray = Color32::from_gray;
    let line = Stroke::new(1.0, gray(palette.line));
    Visuals {
        widgets: widgets(palette),
        selection: Selection { bg_fill: palette.accent, stroke: Stroke::new(1.0, palette.on_accent) },
        hyperlink_color: if theme == egui::Theme::Dark { Color32::from_rgb(122, 172, 232) } else { palette.accent },
        weak_text_color: Some(gray(palette.weak)),
        faint_bg_color: gray(if theme == egui::Theme::Dark { palette.panel + 5 } else { palette.panel - 6 }),
        extreme_bg_color: gray(palette.well),
        text_edit_bg_color: Some(gray(palette.well)),
        code_bg_color: gray(palette.stage),
        warn_fg_color: palette.warning,
        error_fg_color: palette.error,
        panel_fill: gray(palette.panel),
        window_fill: gray(palette.panel),
        window_stroke: line,
        window_corner_radius: CornerRadius::same(4),
        menu_corner_radius: CornerRadius::same(4),
        window_shadow: Shadow { offset: [0, 4], blur: 16, spread: 0, color: Color32::from_black_alpha(96) },
        popup_shadow: Shadow { offset: [0, 2], blur: 8, spread: 0, color: Color32::from_black_alpha(80) },
        slider_trailing_fill: true,
        indent_has_left_vline: false,
        ..theme.default_visuals()
    }
}

fn widgets(palette: &Palette) -> Widgets {
    let gray = Color32::from_gray;
    let of = |fill: u8, text: u8, line: Option<u8>| WidgetVisuals {
        bg_fill: gray(fill),
        weak_bg_fill: gray(fill),
        bg_stroke: line.map_or(Stroke::NONE, |line| Stroke::new(1.0, gray(line))),
        corner_radius: CornerRadius::same(3),
        fg_stroke: Stroke::new(1.0, gray(text)),
        expansion: 0.0,
    };
    Widgets {
        noninteractive: of(palette.panel, palette.text, Some(palette.line)),
        inactive: of(palette.control, palette.text, None),
        hovered: of(palette.hovered, palette.strong, None),
        active: of(palette.active, palette.strong, None),
        open: of(palette.hovered, palette.strong, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// WCAG 2.1 contrast of two colors.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |c: Color32| {
            lapidary_core::color::luminance(lapidary_core::color::linear_from_codes([c.r(), c.g(), c.b()]))
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn all_text_can_be_read_on_its_ground() {
        for palette in [&DARK, &LIGHT] {
            let gray = Color32::from_gray;
            let pairs = [
                (gray(palette.text), gray(palette.panel)),
                (gray(palette.weak), gray(palette.panel)),
                (gray(palette.text), gray(palette.control)),
                (gray(palette.weak), gray(palette.stage)),
                (gray(palette.strong), gray(palette.active)),
                (palette.on_accent, palette.accent),
                (palette.warning, gray(palette.panel)),
                (palette.error, gray(palette.panel)),
            ];
            for (i, (text, ground)) in pairs.into_iter().enumerate() {
                assert!(contrast(text, ground) >= 4.5, "pair {i}: {}", contrast(text, ground));
            }
        }
        assert!(contrast(Color32::from_gray(90), Color32::from_gray(DARK.panel)) < 4.5, "the measure tells bad pairs");
    }

    #[test]
    fn the_scale_steps_within_its_bounds() {
        assert_eq!(scaled(1.0, 1), 1.125);
        assert_eq!(scaled(0.75, -1), 0.75);
        assert_eq!(scaled(2.0, 1), 2.0);
        assert_eq!(scaled(1.03, -1), 0.875);
    }
}
