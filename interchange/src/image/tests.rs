//! TIFF, WebP and KTX2 files, which are read and not written, and what becomes of damaged ones.

use super::decode;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
use lapidary_core::{image::ImageError, texture::Texels};
use std::{io::Cursor, path::Path};
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype};

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A TIFF of 4 by 2 samples of one kind.
fn compressed<C: colortype::ColorType>(compression: Compression, samples: &[C::Inner]) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression);
    encoder.write_image::<C>(4, 2, samples).unwrap();
    bytes.into_inner()
}

fn texels(bytes: &[u8], name: &str) -> Texels {
    decode(bytes, Path::new(name)).unwrap().texels
}

fn refusal(bytes: &[u8], name: &str) -> String {
    decode(bytes, Path::new(name)).unwrap_err().to_string()
}

#[test]
fn integers_of_a_tiff_keep_their_bits() {
    let tiff = |image: DynamicImage| texels(&encoded(image, ImageFormat::Tiff), "a.tif");
    assert_eq!(
        tiff(ImageBuffer::from_pixel(2, 1, Luma([7u8])).into()),
        Texels::U8(vec![[7, 7, 7, 255]; 2]),
        "gray of 8 bits"
    );
    let deep = tiff(ImageBuffer::from_pixel(2, 1, Rgb([300u16, 0, 65_535])).into());
    assert_eq!(deep, Texels::U16(vec![[300, 0, 65_535, 65_535]; 2]));
    assert_eq!(tiff(ImageBuffer::from_pixel(1, 1, Luma([300u16])).into()), Texels::U16(vec![[300, 300, 300, 65_535]]));
    assert_eq!(tiff(ImageBuffer::from_pixel(1, 1, Rgba([1u16, 2, 3, 4])).into()), Texels::U16(vec![[1, 2, 3, 4]]));
    let rgb: Vec<u16> = (0..24).map(|i| i * 1000).collect();
    let expected = Texels::U16(rgb.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 65_535]).collect());
    for compression in [Compression::Uncompressed, Compression::Lzw, Compression::Deflate(DeflateLevel::Fast)] {
        assert_eq!(texels(&compressed::<colortype::RGB16>(compression, &rgb), "a.tiff"), expected);
    }
}

#[test]
fn floats_of_a_tiff_keep_their_range_in_color_and_gray() {
    let floats = [-1.5f32, 0.0, 1e-7, 0.25, 1.0, 12.5, 6e4, 3.0];
    let gray = Texels::F32(floats.iter().map(|&x| [x, x, x, 1.0]).collect());
    for compression in [Compression::Uncompressed, Compression::Lzw, Compression::Deflate(DeflateLevel::Fast)] {
        let bytes = compressed::<colortype::Gray32Float>(compression, &floats);
        assert_eq!(texels(&bytes, "height.tif"), gray);
    }
    let doubles = floats.map(f64::from);
    assert_eq!(texels(&compressed::<colortype::Gray64Float>(Compression::Lzw, &doubles), "height.tif"), gray);
    // Halves: 16-bit integers that a tag declares as floats (tag 339, one short, value 3).
    let mut halves = compressed::<colortype::Gray16>(Compression::Uncompressed, &[0x3e00; 8]);
    let tag = halves.windows(10).position(|w| w == [0x53, 1, 3, 0, 1, 0, 0, 0, 1, 0]).unwrap();
    halves[tag + 8] = 3;
    assert_eq!(texels(&halves, "height.tif"), Texels::F32(vec![[1.5, 1.5, 1.5, 1.0]; 8]));
    let rgb: Vec<f32> = floats.repeat(3);
    let expected = Texels::F32(rgb.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect());
    assert_eq!(texels(&compressed::<colortype::RGB32Float>(Compression::Lzw, &rgb), "a.tif"), expected);
    let whole = compressed::<colortype::Gray32>(Compression::Lzw, &[1u32; 8]);
    let message = refusal(&whole, "a.tif");
    assert!(
        message.contains("it is a tiff of a kind that is not supported") && message.ends_with("(a.tif)"),
        "{message}"
    );
}

#[test]
fn a_webp_has_its_codes_and_its_alpha() {
    let picture = ImageBuffer::from_fn(5, 3, |x, y| Rgba([40 * x as u8, 80 * y as u8, 7, 255 - x as u8]));
    let expected = Texels::U8(picture.pixels().map(|pixel| pixel.0).collect());
    let bytes = encoded(picture, ImageFormat::WebP);
    assert_eq!(texels(&bytes, "a.webp"), expected);
    assert_eq!(texels(&bytes, "named-wrong.png"), expected, "the contents decide");
    let opaque = encoded(ImageBuffer::from_pixel(1, 1, Rgb([1u8, 2, 3])), ImageFormat::WebP);
    assert_eq!(texels(&opaque, "a.webp"), Texels::U8(vec![[1, 2, 3, 255]]));
}

/// A block of UASTC in one color: the mode 8, coded in five bits, and the color.
fn solid([r, g, b, a]: [u8; 4]) -> [u8; 16] {
    let color = u128::from(u32::from_le_bytes([r, g, b, a]));
    (0b10111 | color << 5).to_le_bytes()
}

/// A KTX2 of 8 by 4 texels in two blocks of UASTC (KTX 2.0, section 3).
fn ktx2(colors: [[u8; 4]; 2]) -> Vec<u8> {
    let words = [0u32, 1, 8, 4, 0, 0, 1, 1, 0, 104, 44, 0, 0, 0, 0, 0, 0];
    let level = [160u64, 32, 32];
    let descriptor =
        [44u32, 0, 2 | 40 << 16, 166 | 1 << 8 | 1 << 16, 3 | 3 << 8, 16, 0, 127 << 16 | 3 << 24, 0, 0, u32::MAX];
    let mut bytes = super::ktx2::SIGNATURE.to_vec();
    bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend(level.iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend(descriptor.iter().flat_map(|word| word.to_le_bytes()));
    bytes.resize(160, 0);
    bytes.extend(colors.map(solid).concat());
    bytes
}

const COLORS: [[u8; 4]; 2] = [[10, 20, 30, 255], [200, 0, 255, 128]];

#[test]
fn a_ktx2_of_basis_universal_has_its_codes() {
    let row = [[COLORS[0]; 4], [COLORS[1]; 4]].concat();
    let texture = decode(&ktx2(COLORS), Path::new("a.ktx2")).unwrap();
    assert_eq!((texture.size, texture.texels), ([8, 4], Texels::U8(row.repeat(4))));
}

#[test]
fn other_ktx2_files_are_told_what_they_hold() {
    let with = |at: usize, value: u8| {
        let mut bytes = ktx2(COLORS);
        bytes[at] = value;
        refusal(&bytes, "a.ktx2")
    };
    for (at, value, reason) in [
        (12, 37, "in the format 37 of graphics cards, and only Basis Universal"),
        (36, 6, "several pictures, such as a cube map"),
        (32, 2, "several pictures"),
        (44, 9, "its Basis Universal texture is damaged"),
        (20, 0, "it has no pixels"),
    ] {
        let message = with(at, value);
        assert!(
            message.contains(reason) && message.ends_with("(a.ktx2)") && !message.contains("truncated"),
            "{message}"
        );
    }
    let mut huge = ktx2(COLORS);
    huge[20..28].copy_from_slice(&[0xff; 8]);
    assert!(matches!(decode(&huge, Path::new("a.ktx2")), Err(ImageError::TooLarge { .. })));
}

#[test]
fn damaged_pictures_are_errors_and_never_panics() {
    let random = &mut fastrand::Rng::with_seed(7);
    let picture = || ImageBuffer::from_fn(13, 7, |x, y| Rgb([19 * x as u8, 30 * y as u8, (x * y) as u8]));
    let gray: Vec<f32> = (0..8).map(|i| i as f32).collect();
    let deep = ImageBuffer::from_pixel(5, 5, LumaA([300u16, 9]));
    for (name, whole) in [
        ("a.webp", encoded(picture(), ImageFormat::WebP)),
        ("a.tif", encoded(DynamicImage::ImageLumaA16(deep).into_rgba16(), ImageFormat::Tiff)),
        ("b.tif", compressed::<colortype::Gray32Float>(Compression::Lzw, &gray)),
        ("a.ktx2", ktx2(COLORS)),
    ] {
        let path = Path::new(name);
        decode(&whole, path).unwrap();
        // The last byte of a webp is padding.
        for length in 0..whole.len() - 1 {
            assert!(decode(&whole[..length], path).is_err(), "{name} cut to {length} of {}", whole.len());
        }
        for _ in 0..1500 {
            let mut bytes = whole.clone();
            for _ in 0..random.usize(1..4) {
                let at = random.usize(..bytes.len());
                bytes[at] = random.u8(..);
            }
            let _ = decode(&bytes, path);
        }
    }
}
