//! The reflection lobe as a polar plot: the share of light from one direction that leaves in each direction of the plane of
//! incidence. Drag in the plot to move the light.

use crate::widgets::{Number, choice_row, slider_row};
use egui::{Color32, Ui};
use egui_plot::{Line, LineStyle, Plot, PlotPoints};
use glam::Vec3;
use lapidary_core::{
    brdf::{Brdf, BrdfModel, SampledLobe},
    color::luminance,
    material::Material,
    sphere::GOLDEN_TURN,
};
use std::f32::consts::FRAC_PI_2;

/// Directions across the half circle, and as many again around the mirror direction.
const DIRECTIONS: usize = 181;
/// Greatest angle of the light in degrees: at 90 nothing arrives.
const STEEPEST: f32 = 89.0;

/// Angles of the curve of reflected light, and the square root of the samples at each.
const ANGLES: usize = 31;
const STRATA: usize = 16;
/// Largest albedo that rounding and sampling noise explain.
const MOST_ALBEDO: f32 = 1.02;

/// Plane in which the light moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// Of the normal and the tangent.
    #[default]
    Tangent,
    /// Of the normal and the bitangent.
    Bitangent,
}

/// Position of the plot's light.
#[derive(Clone, Copy, Debug)]
pub struct LobePlot {
    /// Degrees from the normal, 0 to 89.
    pub light_degrees: f32,
    /// Its plane.
    pub plane: Plane,
}

/// The sampled lobe of a BRDF file, and its tint: integrating the BRDF in each frame takes too long.
fn estimate(material: &Material) -> Option<(SampledLobe, Vec3)> {
    let file = material.file.as_ref().filter(|_| material.model.has_file())?;
    let tint = material.parameter("tint").filter(|_| material.model == BrdfModel::Merl);
    let tint = tint.map_or(Vec3::ONE, |tint| material.parameters.value(tint).color());
    Some((file.content.as_ref()?.estimate(&material.plain_values()), tint))
}

impl Default for LobePlot {
    fn default() -> Self {
        Self { light_degrees: 45.0, plane: Plane::default() }
    }
}

/// A lobe in its plane of incidence.
#[derive(Clone, Debug)]
pub struct Lobe {
    /// Angle from the normal in radians, positive away from the light, and `f_r cos θo` there, luminance per steradian.
    pub samples: Vec<(f32, f32)>,
    /// The greatest value.
    pub largest: f32,
}

impl LobePlot {
    /// The lobe of a material without its maps.
    pub fn lobe(&self, material: &Material) -> Lobe {
        let brdf = material.plain_brdf();
        let brdf = brdf.as_brdf();
        let light = self.light_degrees.to_radians();
        let wi = self.direction(-light);
        let width = brdf.narrowest_lobe().unwrap_or(1.0);
        // By reciprocity the roles can be swapped: the kernel's light direction is the outgoing one here.
        let value = |angle: f32| luminance(brdf.brdf_cos(self.direction(angle), wi));
        let samples: Vec<(f32, f32)> = angles(light, width).into_iter().map(|a| (a, value(a))).collect();
        let largest = samples.iter().fold(0.0, |most: f32, s| most.max(s.1));
        Lobe { samples, largest }
    }

    fn direction(&self, angle: f32) -> Vec3 {
        let (sin, cos) = angle.sin_cos();
        match self.plane {
            Plane::Tangent => Vec3::new(sin, 0.0, cos),
            Plane::Bitangent => Vec3::new(0.0, sin, cos),
        }
    }

    /// Plot and controls.
    pub fn show(&mut self, ui: &mut Ui, material: &Material) {
        let lobe = self.lobe(material);
        self.draw(ui, &lobe);
        ui.weak(format!("Largest value {:.3} per steradian. Drag in the plot to move the light.", lobe.largest));
        let help = "Angle between the light and the surface normal, 0 to 89 degrees. This changes the plot only.";
        let number = Number::new("Light angle", help, 0.0..=STEEPEST, 45.0).unit("°", 0);
        let _ = slider_row(ui, &number, &mut self.light_degrees);
        let planes = [
            (Plane::Tangent, "Tangent", "The light moves along the tangent: the direction of positive anisotropy."),
            (Plane::Bitangent, "Bitangent", "The light moves across the tangent."),
        ];
        let _ = choice_row(ui, "Plane", "Plane in which the light moves.", &mut self.plane, &planes);
        let energy = self.energy(material);
        self.draw_energy(ui, &energy);
        let most = energy.iter().map(|&(_, albedo)| albedo.max_element()).fold(0.0, f32::max);
        ui.weak(format!("Reflected light by light angle: at most {:.1} %.", 100.0 * most));
        if most > MOST_ALBEDO {
            let warning = "Reflects more light than it receives at some angles.";
            ui.colored_label(ui.visuals().warn_fg_color, warning);
        }
    }

    /// Share of the light reflected in all directions, by the light's angle in degrees, per color.
    pub fn energy(&self, material: &Material) -> Vec<(f32, Vec3)> {
        let brdf = material.plain_brdf();
        let estimate = estimate(material);
        let angles = (0..ANGLES).map(|i| STEEPEST * i as f32 / (ANGLES - 1) as f32);
        let at = |angle: f32| match &estimate {
            Some((estimate, tint)) => estimate.albedo_at(angle.to_radians().cos()) * *tint,
            None => albedo(brdf.as_brdf(), self.direction(-angle.to_radians())),
        };
        angles.map(|angle| (angle, at(angle))).collect()
    }

    fn draw_energy(&self, ui: &mut Ui, energy: &[(f32, Vec3)]) {
        let plot = Plot::new("energy").height(90.0).show_grid(false).allow_zoom(false).allow_drag(false);
        let plot = plot.allow_scroll(false).allow_boxed_zoom(false).allow_double_click_reset(false);
        let plot = plot.show_background(false).show_axes([true, false]).include_y(0.0).include_y(1.05).show_x(false);
        plot.show_y(false).show(ui, |plot| {
            let weak = Color32::GRAY;
            plot.line(Line::new("All", PlotPoints::from(vec![[0.0, 1.0], [90.0, 1.0]])).color(weak).width(1.0));
            let colors = [
                Color32::from_rgb(0xe0, 0x50, 0x50),
                Color32::from_rgb(0x50, 0xb0, 0x50),
                Color32::from_rgb(0x60, 0x80, 0xf0),
            ];
            for (channel, color) in colors.into_iter().enumerate() {
                let points: Vec<[f64; 2]> =
                    energy.iter().map(|&(angle, albedo)| [angle.into(), albedo[channel].into()]).collect();
                plot.line(
                    Line::new(["Red", "Green", "Blue"][channel], PlotPoints::from(points)).color(color).width(1.5),
                );
            }
        });
    }

    fn draw(&mut self, ui: &mut Ui, lobe: &Lobe) {
        let light = self.light_degrees.to_radians();
        let scale = if lobe.largest > 0.0 { 1.0 / lobe.largest } else { 0.0 };
        let polar = |angle: f32, r: f32| [f64::from(r * angle.sin()), f64::from(r * angle.cos())];
        let curve: Vec<[f64; 2]> = lobe.samples.iter().map(|&(a, v)| polar(a, v * scale)).collect();
        let circle: Vec<[f64; 2]> = (-45..=45).map(|i| polar(i as f32 * FRAC_PI_2 / 45.0, 1.0)).collect();
        let weak = ui.visuals().weak_text_color();
        let accent = ui.visuals().selection.bg_fill;
        let line = |name: &str, points: Vec<[f64; 2]>, color: Color32| {
            Line::new(name, PlotPoints::from(points)).color(color).width(1.0).allow_hover(false)
        };
        let plot = Plot::new("lobe").data_aspect(1.0).height(150.0).show_axes(false).show_grid(false).show_x(false);
        let plot = plot.show_y(false).allow_zoom(false).allow_drag(false).allow_scroll(false).allow_boxed_zoom(false);
        let plot = plot.allow_double_click_reset(false).show_background(false).include_x(-1.15).include_x(1.15);
        let shown = plot.include_y(-0.08).include_y(1.08).show(ui, |plot| {
            plot.line(line("Surface", vec![[-1.1, 0.0], [1.1, 0.0]], weak));
            plot.line(line("Scale", circle, weak.gamma_multiply(0.4)));
            plot.line(
                line("Mirror direction", vec![[0.0, 0.0], polar(light, 1.0)], weak).style(LineStyle::dashed_dense()),
            );
            plot.line(
                line("Light", vec![[0.0, 0.0], polar(-light, 1.05)], Color32::from_rgb(0xe0, 0xb0, 0x50)).width(2.0),
            );
            plot.line(line("Lobe", curve, accent).width(2.0));
        });
        if let Some(at) = shown.response.interact_pointer_pos() {
            let p = shown.transform.value_from_position(at);
            self.light_degrees = dragged_angle(p.x, p.y);
        }
    }
}

/// The stratified mean over directions drawn by the model.
fn albedo(brdf: &dyn Brdf, wo: Vec3) -> Vec3 {
    let sample = |i: usize| {
        let (x, y) = ((i % STRATA) as f32 + 0.5, (i / STRATA) as f32 + 0.5);
        // The golden ratio spreads the third number over the strata.
        let third = (i as f32 * GOLDEN_TURN).fract();
        let wi = brdf.sample(wo, Vec3::new(x, y, 0.0) / STRATA as f32 + third * Vec3::Z);
        let density = brdf.pdf(wi, wo);
        if wi.z > 0.0 && density > 0.0 { brdf.brdf_cos(wi, wo) / density } else { Vec3::ZERO }
    };
    (0..STRATA * STRATA).map(sample).sum::<Vec3>() / (STRATA * STRATA) as f32
}

/// The light's angle in degrees for a pointer at plot coordinates; the light is on the left.
fn dragged_angle(x: f64, y: f64) -> f32 {
    ((-x).atan2(y).to_degrees() as f32).clamp(0.0, STEEPEST)
}

/// Directions evenly over the half circle, and closer ones around the mirror direction of `light`, in order.
fn angles(light: f32, width: f32) -> Vec<f32> {
    let steps = (0..DIRECTIONS).map(|i| i as f32 / (DIRECTIONS - 1) as f32 * 2.0 - 1.0);
    let even = steps.clone().map(|s| s * FRAC_PI_2);
    let close = steps.map(|s| light + s * s.abs() * 8.0 * width).filter(|a| a.abs() < FRAC_PI_2);
    let mut angles: Vec<f32> = even.chain(close).collect();
    angles.sort_by(f32::total_cmp);
    angles
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{brdf::GgxParameters, material::BrdfModel};
    use std::f32::consts::{FRAC_1_PI, FRAC_PI_4};

    fn material(model: BrdfModel, parameters: GgxParameters) -> Material {
        Material { model, parameters: parameters.into(), ..Default::default() }
    }

    fn peak(lobe: &Lobe) -> f32 {
        lobe.samples.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0
    }

    #[test]
    fn white_reflects_all_at_every_angle_and_black_nothing() {
        let plot = LobePlot::default();
        let of = |base_color: Vec3, metalness: f32, roughness: f32| {
            let p = GgxParameters { base_color, metalness, roughness, ..Default::default() };
            plot.energy(&material(BrdfModel::Ggx, p))
        };
        for (angle, albedo) in of(Vec3::ONE, 1.0, 0.6) {
            assert!((albedo - 1.0).abs().max_element() < 0.03, "{angle}: {albedo}");
        }
        let black = of(Vec3::ZERO, 0.0, 0.3);
        assert!(black[0].1.max_element() < 0.06 && black[ANGLES - 1].1.max_element() > 0.3, "Fresnel remains");
    }

    #[test]
    fn a_diffuse_lobe_is_a_circle_wherever_the_light_is() {
        let white = material(BrdfModel::Lambert, GgxParameters { base_color: Vec3::ONE, ..Default::default() });
        for light_degrees in [0.0, 45.0, 80.0] {
            let lobe = LobePlot { light_degrees, ..Default::default() }.lobe(&white);
            assert!((lobe.largest - FRAC_1_PI).abs() < 1e-4);
            assert!(lobe.samples.iter().all(|&(a, v)| (v - FRAC_1_PI * a.cos()).abs() < 1e-4));
        }
    }

    #[test]
    fn a_polished_metal_peaks_in_the_mirror_direction() {
        let p = GgxParameters { roughness: 0.05, metalness: 1.0, ..Default::default() };
        let lobe = LobePlot::default().lobe(&material(BrdfModel::Ggx, p));
        assert!((peak(&lobe) - FRAC_PI_4).abs() < 0.005, "{}", peak(&lobe));
        let rough = material(BrdfModel::Ggx, GgxParameters { roughness: 0.5, ..p });
        assert!(LobePlot::default().lobe(&rough).largest < 0.1 * lobe.largest, "negative control");
    }

    #[test]
    fn anisotropy_makes_the_planes_differ() {
        let widths = |anisotropy: f32| {
            let p = GgxParameters { roughness: 0.4, metalness: 1.0, anisotropy, ..Default::default() };
            [Plane::Tangent, Plane::Bitangent].map(|plane| {
                let lobe = LobePlot { plane, light_degrees: 30.0 }.lobe(&material(BrdfModel::Ggx, p));
                let wide = lobe.samples.iter().filter(|s| s.1 > 0.5 * lobe.largest).map(|s| s.0);
                wide.clone().fold(f32::MIN, f32::max) - wide.fold(f32::MAX, f32::min)
            })
        };
        let [along, across] = widths(0.8);
        assert!(along > 1.5 * across, "{along} {across}");
        let [along, across] = widths(0.0);
        assert!((along - across).abs() < 1e-3, "negative control");
    }

    #[test]
    fn the_light_follows_the_pointer_on_its_side() {
        assert!((dragged_angle(-1.0, 1.0) - 45.0).abs() < 1e-4);
        assert_eq!((dragged_angle(0.5, 1.0), dragged_angle(-1.0, -0.5)), (0.0, STEEPEST));
    }
}
