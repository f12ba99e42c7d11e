//! The strip under an error map: title, color bar and ticks.

use super::{ErrorMap, NOT_FINITE, linear};
use crate::measure::lettering::Lettering;
use glam::Vec3;
use lapidary_core::image::Image;
use std::ops::Range;

/// Contents of the strip.
pub(super) struct Legend {
    /// Kind of error.
    pub kind: ErrorMap,
    /// The error at the right end of the bar.
    pub top: f32,
    /// Whether some pixels exceed `top`; its label then ends in `+`.
    pub saturated: bool,
    /// Number of pixels with non-finite values.
    pub non_finite: usize,
}

/// Smallest width of the result in pixels; the labels then fit under any picture.
const MIN_WIDTH: usize = 240;
/// The strip doubles in size at twice this picture width, and so on, to stay readable when shown small.
const WIDTH_PER_SCALE: usize = 640;

// The layout from top to bottom, in units of the scale.
const MARGIN: usize = 4;
/// Height of an em.
const TEXT_SIZE: f32 = 11.0;
/// Height of a line.
const LINE: usize = 13;
const TITLE: usize = MARGIN;
const BAR: Range<usize> = TITLE + LINE + 2..TITLE + LINE + 12;
const TICK: Range<usize> = BAR.end..BAR.end + 3;
const LABEL: usize = TICK.end + 1;
const HEIGHT: usize = LABEL + LINE + MARGIN;

const INTERVALS: usize = 4;

/// Linear colors of the strip.
const BACKGROUND: Vec3 = Vec3::splat(0.02);
const TEXT: Vec3 = Vec3::splat(0.7);

/// The picture with the strip below it.
pub(super) fn append(picture: &Image, legend: &Legend) -> Image {
    let mut strip = Strip::below(picture);
    strip.title(legend);
    strip.bar(legend.kind);
    strip.ticks(legend);
    strip.image
}

/// The strip at the foot of `image`, in units of `scale` pixels.
struct Strip {
    image: Image,
    /// First row of the strip.
    top: usize,
    scale: usize,
    lettering: Lettering,
}

impl Strip {
    fn below(picture: &Image) -> Self {
        let scale = (picture.width() / WIDTH_PER_SCALE).max(1);
        let size = [picture.width().max(MIN_WIDTH) as u32, (picture.height() + HEIGHT * scale) as u32];
        let inside = |x: u32, y: u32| x < picture.size[0] && y < picture.size[1];
        let pixel = |x, y| if inside(x, y) { picture.at(x as usize, y as usize) } else { BACKGROUND };
        Self {
            image: Image::from_fn(size, pixel),
            top: picture.height(),
            scale,
            lettering: Lettering::new(TEXT_SIZE * scale as f32),
        }
    }

    /// Width in units of the scale.
    fn width(&self) -> usize {
        self.image.width() / self.scale
    }

    fn fill(&mut self, columns: Range<usize>, rows: Range<usize>, color: Vec3) {
        let stride = self.image.width();
        for y in self.top + rows.start * self.scale..self.top + rows.end * self.scale {
            self.image.pixels[y * stride..][columns.start * self.scale..columns.end * self.scale].fill(color);
        }
    }

    /// Writes a line from its top left corner, in units of the scale.
    fn text(&mut self, text: &str, left: usize, top: usize, color: Vec3) {
        let (stride, scale) = (self.image.width(), self.scale);
        let corner = [left * scale, self.top + top * scale];
        let room = (stride - corner[0]) as f32;
        let pixels = &mut self.image.pixels;
        self.lettering.draw(text, room, |[x, y], share| {
            if let Some(pixel) = pixels.get_mut((corner[1] + y as usize) * stride + corner[0] + x as usize) {
                *pixel = pixel.lerp(color, share);
            }
        });
    }

    /// Width of a line in units of the scale.
    fn text_width(&self, text: &str) -> usize {
        (self.lettering.width(text) / self.scale as f32).ceil() as usize
    }

    fn title(&mut self, legend: &Legend) {
        self.text(legend.kind.title(), MARGIN, TITLE, TEXT);
        if legend.non_finite > 0 {
            let note = format!("not finite: {}", legend.non_finite);
            self.text(&note, self.width() - MARGIN - self.text_width(&note), TITLE, linear(NOT_FINITE));
        }
    }

    fn bar(&mut self, kind: ErrorMap) {
        let columns = self.bar_columns();
        for x in columns.clone() {
            let place = (x - columns.start) as f32 / (columns.len() - 1) as f32;
            self.fill(x..x + 1, BAR, linear(kind.color(kind.error_at(place))));
        }
    }

    fn bar_columns(&self) -> Range<usize> {
        MARGIN..self.width() - MARGIN
    }

    fn ticks(&mut self, legend: &Legend) {
        let bar = self.bar_columns();
        for i in 0..=INTERVALS {
            let x = bar.start + i * (bar.len() - 1) / INTERVALS;
            self.fill(x..x + 1, TICK, TEXT);
            let text = legend.label(i);
            let width = self.text_width(&text);
            let left = x.saturating_sub(width / 2).clamp(bar.start, bar.end - width);
            self.text(&text, left, LABEL, TEXT);
        }
    }
}

impl Legend {
    fn label(&self, tick: usize) -> String {
        let number = short_number(self.top * self.kind.error_at(tick as f32 / INTERVALS as f32));
        if tick == INTERVALS && self.saturated { number + "+" } else { number }
    }
}

/// The number with at most three significant digits, and with an exponent if very small or large.
pub(super) fn short_number(value: f32) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value.abs()) {
        return without_trailing_zeros(&format!("{value:.5}")).to_owned();
    }
    let scientific = format!("{value:.2e}");
    match scientific.split_once('e') {
        Some((mantissa, exponent)) => format!("{}e{exponent}", without_trailing_zeros(mantissa)),
        None => scientific,
    }
}

fn without_trailing_zeros(decimal: &str) -> &str {
    decimal.trim_end_matches('0').trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::{super::magma, *};

    const LEGEND: Legend = Legend { kind: ErrorMap::Relative, top: 0.5, saturated: false, non_finite: 0 };

    fn strip(legend: &Legend) -> Image {
        append(&Image::filled([300, 5], Vec3::ZERO), legend)
    }

    #[test]
    fn numbers_are_short() {
        let numbers = [0.0, 0.125, -0.5, 1.0, 37.5, 2000.0, 0.00125, 2.5e-5, 5e7];
        let texts = ["0", "0.125", "-0.5", "1", "37.5", "2000", "0.00125", "2.5e-5", "5e7"];
        assert_eq!(numbers.map(short_number), texts);
    }

    #[test]
    fn the_bar_runs_through_the_whole_map() {
        let image = strip(&LEGEND);
        let y = 5 + BAR.start;
        assert_eq!(image.at(MARGIN, y), linear(magma(0.0)));
        assert_eq!(image.at(300 - MARGIN - 1, y), linear(magma(1.0)));
        assert_eq!(image.at(300 - MARGIN, y), BACKGROUND);
        assert_eq!(image.size, [300, 5 + HEIGHT as u32]);
    }

    #[test]
    fn what_the_legend_says_is_drawn() {
        let plain = strip(&LEGEND);
        for other in [
            Legend { top: 0.2, ..LEGEND },
            Legend { saturated: true, ..LEGEND },
            Legend { non_finite: 3, ..LEGEND },
            Legend { kind: ErrorMap::Absolute, ..LEGEND },
            Legend { kind: ErrorMap::Signed, ..LEGEND },
        ] {
            assert!(strip(&other) != plain);
        }
        assert!(strip(&LEGEND) == plain, "negative control: the same legend gives the same strip");
    }

    #[test]
    fn narrow_and_wide_pictures_have_room_for_the_text() {
        for width in [0, 1, 239, 641, 1280, 1999] {
            let image = append(&Image::filled([width, 1], Vec3::ZERO), &Legend { non_finite: 999_999, ..LEGEND });
            assert!(image.width() >= MIN_WIDTH);
            let reddest = image.pixels.iter().map(|p| (*p - linear(NOT_FINITE)).length()).fold(f32::INFINITY, f32::min);
            assert!(reddest < 0.3 * (BACKGROUND - linear(NOT_FINITE)).length(), "{width}: {reddest}");
        }
    }
}
