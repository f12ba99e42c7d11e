//! The pictures that an OpenEXR file can show: colors, vectors and single channels of its parts and layers. A layer is the
//! channels that share the words before the last dot of their names (OpenEXR, *Technical Introduction*, "Layers").

use super::words;
use exr::meta::header::Header;
use std::collections::{HashMap, HashSet};

/// Last words of names of layers that hold the whole picture, the best first.
const WHOLE: [&str; 4] = ["beauty", "rgba", "rgb", "combined"];

/// Why a file without choices shows nothing.
pub const DEEP: &str = "deep pixels are not supported";

/// Most names in a message.
const LISTED: usize = 20;

/// Name of the colors without a layer, in a part without a name.
const UNNAMED: &str = "RGBA";

/// The channels of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Planes<T> {
    Rgb([T; 3]),
    /// Luminance Y and the chroma (R - Y) / Y and (B - Y) / Y.
    Chroma([T; 3]),
    /// Values that are no colors: one is gray, of two the third is 0.
    Values(Vec<T>),
}

impl<T> Planes<T> {
    pub fn channels(&self) -> &[T] {
        match self {
            Self::Rgb(channels) | Self::Chroma(channels) => channels,
            Self::Values(channels) => channels,
        }
    }

    pub fn try_map<U>(&self, mut channel: impl FnMut(&T) -> Option<U>) -> Option<Planes<U>> {
        Some(match self {
            Self::Rgb([a, b, c]) => Planes::Rgb([channel(a)?, channel(b)?, channel(c)?]),
            Self::Chroma([a, b, c]) => Planes::Chroma([channel(a)?, channel(b)?, channel(c)?]),
            Self::Values(channels) => Planes::Values(channels.iter().map(channel).collect::<Option<_>>()?),
        })
    }
}

/// A picture that a file can show.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    pub name: String,
    /// Index of its part.
    pub part: usize,
    /// Names of its channels.
    pub planes: Planes<String>,
    pub alpha: Option<String>,
}

impl Choice {
    /// The names of all its channels.
    pub fn channels(&self) -> impl Iterator<Item = &String> {
        self.planes.channels().iter().chain(&self.alpha)
    }
}

/// The channels of a part that share a prefix.
struct Layer {
    part: usize,
    /// The name of the part, if there are others.
    part_name: String,
    prefix: String,
    /// What its picture is called if it has no prefix.
    plain_name: Option<String>,
    /// Names of the channels without the prefix.
    channels: Vec<String>,
}

impl Layer {
    fn full(&self, channel: &str) -> String {
        if self.prefix.is_empty() { channel.to_owned() } else { format!("{}.{channel}", self.prefix) }
    }

    fn named(&self, name: &str) -> Option<String> {
        self.channels.iter().find(|channel| channel.eq_ignore_ascii_case(name)).map(|channel| self.full(channel))
    }

    fn three(&self, [a, b, c]: [&str; 3]) -> Option<[String; 3]> {
        Some([self.named(a)?, self.named(b)?, self.named(c)?])
    }

    /// Its colors.
    fn colors(&self) -> Option<Planes<String>> {
        let rgb = self.three(["R", "G", "B"]).map(Planes::Rgb);
        rgb.or_else(|| self.three(["Y", "RY", "BY"]).map(Planes::Chroma))
    }

    fn gray(&self) -> Option<Planes<String>> {
        self.named("Y").map(|y| Planes::Values(vec![y]))
    }

    /// What it shows if it is chosen.
    fn planes(&self) -> Option<Planes<String>> {
        let values =
            |names: &[&str]| names.iter().map(|name| self.named(name)).collect::<Option<Vec<_>>>().map(Planes::Values);
        let vectors = || [&["X", "Y", "Z"][..], &["U", "V", "W"], &["U", "V"]].into_iter().find_map(values);
        let mut others = self.channels.iter().filter(|channel| !channel.eq_ignore_ascii_case("A"));
        // Alpha alone is a coverage or a mask.
        let only = match (others.next(), others.next()) {
            (None, _) => self.channels.first(),
            (only, None) => only,
            _ => None,
        };
        let only = || only.map(|only| Planes::Values(vec![self.full(only)]));
        self.colors().or_else(vectors).or_else(|| self.gray()).or_else(only)
    }

    /// Its picture, and each channel that is not in it.
    fn choices(&self) -> Vec<Choice> {
        let alpha = |planes: &Planes<String>| self.named("A").filter(|alpha| !planes.channels().contains(alpha));
        let picture = self.planes().map(|planes| self.choice(self.name(&planes), planes.clone(), alpha(&planes)));
        let is_seen = |name: &String| picture.iter().flat_map(Choice::channels).any(|seen| seen == name);
        let rest = self.singles().into_iter().filter(|single| !single.channels().any(is_seen)).collect::<Vec<_>>();
        picture.into_iter().chain(rest).collect()
    }

    /// Each channel.
    fn singles(&self) -> Vec<Choice> {
        let single = |channel: &String| {
            let name = joined([&self.part_name, &self.prefix, channel]);
            self.choice(name, Planes::Values(vec![self.full(channel)]), None)
        };
        self.channels.iter().map(single).collect()
    }

    fn choice(&self, name: String, planes: Planes<String>, alpha: Option<String>) -> Choice {
        Choice { name, part: self.part, planes, alpha }
    }

    fn name(&self, planes: &Planes<String>) -> String {
        match (&self.plain_name, planes) {
            _ if !self.prefix.is_empty() => joined([&self.part_name, &self.prefix, ""]),
            (Some(name), _) => name.clone(),
            (None, Planes::Values(channels)) => channels.concat(),
            (None, _) => UNNAMED.into(),
        }
    }
}

/// Parts of a name. A part may repeat its name in its channels, as Nuke writes it.
fn joined([part, prefix, channel]: [&str; 3]) -> String {
    let is_repeated = prefix.strip_prefix(part).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    let part = if is_repeated { "" } else { part };
    [part, prefix, channel].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(".")
}

/// The layers of all parts with flat pixels.
fn layers(headers: &[Header]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    let mut known: HashMap<(usize, String), usize> = HashMap::new();
    for (part, header) in headers.iter().enumerate().filter(|(_, header)| !header.deep) {
        let plain_name = header.own_attributes.layer_name.as_ref().map(words).filter(|name| !name.is_empty());
        let part_name = plain_name.clone().filter(|_| headers.len() > 1).unwrap_or_default();
        for channel in &header.channels.list {
            let full = words(&channel.name);
            let (prefix, channel) = full.rsplit_once('.').unwrap_or(("", &full));
            let index = *known.entry((part, prefix.into())).or_insert_with(|| {
                layers.push(Layer {
                    part,
                    part_name: part_name.clone(),
                    prefix: prefix.into(),
                    plain_name: plain_name.clone(),
                    channels: Vec::new(),
                });
                layers.len() - 1
            });
            layers[index].channels.push(channel.into());
        }
    }
    layers
}

/// The layer of colors that shows the whole picture: the unnamed one, else one with a usual name, else the first. `None` for a
/// file without colors.
pub fn whole(headers: &[Header]) -> Option<Choice> {
    let layers = layers(headers);
    let mut best: Option<(usize, Choice)> = None;
    for layer in &layers {
        let rank = 2 * rank(layer);
        let (rank, planes) = match (layer.colors(), layer.gray()) {
            (Some(colors @ Planes::Rgb(_)), _) => (rank, colors),
            // A layer of one channel may hold depth or anything else, unless its name says otherwise: the last choice.
            (chroma, Some(gray)) if rank <= 2 * WHOLE.len() => (rank + 1, chroma.unwrap_or(gray)),
            (chroma, Some(gray)) if layer.prefix.is_empty() => (usize::MAX, chroma.unwrap_or(gray)),
            _ => continue,
        };
        if best.as_ref().is_none_or(|(other, _)| rank < *other) {
            // By default the Y of vectors is gray.
            let is_picture = layer.planes().as_ref() == Some(&planes);
            let name = if is_picture { layer.name(&planes) } else { joined([&layer.part_name, &layer.prefix, "Y"]) };
            best = Some((rank, layer.choice(name, planes, layer.named("A"))));
        }
    }
    best.map(|(_, choice)| choice)
}

/// Names of choices for a message.
pub fn listed(names: &[String]) -> String {
    let shown = names[..names.len().min(LISTED)].join(", ");
    if names.len() > LISTED { format!("{shown} and {} more", names.len() - LISTED) } else { shown }
}

/// Place of a layer in the order of preference.
fn rank(layer: &Layer) -> usize {
    let is_plain = layer.prefix.is_empty();
    let name = if is_plain { &layer.part_name } else { &layer.prefix };
    let name = name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    match WHOLE.iter().position(|whole| *whole == name) {
        _ if name.is_empty() => 0,
        Some(place) => 1 + place,
        None if is_plain => 1 + WHOLE.len(),
        None if name == "diffuse" => 2 + WHOLE.len(),
        None => 3 + WHOLE.len(),
    }
}

/// All choices, each name once, and first that of the whole picture if there is one.
pub fn all(headers: &[Header]) -> Vec<Choice> {
    let mut names = HashSet::new();
    let layers = layers(headers);
    let choices = whole(headers).into_iter().chain(layers.iter().flat_map(Layer::choices));
    choices.filter(|choice| names.insert(plain(&choice.name))).collect()
}

/// The choice of a name in any case, where `-` matches `_`. The last words of a long name suffice, `beauty` also means the
/// colors without a name, and any single channel may be named.
///
/// # Errors
/// An unknown name; the names that are there, in words.
pub fn find(headers: &[Header], name: &str) -> Result<Choice, String> {
    let choices = all(headers);
    let wanted = plain(name);
    let suffix = format!(".{wanted}");
    let is_exact = |choice: &&Choice| plain(&choice.name) == wanted;
    let is_unnamed = |choice: &&Choice| wanted == WHOLE[0] && choice.name == UNNAMED;
    let is_end = |choice: &&Choice| !wanted.is_empty() && plain(&choice.name).ends_with(&suffix);
    let singles: Vec<Choice> = layers(headers).iter().flat_map(Layer::singles).collect();
    let found = choices.iter().find(is_exact).or_else(|| choices.iter().find(is_unnamed));
    let found = found.or_else(|| singles.iter().find(is_exact)).or_else(|| choices.iter().find(is_end));
    found.or_else(|| singles.iter().find(is_end)).cloned().ok_or_else(|| {
        let names: Vec<String> = choices.into_iter().map(|choice| choice.name).collect();
        if names.is_empty() { DEEP.into() } else { format!("the file has {}", listed(&names)) }
    })
}

fn plain(name: &str) -> String {
    name.to_ascii_lowercase().replace('-', "_")
}
