//! Contact sheets: pictures in a grid, each with lines of text below it; and strips of pictures against the truth.

mod picture;
mod strip;

pub use picture::DisplayPicture;
pub use strip::{GAP, exposure, side_by_side, strip};

use lapidary_render::Lettering;

/// A picture and what is said of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// The picture; its size may differ from the others'.
    pub image: DisplayPicture,
    /// Lines below it, the first one bright; a line that is wider than the column ends in an ellipsis.
    pub caption: Vec<String>,
}

/// How a sheet looks; lengths are in pixels and colors sRGB-encoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetStyle {
    /// Height of the letters' em.
    pub text_size: f32,
    /// Between tiles, and around the sheet.
    pub gap: u32,
    /// Between a picture and the first line below it.
    pub caption_gap: u32,
    /// Columns are at least as wide, so that captions of small pictures can be read.
    pub min_column: u32,
    /// Behind everything, and through what pictures do not cover.
    pub background: [u8; 3],
    /// Of the first line of captions.
    pub title: [u8; 3],
    /// Of the other lines.
    pub text: [u8; 3],
}

impl Default for SheetStyle {
    fn default() -> Self {
        Self {
            text_size: 14.0,
            gap: 12,
            caption_gap: 5,
            min_column: 120,
            background: [24; 3],
            title: [235; 3],
            text: [160; 3],
        }
    }
}

/// The tiles row by row from the top left, `columns` in a row (at least one), on an opaque sheet. Columns are as wide as the
/// widest picture, rows as high as their highest picture and longest caption. Without tiles it is an empty sheet of two gaps
/// a side.
pub fn contact_sheet(tiles: &[Tile], columns: usize, style: &SheetStyle) -> DisplayPicture {
    let columns = columns.clamp(1, tiles.len().max(1));
    let lettering = &Lettering::new(style.text_size);
    let widest = tiles.iter().map(|tile| tile.image.size[0]).max();
    let column = widest.map_or(0, |widest| widest.max(style.min_column));
    let heights: Vec<u32> = tiles.chunks(columns).map(|row| row_height(row, lettering.line_height(), style)).collect();
    let width = style.gap + columns as u32 * (column + style.gap);
    let height = style.gap + heights.iter().map(|height| height + style.gap).sum::<u32>();
    let mut sheet = DisplayPicture::filled([width.max(2 * style.gap), height.max(2 * style.gap)], style.background);
    let mut top = style.gap;
    for (row, height) in tiles.chunks(columns).zip(heights) {
        for (i, tile) in row.iter().enumerate() {
            let left = style.gap + i as u32 * (column + style.gap);
            draw(&mut sheet, tile, [left, top], column, lettering, style);
        }
        top += height + style.gap;
    }
    sheet
}

fn row_height(row: &[Tile], line: u32, style: &SheetStyle) -> u32 {
    let pictures = row.iter().map(|tile| tile.image.size[1]).max().unwrap_or(0);
    let lines = row.iter().map(|tile| tile.caption.len() as u32).max().unwrap_or(0);
    if lines == 0 { pictures } else { pictures + style.caption_gap + lines * line }
}

/// Captions follow their own picture, so that a low one does not stand far above its text.
fn draw(
    sheet: &mut DisplayPicture,
    tile: &Tile,
    [left, top]: [u32; 2],
    column: u32,
    lettering: &Lettering,
    style: &SheetStyle,
) {
    sheet.paste(&tile.image, [left, top]);
    let mut line_top = top + tile.image.size[1] + style.caption_gap;
    for (i, line) in tile.caption.iter().enumerate() {
        let color = if i == 0 { style.title } else { style.text };
        lettering.draw(line, column as f32, |[x, y], share| {
            sheet.blend([left + x, line_top + y], color, (255.0 * share).round() as u8);
        });
        line_top += lettering.line_height();
    }
}

#[cfg(test)]
mod tests;
