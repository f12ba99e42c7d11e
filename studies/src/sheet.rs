//! Contact sheets: pictures in a grid, each with lines of text below; and strips of pictures with their reference.

mod picture;
mod strip;

pub use picture::DisplayPicture;
pub use strip::{GAP, exposure, side_by_side, strip};

use lapidary_render::Lettering;

/// A picture and its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// The picture; its size may differ from the others'.
    pub image: DisplayPicture,
    /// Lines below it, the first one bright; lines wider than the column end in an ellipsis.
    pub caption: Vec<String>,
}

/// Style of a sheet; lengths are in pixels and colors sRGB-encoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetStyle {
    /// Height of an em.
    pub text_size: f32,
    /// Space between tiles and around the sheet.
    pub gap: u32,
    /// Space between a picture and its first line.
    pub caption_gap: u32,
    /// Least column width, for readable captions of small pictures.
    pub min_column: u32,
    /// Background color, which also shows through transparent pictures.
    pub background: [u8; 3],
    /// Color of the first line of captions.
    pub title: [u8; 3],
    /// Color of the other lines.
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

/// Draws the tiles row by row from the top left, `columns` per row (at least one), on an opaque sheet. Columns are as wide as the
/// widest picture; each row fits its highest picture and longest caption. Without tiles the sheet is two gaps wide and high.
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

/// Draws a tile. Its caption follows its own picture, so a low picture stays close to its text.
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
