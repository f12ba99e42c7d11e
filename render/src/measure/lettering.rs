//! Lines of text on pictures, in the typeface of the window: under error maps and on contact sheets.

use ab_glyph::{Font, FontRef, Glyph, PxScale, PxScaleFont, ScaleFont, point};
use epaint_default_fonts::UBUNTU_LIGHT;

/// Replaces the end of a line that is too wide.
const ELLIPSIS: char = '…';

/// Draws lines of one size.
pub struct Lettering {
    font: PxScaleFont<FontRef<'static>>,
}

impl Lettering {
    /// Letters whose em is `size` pixels high.
    ///
    /// # Panics
    /// Never: the typeface is part of the program.
    pub fn new(size: f32) -> Self {
        let font = FontRef::try_from_slice(UBUNTU_LIGHT).expect("the typeface is a part of the program");
        // A scale is the height of a line; an em is a fixed part of it.
        let units_per_em = font.units_per_em().unwrap_or(font.height_unscaled());
        let scale = PxScale::from(size * font.height_unscaled() / units_per_em);
        Self { font: font.into_scaled(scale) }
    }

    /// Pixels from one line to the next.
    pub fn line_height(&self) -> u32 {
        self.font.height().ceil() as u32
    }

    /// Width of a line in pixels.
    pub fn width(&self, line: &str) -> f32 {
        self.layout(line.chars()).1
    }

    /// Passes each pixel of a line to `cover`, with its coverage by letters (0 to 1). Positions are in pixels right of and below
    /// the line's top left corner. A line wider than `width` pixels ends in an ellipsis; text of several lines ends at the first.
    pub fn draw(&self, line: &str, width: f32, mut cover: impl FnMut([u32; 2], f32)) {
        let line = line.lines().next().unwrap_or_default();
        for glyph in self.fitted(line, width) {
            let Some(outline) = self.font.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, share| {
                let place = [corner.x + x as f32, corner.y + y as f32];
                // Overhang to the left of or above the line has no pixels.
                if share > 0.0 && place[0] >= 0.0 && place[1] >= 0.0 && place[0] < width {
                    cover(place.map(|p| p as u32), share.min(1.0));
                }
            });
        }
    }

    /// The part of a line that fits.
    fn fitted(&self, line: &str, width: f32) -> Vec<Glyph> {
        let (glyphs, whole) = self.layout(line.chars());
        if whole <= width {
            return glyphs;
        }
        let characters = line.chars().count();
        let shortened = |kept: usize| self.layout(line.chars().take(kept).chain([ELLIPSIS]));
        let fits = (0..characters).rev().map(shortened).find(|(_, wide)| *wide <= width);
        fits.map_or_else(Vec::new, |(glyphs, _)| glyphs)
    }

    /// Letters side by side with kerning, and the position after the last.
    fn layout(&self, line: impl Iterator<Item = char>) -> (Vec<Glyph>, f32) {
        let (mut glyphs, mut x) = (Vec::<Glyph>::new(), 0.0);
        for character in line {
            let mut glyph = self.font.scaled_glyph(character);
            if let Some(before) = glyphs.last() {
                x += self.font.kern(before.id, glyph.id);
            }
            glyph.position = point(x, self.font.ascent());
            x += self.font.h_advance(glyph.id);
            glyphs.push(glyph);
        }
        (glyphs, x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Covered area in pixels, and its right end.
    fn ink(line: &str, width: f32) -> (f32, u32) {
        let (mut area, mut right) = (0.0, 0);
        Lettering::new(14.0).draw(line, width, |[x, _], share| {
            area += share;
            right = right.max(x);
        });
        (area, right)
    }

    #[test]
    fn letters_add_up_and_end_where_the_width_says() {
        let lettering = Lettering::new(14.0);
        let (one, end) = ink("n", 100.0);
        let (three, _) = ink("nnn", 100.0);
        assert!((three / one - 3.0).abs() < 0.1, "{three} of {one}");
        assert!((lettering.width("nnn") - 3.0 * lettering.width("n")).abs() < 0.1);
        assert!(end as f32 <= lettering.width("n"));
        assert_eq!(ink(" ", 100.0), (0.0, 0), "negative control");
        assert!((14..=18).contains(&lettering.line_height()));
    }

    #[test]
    fn a_line_that_is_too_wide_ends_in_an_ellipsis() {
        let lettering = Lettering::new(14.0);
        let long = "roughness 0.05 to 0.8 ".repeat(9);
        assert!(ink(&long, 90.0).1 < 90);
        let room = lettering.width("roug…");
        assert_eq!(ink("roughness", room), ink("roug…", room));
        assert_eq!(ink("one\ntwo", 90.0), ink("one", 90.0));
        assert_eq!(ink("wide", 0.5).0, 0.0);
    }

    #[test]
    fn numbers_units_and_accents_are_in_the_typeface() {
        let missing = |c: char| Lettering::new(14.0).font.glyph_id(c).0 == 0;
        assert!("0123456789.+-e°×é…".chars().all(|c| !missing(c)));
        assert!(missing('漢'), "negative control");
    }
}
