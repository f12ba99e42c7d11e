//! Lines of text on pictures, in the typeface of the window.

use super::DisplayPicture;
use egui::{
    Color32, ColorImage, FontDefinitions, FontId, Pos2,
    epaint::text::{Fonts, Galley, Glyph, LayoutJob, TextOptions, TextWrapping},
};
use std::sync::Arc;

/// One pixel a point: pictures have no other scale.
const PIXELS_PER_POINT: f32 = 1.0;

/// Draws lines of one size.
pub struct Lettering {
    fonts: Fonts,
    font: FontId,
    /// In pixels, from one line to the next.
    line_height: u32,
}

impl Lettering {
    /// Letters whose em is `size` pixels high.
    pub fn new(size: f32) -> Self {
        let mut fonts = Fonts::new(TextOptions::default(), FontDefinitions::default());
        let font = FontId::proportional(size);
        let line_height = fonts.with_pixels_per_point(PIXELS_PER_POINT).row_height(&font).ceil() as u32;
        Self { fonts, font, line_height }
    }

    /// Pixels from one line to the next.
    pub fn line_height(&self) -> u32 {
        self.line_height
    }

    /// Draws a line from its top left corner; what is wider than `width` pixels ends in an ellipsis.
    pub fn write(&mut self, on: &mut DisplayPicture, line: &str, corner: [u32; 2], width: u32, color: [u8; 3]) {
        let galley = self.laid_out(line, width);
        // The atlas holds the letters of the line only after it is laid out.
        let atlas = self.fonts.texture_atlas().image();
        for row in &galley.rows {
            for glyph in &row.row.glyphs {
                draw(on, atlas, glyph, row.pos, corner, color);
            }
        }
    }

    fn laid_out(&mut self, line: &str, width: u32) -> Arc<Galley> {
        let mut job = LayoutJob::simple_singleline(line.to_owned(), self.font.clone(), Color32::WHITE);
        job.wrap = TextWrapping::truncate_at_width(width as f32);
        self.fonts.with_pixels_per_point(PIXELS_PER_POINT).layout_job(job)
    }
}

/// Blends the coverage that the atlas holds of a letter.
fn draw(on: &mut DisplayPicture, atlas: &ColorImage, glyph: &Glyph, row: Pos2, corner: [u32; 2], color: [u8; 3]) {
    let at = row + glyph.pos.to_vec2() + glyph.uv_rect.offset;
    let [left, top] = [corner[0] as f32 + at.x.round(), corner[1] as f32 + at.y.round()];
    let ([first_x, first_y], [end_x, end_y]) = (glyph.uv_rect.min, glyph.uv_rect.max);
    for y in first_y..end_y {
        for x in first_x..end_x {
            let coverage = atlas[(x.into(), y.into())].a();
            let place = [left + f32::from(x - first_x), top + f32::from(y - first_y)];
            // Overhang to the left of or above the sheet has no pixel.
            if coverage > 0 && place.iter().all(|p| *p >= 0.0) {
                on.blend(place.map(|p| p as u32), color, coverage);
            }
        }
    }
}
