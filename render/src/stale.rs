//! Samples of a picture that an edit makes stale. A pixel keeps its samples of each part of the light until an edit changes that
//! part on a surface in the pixel.
//!
//! One invariant keeps this simple: a pixel has the samples 0 to n of a part. A pass over sample `i` adds to pixels that have
//! exactly `i` samples and skips those with more. So the picture after an edit equals one rendered from scratch, except for
//! rounding of added lights, which are summed separately.

/// The parts of a picture's light, each with its own sum in every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LightPart {
    /// Direct light of the environment, the background, and values of view modes without light.
    Environment,
    /// Bounced light.
    Bounce,
    /// Light of all kinds that mirrors show, and the map around it, see [`crate::shade::mirror`].
    Mirrors,
    /// Direct light of local lights.
    Direct,
    /// Direct light of local lights added after the pixels had all samples of [`Self::Direct`].
    Added,
}

impl LightPart {
    /// Number of parts.
    pub const COUNT: usize = 5;
    /// All parts.
    pub const ALL: [Self; Self::COUNT] = [Self::Environment, Self::Bounce, Self::Mirrors, Self::Direct, Self::Added];
}

/// Surfaces in a pixel or changed by an edit: sets of materials and of mesh patches, by index modulo 64. Overlapping sets may still
/// have nothing in common; disjoint sets certainly have nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// One bit for each material.
    pub materials: u64,
    /// One bit for each patch of vertices, see [`crate::Baked::patches`].
    pub patches: u64,
}

impl Marks {
    /// Materials alone, by index.
    pub fn of_materials(materials: impl IntoIterator<Item = usize>) -> Self {
        Self { materials: materials.into_iter().fold(0, |bits, material| bits | bit(material)), patches: 0 }
    }

    /// A material and three vertices' patches.
    pub(crate) fn of_surface(material: u32, vertices: [u32; 3], patches: Option<&[u8]>) -> Self {
        let patch = |vertex: u32| patches.map_or(0, |patches| bit(patches[vertex as usize].into()));
        let patches = vertices.into_iter().fold(0, |bits, vertex| bits | patch(vertex));
        Self { materials: bit(material as usize), patches }
    }

    /// The union of both.
    pub fn union(self, other: Self) -> Self {
        Self { materials: self.materials | other.materials, patches: self.patches | other.patches }
    }

    /// Whether both overlap.
    pub fn meets(self, other: Self) -> bool {
        self.materials & other.materials != 0 || self.patches & other.patches != 0
    }
}

fn bit(index: usize) -> u64 {
    1 << (index % 64)
}

/// Pixels that lose their samples of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pixels {
    /// None.
    #[default]
    Nothing,
    /// Pixels that show any of these.
    Showing(Marks),
    /// All.
    All,
}

impl Pixels {
    /// All if `changed`, else none.
    pub fn all_if(changed: bool) -> Self {
        if changed { Self::All } else { Self::Nothing }
    }

    /// Pixels in either.
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::All, _) | (_, Self::All) => Self::All,
            (Self::Nothing, pixels) | (pixels, Self::Nothing) => pixels,
            (Self::Showing(a), Self::Showing(b)) => Self::Showing(a.union(b)),
        }
    }

    /// Whether a pixel that shows `seen` is among them.
    pub fn contain(self, seen: Marks) -> bool {
        match self {
            Self::Nothing => false,
            Self::Showing(changed) => changed.meets(seen),
            Self::All => true,
        }
    }
}

/// Stale samples of a picture, by part of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stale {
    /// The environment's direct light, and the background.
    pub environment: Pixels,
    /// Bounced light.
    pub bounce: Pixels,
    /// Direct light of local lights.
    pub direct: Pixels,
    /// The local lights differ: the renderer compares them with the lights in its sums.
    pub lights: bool,
    /// Pixels show other surfaces, because opacities changed.
    pub surfaces: bool,
}

impl Stale {
    /// No sample is stale.
    pub const NOTHING: Self = Self {
        environment: Pixels::Nothing,
        bounce: Pixels::Nothing,
        direct: Pixels::Nothing,
        lights: false,
        surfaces: false,
    };
    /// All samples are stale, on unchanged surfaces.
    pub const ALL: Self =
        Self { environment: Pixels::All, bounce: Pixels::All, direct: Pixels::All, lights: true, surfaces: false };

    /// Whether anything must be rendered.
    pub fn any(self) -> bool {
        self != Self::NOTHING
    }

    /// The result of both edits.
    pub fn and(self, other: Self) -> Self {
        Self {
            environment: self.environment.and(other.environment),
            bounce: self.bounce.and(other.bounce),
            direct: self.direct.and(other.direct),
            lights: self.lights || other.lights,
            surfaces: self.surfaces || other.surfaces,
        }
    }

    /// The pixels that lose their samples of a part.
    pub(crate) fn pixels(&self, part: LightPart) -> Pixels {
        match part {
            LightPart::Environment => self.environment,
            LightPart::Bounce => self.bounce,
            // Anything may show in a mirror.
            LightPart::Mirrors => Pixels::all_if(self.any()),
            LightPart::Direct | LightPart::Added => self.direct,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_something_in_common_meets_and_sums_of_edits_contain_both() {
        let of = |material| Marks::of_materials([material]);
        assert!(of(3).meets(of(3)) && of(3).meets(of(67)) && !of(3).meets(of(4)));
        let patches: Vec<u8> = (0..64).collect();
        let seen = Marks::of_surface(3, [8, 9, 10], Some(&patches));
        assert!(seen.meets(Marks { materials: 0, patches: 1 << 9 }) && !seen.meets(Marks { materials: 0, patches: 8 }));
        assert_eq!(Marks::of_surface(3, [8, 9, 10], None), of(3));
        let both = Pixels::Showing(of(3)).and(Pixels::Showing(of(5)));
        assert!(both.contain(of(3)) && both.contain(of(5)) && !both.contain(of(4)));
        assert!(both.and(Pixels::All).contain(of(4)) && !Pixels::Nothing.contain(of(4)));
        assert_eq!(Pixels::Nothing.and(both), both);
    }
}
