//! Library enums as options: names match those in files, and each has a line of `--help`.

use crate::values::{choice, choice_of};
use clap::builder::TypedValueParser;
use lapidary_core::{ground::Ground, light_tree::TreeKind, texture::ColorSpace};
use lapidary_interchange::materialx::Surface;
use lapidary_precompute::Preset;
use lapidary_render::{BrdfSampling, SamplePositions, Solution, ToneMap, ViewMode, compare::map::ErrorMap};
use serde::Deserialize;

/// Clustering metric of the light tree.
pub fn tree_kind() -> impl TypedValueParser<Value = TreeKind> {
    choice(&[
        ("geometric", "Direction alone (Eq. 10 of the paper)"),
        ("data-driven", "Pilot visibility alone (Eq. 11)"),
        ("mixed", "Both, weighted by --beta (Eq. 12)"),
    ])
}

/// Surfaces of MaterialX documents.
pub fn surface() -> impl TypedValueParser<Value = Surface> {
    choice(&[
        ("open-pbr", "open_pbr_surface: all parameters of the openpbr model"),
        ("standard-surface", "standard_surface: read by most programs"),
        ("gltf-pbr", "gltf_pbr: what glTF has"),
    ])
}

/// Starting settings of a bake.
pub fn preset() -> impl TypedValueParser<Value = Preset> {
    choice(&[
        (
            "draft",
            "8,192 lights and surface sources, up to 30,000 vertices, a meshless basis of 4 levels; takes seconds for the \
             environment alone",
        ),
        ("normal", "32,768 lights and surface sources, sigma 2, up to 100,000 vertices, a meshless basis of 6 levels"),
        ("high", "As normal, with sigma 1.5 for the environment and up to 300,000 vertices"),
    ])
}

/// Ways of sampling the BRDF under an illumination cut.
const STORED_SAMPLINGS: [(&str, &str); 2] = [
    ("refine", "Merge the stored cuts and the illumination cut; split nodes that are too wide for the lobe"),
    ("once", "Merge the same cuts, and sample the BRDF once per node, as in the paper"),
];

/// How the BRDF is sampled.
pub fn brdf_sampling() -> impl TypedValueParser<Value = BrdfSampling> {
    const ALL: [(&str, &str); 3] = [
        ("lit", "Merge cuts that know the light; split nodes that are too wide for the lobe, during the merge"),
        STORED_SAMPLINGS[0],
        STORED_SAMPLINGS[1],
    ];
    choice(&ALL)
}

/// How the BRDF is sampled under an illumination cut.
pub fn stored_sampling() -> impl TypedValueParser<Value = BrdfSampling> {
    choice(&STORED_SAMPLINGS)
}

/// Quantity shown in the pixels.
pub fn view_mode() -> impl TypedValueParser<Value = ViewMode> {
    choice(&[
        ("shaded", "The lit picture"),
        ("normals", "Shading normals, -1 to 1 as 0 to 1"),
        ("albedo", "Base color after its map"),
        ("roughness", "Roughness after its map"),
        ("visibility-cut", "Nodes of the visibility cuts"),
        ("merged-cut", "Nodes of the merged cut"),
        ("brdf-evaluations", "BRDF evaluations"),
        ("basis-level", "Contribution of one level of the meshless basis to bounced light: red adds, blue subtracts"),
        ("basis-function", "One function of the meshless basis, red where it is 1"),
        ("basis-coefficients", "Functions of the meshless basis with nonzero coefficients, by level"),
        ("gloss", "What bounced light gains from sources that send by direction: red adds, blue subtracts"),
    ])
}

/// Tone curve of png files.
pub fn tone_map() -> impl TypedValueParser<Value = ToneMap> {
    choice_of(ToneMap::ALL.map(|tone_map| (tone_map.curve().key, tone_map.curve().method)))
}

/// Color spaces of picture files.
pub fn color_space() -> impl TypedValueParser<Value = ColorSpace> {
    choice(&[
        ("srgb", "As the file says: its primaries, else Rec. 709; 8 and 16 bits are sRGB encoded"),
        ("linear", "Linear Rec. 709, whatever the file says"),
        ("acescg", "Linear, with the primaries AP1 of ACES"),
        ("aces2065-1", "Linear, with the primaries AP0 of ACES"),
        ("lin-rec2020", "Linear, with the primaries of Rec. 2020"),
        ("lin-p3", "Linear, with the primaries P3 and the white D65"),
    ])
}

/// Whether small bright parts of an environment are suns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SunOption {
    /// Small bright parts are suns.
    #[default]
    On,
    /// All light is left to the light samples.
    Off,
}

/// Whether small bright parts of an environment are suns.
pub fn sun() -> impl TypedValueParser<Value = SunOption> {
    choice(&[
        (
            "on",
            "Parts of the map smaller than 8 degrees and 30 times as bright as its mean shine as directional lights",
        ),
        ("off", "Light samples represent the whole map"),
    ])
}

/// How the ground of a scene is shown.
pub fn ground() -> impl TypedValueParser<Value = Ground> {
    choice(&[
        ("off", "None"),
        ("on", "A surface with a material of its own"),
        ("shadow", "Its shadows and the light that it catches, over the background"),
    ])
}

/// How bounced light is computed.
pub fn solution() -> impl TypedValueParser<Value = Solution> {
    choice_of(Solution::ALL.iter().map(|solution| (solution.key(), solution.method())))
}

/// Which error a map shows.
pub fn error_map() -> impl TypedValueParser<Value = ErrorMap> {
    choice(&[
        ("rel", "Difference relative to the reference"),
        ("abs", "Difference in scene-linear units"),
        ("signed", "Difference of luminance: orange where the test picture is too bright, blue where it is too dark"),
        ("flip", "Difference as seen, 0 to 1"),
    ])
}

/// Start positions of light paths in the pixels.
pub fn sample_positions() -> impl TypedValueParser<Value = SamplePositions> {
    choice(&[
        (
            "shared",
            "The --aa sample positions of `render`, the same in all pixels: pictures of both differ by light alone",
        ),
        ("shifted", "Random positions for each pixel and --seed: the mean over whole pixels, as in other renderers"),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Arg, Command};
    use serde::{
        Deserialize,
        de::{
            Deserializer, Error as _, IntoDeserializer, Visitor,
            value::{Error, StrDeserializer},
        },
    };
    use std::fmt::Debug;

    /// Reports an enum's variant names through its error.
    struct Variants;

    impl<'de> Deserializer<'de> for Variants {
        type Error = Error;

        fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
            panic!("not an enum")
        }

        fn deserialize_enum<V: Visitor<'de>>(
            self,
            _: &'static str,
            variants: &'static [&'static str],
            _: V,
        ) -> Result<V::Value, Error> {
            Err(Error::custom(variants.join(" ")))
        }

        serde::forward_to_deserialize_any! {
            bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
            seq tuple tuple_struct map struct identifier ignored_any
        }
    }

    fn variants<T: for<'de> Deserialize<'de> + Debug>() -> Vec<T> {
        let names = T::deserialize(Variants).unwrap_err().to_string();
        let variant = |name: &str| {
            let name: StrDeserializer<Error> = name.into_deserializer();
            T::deserialize(name).unwrap()
        };
        names.split(' ').map(variant).collect()
    }

    fn command(parser: impl TypedValueParser) -> Command {
        Command::new("test").arg(Arg::new("choice").value_parser(clap::builder::ValueParser::new(parser)))
    }

    /// Names that do not parse, or variants without a name.
    fn gaps<T>(parser: impl TypedValueParser<Value = T>) -> Vec<String>
    where
        T: for<'de> Deserialize<'de> + Clone + Debug + PartialEq + Send + Sync + 'static,
    {
        let names: Vec<_> = parser.possible_values().unwrap().collect();
        assert!(names.iter().all(|name| name.get_help().is_some()), "{names:?}");
        let command = command(parser);
        let value = |name: &str| {
            let mut matches = command.clone().try_get_matches_from(["test", name]).ok()?;
            matches.remove_one::<T>("choice")
        };
        let unread = names.iter().filter(|name| value(name.get_name()).is_none());
        let mut gaps: Vec<_> = unread.map(|name| name.get_name().to_owned()).collect();
        let listed: Vec<T> = names.iter().filter_map(|name| value(name.get_name())).collect();
        gaps.extend(variants::<T>().iter().filter(|variant| !listed.contains(variant)).map(|v| format!("{v:?}")));
        gaps
    }

    #[test]
    fn every_choice_listed_parses_and_every_variant_is_listed() {
        let none = Vec::<String>::new();
        assert_eq!(gaps(tree_kind()), none);
        assert_eq!(gaps(preset()), none);
        assert_eq!(gaps(ground()), none);
        assert_eq!(gaps(brdf_sampling()), none);
        assert_eq!(gaps(tone_map()), none);
        assert_eq!(gaps(solution()), none);
        assert_eq!(gaps(error_map()), none);
        assert_eq!(gaps(sample_positions()), none);
        let short = choice::<Preset>(&[("draft", "a"), ("normal", "b"), ("hgih", "c")]);
        assert_eq!(gaps(short), ["hgih", "High"], "negative control");
    }

    #[test]
    fn a_wrong_choice_is_told_the_right_ones() {
        let error = command(brdf_sampling()).try_get_matches_from(["test", "twice"]).unwrap_err().to_string();
        assert!(error.contains("possible values: lit, refine, once"), "{error}");
    }
}
