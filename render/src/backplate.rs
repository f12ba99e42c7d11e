//! A picture behind the scene, as it is displayed: the scene lies over it by its coverage, and a ground that catches shadows darkens
//! it.

/// A picture behind the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Backplate {
    size: [u32; 2],
    /// sRGB codes, row by row.
    pixels: Vec<[u8; 3]>,
}

impl Backplate {
    /// A picture of sRGB codes; `None` unless it has as many pixels as its size says, and at least one.
    pub fn new(size: [u32; 2], pixels: Vec<[u8; 3]>) -> Option<Self> {
        let count = size[0] as usize * size[1] as usize;
        (count > 0 && pixels.len() == count).then_some(Self { size, pixels })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Its sRGB codes, row by row.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// The part of it that covers a picture of width over height `aspect`, in shares of its sides: left, top, right, bottom.
    pub fn covering(&self, aspect: f32) -> [f32; 4] {
        let own = self.size[0] as f32 / self.size[1] as f32;
        let [width, height] = if own > aspect { [aspect / own, 1.0] } else { [1.0, own / aspect] };
        [0.5 - 0.5 * width, 0.5 - 0.5 * height, 0.5 + 0.5 * width, 0.5 + 0.5 * height]
    }

    /// Lays a displayed picture of `size` over it, by its alpha.
    pub fn behind(&self, shown: &mut [[u8; 4]], size: [u32; 2]) {
        let [width, height] = size.map(|side| side.max(1));
        let [left, top, right, bottom] = self.covering(width as f32 / height as f32);
        for (index, pixel) in (0_u32..).zip(shown) {
            let [x, y] = [index % width, index / width].map(|place| place as f32 + 0.5);
            let share = [x / width as f32, y / height as f32];
            let behind = self.at([left + share[0] * (right - left), top + share[1] * (bottom - top)]);
            let alpha = f32::from(pixel[3]) / 255.0;
            let over = |own: u8, behind: f32| (alpha * f32::from(own) + (1.0 - alpha) * behind + 0.5) as u8;
            *pixel = [over(pixel[0], behind[0]), over(pixel[1], behind[1]), over(pixel[2], behind[2]), 255];
        }
    }

    /// Its code at a place in shares of its sides, between pixels.
    fn at(&self, share: [f32; 2]) -> [f32; 3] {
        let place = [0, 1].map(|axis| (share[axis] * self.size[axis] as f32 - 0.5).max(0.0));
        let [column, row] = place.map(|place| place as u32);
        let part = [place[0] - column as f32, place[1] - row as f32];
        let pixel = |x: u32, y: u32| {
            let [x, y] = [x.min(self.size[0] - 1), y.min(self.size[1] - 1)];
            self.pixels[y as usize * self.size[0] as usize + x as usize].map(f32::from)
        };
        let mix = |a: [f32; 3], b: [f32; 3], t: f32| [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t);
        let row_at = |y: u32| mix(pixel(column, y), pixel(column + 1, y), part[0]);
        mix(row_at(row), row_at(row + 1), part[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red on the left, blue on the right.
    fn halves() -> Backplate {
        Backplate::new([4, 2], [[255, 0, 0], [255, 0, 0], [0, 0, 255], [0, 0, 255]].repeat(2)).unwrap()
    }

    #[test]
    fn the_scene_lies_over_it_by_its_coverage() {
        let mut shown = vec![[0, 255, 0, 255], [0, 255, 0, 0], [0, 0, 0, 128], [9, 9, 9, 0]];
        halves().behind(&mut shown, [4, 1]);
        assert_eq!(shown[0], [0, 255, 0, 255], "covered");
        assert_eq!(shown[1][..1], [255], "negative control: not covered");
        assert!((126..=128).contains(&shown[2][2]) && shown[2][0] == 0, "a shadow darkens it: {:?}", shown[2]);
        assert_eq!(shown[3], [0, 0, 255, 255]);
    }

    #[test]
    fn it_covers_a_picture_of_any_shape_from_its_middle() {
        assert_eq!(halves().covering(2.0), [0.0, 0.0, 1.0, 1.0]);
        assert_eq!(halves().covering(1.0), [0.25, 0.0, 0.75, 1.0]);
        assert_eq!(halves().covering(4.0), [0.0, 0.25, 1.0, 0.75]);
        let mut shown = vec![[0; 4]; 4];
        halves().behind(&mut shown, [2, 2]);
        assert!(shown[0][0] > 200 && shown[1][2] > 200, "{shown:?}");
    }

    #[test]
    fn an_empty_or_short_picture_is_none() {
        assert_eq!(Backplate::new([0, 3], Vec::new()), None);
        assert_eq!(Backplate::new([2, 2], vec![[0; 3]; 3]), None);
    }
}
