use super::*;

const RED: [u8; 3] = [200, 10, 10];
const BLUE: [u8; 3] = [10, 10, 200];

fn tile(size: [u32; 2], color: [u8; 3], caption: &[&str]) -> Tile {
    Tile { image: DisplayPicture::filled(size, color), caption: caption.iter().map(|line| line.to_string()).collect() }
}

fn at(picture: &DisplayPicture, x: u32, y: u32) -> [u8; 3] {
    let [r, g, b, _] = picture.pixels[(y * picture.size[0] + x) as usize];
    [r, g, b]
}

/// Pixels of a part of the sheet that differ from its background.
fn ink(sheet: &DisplayPicture, columns: std::ops::Range<u32>, rows: std::ops::Range<u32>) -> usize {
    let background = SheetStyle::default().background;
    rows.flat_map(|y| columns.clone().map(move |x| (x, y))).filter(|&(x, y)| at(sheet, x, y) != background).count()
}

#[test]
fn pictures_stand_in_rows_and_columns() {
    let style = SheetStyle { min_column: 0, ..Default::default() };
    let gap = style.gap;
    let tiles = [tile([40, 30], RED, &[]), tile([40, 30], BLUE, &[]), tile([20, 10], RED, &[])];
    let sheet = contact_sheet(&tiles, 2, &style);
    assert_eq!(sheet.size, [3 * gap + 2 * 40, 3 * gap + 30 + 10]);
    assert_eq!(at(&sheet, gap, gap), RED);
    assert_eq!(at(&sheet, 2 * gap + 40, gap), BLUE);
    assert_eq!(at(&sheet, gap + 39, gap + 29), RED);
    assert_eq!(at(&sheet, gap, 2 * gap + 30), RED, "the third begins the second row");
    assert_eq!(at(&sheet, gap + 40, gap), style.background, "a gap lies between them");
    assert_eq!(contact_sheet(&tiles, 3, &style).size[1], 2 * gap + 30, "negative control: all in one row");
}

#[test]
fn any_number_of_tiles_and_columns_is_laid_out() {
    let style = SheetStyle::default();
    let one = [tile([9, 9], RED, &[])];
    assert_eq!(contact_sheet(&one, 0, &style), contact_sheet(&one, 1, &style));
    assert_eq!(contact_sheet(&one, 100, &style), contact_sheet(&one, 1, &style), "no empty columns");
    assert_eq!(contact_sheet(&[], 4, &style).size, [2 * style.gap; 2]);
    assert_eq!(contact_sheet(&one, 1, &style).size[0], style.min_column + 2 * style.gap);
}

#[test]
fn captions_are_written_below_their_own_picture() {
    let style = SheetStyle::default();
    let captioned = |caption: &[&str]| contact_sheet(&[tile([200, 50], RED, caption)], 1, &style);
    let (without, with) = (captioned(&[]), captioned(&["cut 256", "error 0.012"]));
    let line = Lettering::new(style.text_size).line_height();
    assert_eq!(with.size[1], without.size[1] + style.caption_gap + 2 * line);
    let first = style.gap + 50 + style.caption_gap;
    let width = with.size[0];
    assert!(ink(&with, 0..width, first..first + line) > 40, "the first line");
    assert!(ink(&with, 0..width, first + line..first + 2 * line) > 40, "the second line");
    assert_eq!(ink(&with, 0..width, first + 2 * line..with.size[1]), 0, "negative control: nothing below");
    assert_ne!(captioned(&["cut 256"]), captioned(&["cut 512"]), "what is written differs");
    assert_ne!(captioned(&["é 0.5° × 10⁻³"]), captioned(&["? 0.5? ? 10"]));
}

#[test]
fn a_line_that_is_too_wide_ends_within_its_column() {
    let style = SheetStyle::default();
    let long = "roughness 0.05 to 0.8 ".repeat(40);
    let sheet = contact_sheet(&[tile([150, 20], RED, &[&long]), tile([150, 20], BLUE, &[])], 2, &style);
    let below = style.gap + 20..sheet.size[1];
    assert!(ink(&sheet, style.gap..style.gap + 150, below.clone()) > 100);
    assert_eq!(ink(&sheet, style.gap + 150..sheet.size[0], below), 0);
    let lines = contact_sheet(&[tile([150, 20], RED, &["one\ntwo\nthree"])], 1, &style);
    assert_eq!(lines.size[1], sheet.size[1], "a caption's line is one line");
}

#[test]
fn the_background_shows_through_what_a_picture_does_not_cover() {
    let style = SheetStyle { background: [100; 3], min_column: 0, ..Default::default() };
    let image = DisplayPicture { size: [2, 1], pixels: vec![[200, 200, 200, 0], [200, 200, 200, 128]] };
    let sheet = contact_sheet(&[Tile { image, caption: vec![] }], 1, &style);
    assert_eq!(at(&sheet, style.gap, style.gap), [100; 3]);
    assert_eq!(at(&sheet, style.gap + 1, style.gap), [150; 3]);
    assert!(sheet.pixels.iter().all(|pixel| pixel[3] == 255));
}

#[test]
fn shrinking_keeps_the_shape_and_the_mean_in_linear_light() {
    let checks = (0..64 * 32).map(|i| if (i + i / 64) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] });
    let checks = DisplayPicture { size: [64, 32], pixels: checks.collect() };
    let small = checks.shrunk(16);
    assert_eq!(small.size, [16, 8]);
    // Half of the light is 188 of 255 in sRGB; a mean of encoded values would be 128.
    assert!(small.pixels.iter().all(|pixel| *pixel == [188, 188, 188, 255]), "{:?}", small.pixels[0]);
    assert_eq!(checks.shrunk(64), checks);
    assert_eq!(DisplayPicture::filled([1000, 1], RED).shrunk(10), DisplayPicture::filled([10, 1], RED));
}
