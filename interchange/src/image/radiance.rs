//! Radiance pictures: what the header asks of the pixels. The `image` crate decodes the scanlines.
//!
//! Ward, *Real Pixels*, Graphics Gems II; Radiance, *File Formats*, "Picture File Format". The format divides by
//! `EXPOSURE` and `COLORCORR` to get radiance; several lines multiply. Each of the eight orientations is turned upright.

use super::{
    primaries,
    read::{check_size, damaged, truncated, undecodable},
    remark::Remark,
};
use glam::{DVec2, Vec3};
use image::{ImageDecoder, codecs::hdr::HdrDecoder};
use lapidary_core::{color::Primaries, image::ImageError, texture::Texels};
use std::{io::Read, path::Path};

/// First bytes of the files. `#?RADIANCE` is usual; other programs write their own names, as in `#?RGBE`.
pub(super) const SIGNATURE: &[u8] = b"#?";

/// Longest text of a file that a message repeats, in characters.
const QUOTED: usize = 40;

/// Most remarks on lines of a header.
const MOST_REMARKS: usize = 4;

/// The header of a picture.
#[derive(Debug)]
pub(super) struct Header {
    /// The axis from scanline to scanline, and the one along a scanline.
    axes: [Axis; 2],
    values: Values,
    /// First byte of the scanlines.
    scanlines: usize,
}

/// An axis of the resolution line, as in `-Y 512`.
#[derive(Clone, Copy, Debug)]
struct Axis {
    is_x: bool,
    /// Whether the coordinate, right or up, grows.
    grows: bool,
    length: u32,
}

/// What the variables of the header say about the pixels.
#[derive(Debug)]
struct Values {
    /// Divides the stored components.
    divisor: Vec3,
    primaries: Option<Primaries>,
    is_xyz: bool,
    /// Lines that are left out.
    remarks: Vec<Remark>,
}

impl Header {
    pub fn read(bytes: &[u8], path: &Path) -> Result<Self, ImageError> {
        let mut rest = bytes;
        let mut line = || next_line(&mut rest).ok_or_else(|| truncated(path, "its header has no end"));
        let mut values = Values { divisor: Vec3::ONE, primaries: None, is_xyz: false, remarks: Vec::new() };
        line()?; // the signature
        loop {
            let text = line()?;
            if text.is_empty() {
                break;
            }
            values.take(&text).map_err(|reason| damaged(path, reason))?;
        }
        let axes = axes(&line()?).map_err(|reason| damaged(path, reason))?;
        values.check_divisor();
        let header = Self { axes, values, scanlines: bytes.len() - rest.len() };
        let [width, height] = header.size();
        check_size(width.into(), height.into(), path)?;
        Ok(header)
    }

    /// Width and height of the upright picture.
    pub fn size(&self) -> [u32; 2] {
        let [across, along] = self.axes.map(|axis| axis.length);
        if self.axes[0].is_x { [across, along] } else { [along, across] }
    }

    /// Column and row, from the top left, of a stored pixel.
    fn position(&self, scanline: u32, pixel: u32) -> [u32; 2] {
        let [across, along] = self.axes;
        let (across, along) = (across.along(scanline), along.along(pixel));
        if self.axes[0].is_x { [across, along] } else { [along, across] }
    }
}

impl Axis {
    fn parse(word: &str, length: &str) -> Option<Self> {
        let (is_x, grows) = match word {
            "+X" => (true, true),
            "-X" => (true, false),
            "+Y" => (false, true),
            "-Y" => (false, false),
            _ => return None,
        };
        Some(Self { is_x, grows, length: length.parse().ok()? })
    }

    /// Place on this axis of the `step`-th row from the top, or column from the left.
    fn along(self, step: u32) -> u32 {
        if self.is_x == self.grows { step } else { self.length - 1 - step }
    }
}

impl Values {
    fn take(&mut self, line: &str) -> Result<(), String> {
        // Lines of pictures that this one was made of are indented, and so have other names.
        let Some((name, value)) = line.split_once('=') else { return Ok(()) };
        match name.trim_end() {
            "FORMAT" => match value.trim() {
                "32-bit_rle_rgbe" => self.is_xyz = false,
                "32-bit_rle_xyze" => self.is_xyz = true,
                other => {
                    let formats = "only 32-bit_rle_rgbe and 32-bit_rle_xyze are supported";
                    return Err(format!("its FORMAT is \"{}\"; {formats}", quoted(other)));
                }
            },
            "EXPOSURE" => {
                let [exposure] = self.numbers("EXPOSURE", value, Remark::Scale).unwrap_or([1.0]);
                self.divisor *= exposure;
            }
            "COLORCORR" => {
                let correction = self.numbers("COLORCORR", value, Remark::Scale).unwrap_or([1.0; 3]);
                self.divisor *= Vec3::from_array(correction);
            }
            "PRIMARIES" => {
                let numbers = self.numbers("PRIMARIES", value, Remark::Colors);
                let Some([rx, ry, gx, gy, bx, by, wx, wy]) = numbers else { return Ok(()) };
                let [red, green, blue, white] =
                    [(rx, ry), (gx, gy), (bx, by), (wx, wy)].map(|(x, y)| DVec2::new(x.into(), y.into()));
                self.primaries = Some(Primaries { red, green, blue, white });
            }
            _ => {}
        }
        Ok(())
    }

    /// The numbers of a line, or none with a remark.
    fn numbers<const N: usize>(
        &mut self,
        name: &str,
        value: &str,
        remark: impl Fn(String) -> Remark,
    ) -> Option<[f32; N]> {
        let numbers: Result<Vec<f32>, _> = value.split_whitespace().map(str::parse).collect();
        let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
        if numbers.is_none() && self.remarks.len() < MOST_REMARKS {
            let value = quoted(value);
            self.remarks.push(remark(format!("its {name} is \"{value}\" in place of {N} numbers, and is left out")));
        }
        numbers
    }

    /// Leaves out a divisor that is out of range.
    fn check_divisor(&mut self) {
        if !(self.divisor.is_finite() && self.divisor.min_element() > 0.0) {
            self.divisor = Vec3::ONE;
            let text = "the product of its EXPOSURE and COLORCORR lines is out of range, and is left out";
            self.remarks.push(Remark::Scale(text.into()));
        }
    }
}

fn quoted(text: &str) -> String {
    text.chars().take(QUOTED).collect()
}

fn axes(line: &str) -> Result<[Axis; 2], String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let parsed = match words[..] {
        [a, length_a, b, length_b] => Axis::parse(a, length_a).zip(Axis::parse(b, length_b)),
        _ => None,
    };
    match parsed {
        Some((across, along)) if across.is_x != along.is_x => Ok([across, along]),
        _ => Err(format!("its resolution is \"{}\"; it must be like \"-Y 512 +X 1024\"", quoted(line))),
    }
}

fn next_line(rest: &mut &[u8]) -> Option<String> {
    let end = rest.iter().position(|&byte| byte == b'\n')?;
    let line = String::from_utf8_lossy(&rest[..end]).trim_end_matches('\r').to_owned();
    *rest = &rest[end + 1..];
    Some(line)
}

/// Radiance, upright; `remarks` gets what of the header is left out.
pub(super) fn decode(bytes: &[u8], path: &Path, remarks: &mut Vec<Remark>) -> Result<([u32; 2], Texels), ImageError> {
    let mut header = Header::read(bytes, path)?;
    remarks.append(&mut header.values.remarks);
    let stored = stored_pixels(&header, &bytes[header.scanlines..]).map_err(|e| undecodable(path, e))?;
    let size = header.size();
    let mut texels = vec![[0.0, 0.0, 0.0, 1.0]; stored.len()];
    let along = header.axes[1].length;
    for (i, &rgb) in stored.iter().enumerate() {
        let [x, y] = header.position(i as u32 / along, i as u32 % along);
        let [r, g, b] = (Vec3::from_array(rgb) / header.values.divisor).to_array();
        texels[y as usize * size[0] as usize + x as usize] = [r, g, b, 1.0];
    }
    let named = if header.values.is_xyz { Some(Primaries::XYZ) } else { header.values.primaries };
    let to_rec_709 = named.and_then(|found| primaries::rec_709_or_remark(&found, remarks));
    Ok((size, primaries::texels(texels, to_rec_709)))
}

/// The pixels in the order of the file. The decoder knows one signature, one format and one orientation.
fn stored_pixels(header: &Header, scanlines: &[u8]) -> image::ImageResult<Vec<[f32; 3]>> {
    let [across, along] = header.axes.map(|axis| axis.length);
    let plain = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {across} +X {along}\n");
    let mut pixels = vec![[0.0; 3]; across as usize * along as usize];
    HdrDecoder::new(plain.as_bytes().chain(scanlines))?.read_image(bytemuck::cast_slice_mut(&mut pixels))?;
    Ok(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::texture::{ColorSpace, Texture};

    /// A file of uncompressed pixels.
    fn file(header: &str, pixels: &[[u8; 4]]) -> Vec<u8> {
        [header.as_bytes(), pixels.as_flattened()].concat()
    }

    fn read(bytes: &[u8]) -> Result<Texture, String> {
        crate::image::decode(bytes, Path::new("a.hdr")).map_err(|e| e.to_string())
    }

    fn first(header: &str, pixel: [u8; 4]) -> Vec3 {
        let texture = read(&file(header, &[pixel])).unwrap();
        texture.texel(0, 0, ColorSpace::Srgb).truncate()
    }

    #[test]
    fn any_program_may_have_signed_the_file() {
        for name in ["RADIANCE", "RGBE", "other\r"] {
            let header = format!("#?{name}\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
            assert_eq!(first(&header, [128, 64, 32, 129]), Vec3::new(1.0, 0.5, 0.25), "{name}");
        }
    }

    #[test]
    fn exposure_and_colour_correction_are_divided_out_and_several_lines_multiply() {
        let header = |lines: &str| format!("#?RADIANCE\n{lines}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
        let of = |lines: &str| first(&header(lines), [128, 128, 128, 131]);
        assert_eq!(of(""), Vec3::splat(4.0), "negative control");
        assert_eq!(of("EXPOSURE=4.0\n"), Vec3::ONE);
        assert_eq!(of("EXPOSURE=2\nEXPOSURE= 8e0\n\tEXPOSURE=100\n"), Vec3::splat(0.25));
        assert_eq!(of("COLORCORR=1 2 4\nEXPOSURE=0.5\n"), Vec3::new(8.0, 4.0, 2.0));
        for (wrong, word) in [
            ("EXPOSURE=0\n", "out of range"),
            ("EXPOSURE=x\n", "its EXPOSURE is \"x\""),
            ("COLORCORR=1 1\n", "3 numbers"),
            ("PRIMARIES=1\n", "8 numbers"),
            ("PRIMARIES=0 0 0 0 0 0 0 0\n", "span no colors"),
        ] {
            let bytes = file(&header(wrong), &[[128, 128, 128, 131]]);
            let mut remarks = Vec::new();
            let texture = crate::image::decode_with(&bytes, Path::new("a.hdr"), None, &mut remarks).unwrap();
            assert_eq!(texture.texel(0, 0, Default::default()).truncate(), Vec3::splat(4.0), "as without the line");
            assert!(remarks.len() == 1 && remarks[0].contains(word), "{remarks:?}");
        }
    }

    #[test]
    fn damaged_primaries_are_a_remark_that_a_given_space_settles_and_damaged_exposures_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.hdr");
        for (line, is_of_colors) in [
            ("PRIMARIES=1\n", true),
            ("PRIMARIES=0 0 0 0 0 0 0 0\n", true),
            ("EXPOSURE=x\n", false),
            ("EXPOSURE=0\n", false),
            ("COLORCORR=1 1\nPRIMARIES=1\n", false),
        ] {
            let header = format!("#?RADIANCE\n{line}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
            std::fs::write(&path, file(&header, &[[128, 128, 128, 129]])).unwrap();
            let read = |space| crate::image::read_in(&path, space).map(|(image, told)| (image.pixels[0], told));
            assert!(crate::image::read(&path).is_err(), "{line}");
            let as_named = read(ColorSpace::Srgb).map(|(pixel, told)| (pixel, told.len()));
            assert_eq!(as_named.ok(), is_of_colors.then_some((Vec3::ONE, 1)), "{line}: Photoshop writes such files");
            match read(ColorSpace::Linear) {
                Ok(read) => assert!(is_of_colors && read == (Vec3::ONE, Vec::new()), "{line}: {read:?}"),
                Err(error) => assert!(!is_of_colors && error.to_string().contains(&line[..8]), "{line}: {error}"),
            }
        }
    }

    #[test]
    fn a_given_space_takes_the_place_of_xyz() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.hdr");
        let pixel = [[64, 192, 32, 128]];
        let read = |format: &str, space| {
            std::fs::write(&path, file(&format!("#?RADIANCE\nFORMAT={format}\n\n-Y 1 +X 1\n"), &pixel)).unwrap();
            crate::image::read_in(&path, space).unwrap().0.pixels[0]
        };
        let stored = Vec3::new(0.25, 0.75, 0.125);
        assert_eq!(read("32-bit_rle_xyze", ColorSpace::Linear), stored, "values stay");
        // Once converted: as the same numbers in a file that does not say what they are.
        let given = read("32-bit_rle_xyze", ColorSpace::AcesCg);
        assert_eq!(given, read("32-bit_rle_rgbe", ColorSpace::AcesCg));
        assert!((given - read("32-bit_rle_xyze", ColorSpace::Srgb)).abs().max_element() > 0.05, "negative control");
    }

    #[test]
    fn every_orientation_is_turned_upright() {
        // The upright picture has 3 x 2 pixels with the values 1 to 6.
        let cases = [
            ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
            ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
            ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
            ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
            ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
            ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
            ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
            ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
        ];
        let shown = |resolution: &str, stored: [u8; 6]| {
            let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{resolution}\n");
            let texture = read(&file(&header, &stored.map(|value| [value, 0, 0, 136]))).unwrap();
            let value = |i: i64| texture.texel(i % 3, i / 3, Default::default()).x;
            (texture.size, [0, 1, 2, 3, 4, 5].map(value))
        };
        let upright = ([3, 2], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for (resolution, stored) in cases {
            assert_eq!(shown(resolution, stored), upright, "{resolution}");
            assert!(resolution == "-Y 2 +X 3" || shown("-Y 2 +X 3", stored) != upright, "negative control");
        }
        for wrong in ["-Y 2 +Y 3", "-Y 2 +X", "-Y 2 +Z 3", "-Y -2 +X 3"] {
            let header = format!("#?RADIANCE\n\n{wrong}\n");
            assert!(read(header.as_bytes()).unwrap_err().contains(wrong));
        }
    }

    #[test]
    fn xyz_becomes_rec_709_with_gray_as_gray() {
        let header = |format: &str| format!("#?RADIANCE\nFORMAT={format}\n\n-Y 1 +X 1\n");
        let gray = first(&header("32-bit_rle_xyze"), [128, 128, 128, 129]);
        assert!((gray - 1.0).abs().max_element() < 1e-5, "{gray}");
        // Green of Rec. 709, adapted from D65 to the equal white of the format by Bradford: X Y Z.
        let xyz = [100, 181, 28, 128]; // 0.392, 0.709, 0.110
        let green = first(&header("32-bit_rle_xyze"), xyz);
        assert!((green - Vec3::Y).abs().max_element() < 0.02, "{green}");
        assert!((first(&header("32-bit_rle_rgbe"), xyz) - Vec3::Y).abs().max_element() > 0.2, "negative control");
        let message = read(header("16-bit").as_bytes()).unwrap_err();
        assert!(message.contains("16-bit") && message.contains("supported"), "{message}");
    }

    #[test]
    fn primaries_of_the_header_are_converted() {
        let header = |line: &str| format!("#?RADIANCE\n{line}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
        let ap1 = "PRIMARIES= 0.713 0.293 0.165 0.830 0.128 0.044 0.32168 0.33767\n";
        let [with, without] = [ap1, ""].map(|line| first(&header(line), [64, 192, 32, 128]));
        assert_eq!(without, Vec3::new(0.25, 0.75, 0.125));
        assert!(with.x < 0.0 && with.y > 0.8, "{with}");
    }

    #[test]
    fn a_header_without_end_is_truncated_and_says_so() {
        for cut in ["#?RADIANCE", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "#?RADIANCE\n\n-Y 4 +X 4"] {
            let message = read(cut.as_bytes()).unwrap_err();
            assert!(message.contains("truncated"), "{message}");
        }
        let pixels = file("#?RADIANCE\n\n-Y 4 +X 4\n", &[[1, 2, 3, 128]]);
        assert!(read(&pixels).unwrap_err().contains("truncated"));
    }
}
