//! The nodes behind an input: constants, and pictures behind supported nodes.

mod coordinates;
mod relief;
mod units;

pub use relief::Relief;

use super::{color_spaces, places::Places};
use crate::image::split;
use glam::{Affine2, Vec2, Vec3};
use lapidary_core::texture::{Channel, ColorSpace, UvSet, Wrap};
use roxmltree::{Document, Node, NodeId};
use std::{
    cell::{Cell, RefCell},
    collections::{BTreeSet, HashMap},
    rc::Rc,
};

/// Largest number of nodes between an input and its picture.
const MOST_STEPS: u32 = 256;

/// An element of a document.
type XmlNode<'a> = Node<'a, 'a>;

/// Why an input is not read.
#[derive(Debug, PartialEq)]
pub enum Unread {
    /// It is valid, but not supported.
    Beyond(String),
    /// It is invalid.
    Wrong(String),
}

type Result<T> = std::result::Result<T, Unread>;

/// The source of an input.
#[derive(Clone, Debug)]
pub enum Found {
    /// Numbers, 1 to 4.
    Constant(Vec<f32>),
    /// A picture.
    Picture(Box<Picture>),
}

/// A picture and its use.
#[derive(Clone, Debug)]
pub struct Picture {
    /// File name as in the document, with its prefix.
    pub file: String,
    /// Color space of its texels.
    pub color_space: ColorSpace,
    /// The component in use, if only one is.
    pub channel: Option<Channel>,
    /// Whether its texels have three components.
    pub is_color: bool,
    /// Transform of coordinates whose v begins at the bottom.
    pub transform: Affine2,
    /// Along u and v.
    pub wrap: [Wrap; 2],
    /// The texture coordinates of the surface.
    pub uv_set: UvSet,
    /// Factor of the texels.
    pub factor: Vec3,
    /// Added to the texels after the factor.
    pub added: Vec3,
}

/// Finds nodes of a document by name, and follows connections.
pub struct Graph<'a> {
    document: &'a Document<'a>,
    places: Rc<Places>,
    names: HashMap<(NodeId, &'a str), XmlNode<'a>>,
    steps: Cell<u32>,
    remarks: RefCell<BTreeSet<String>>,
}

impl<'a> Graph<'a> {
    /// The graph of a document whose lines come from these places.
    pub fn new(document: &'a Document<'a>, places: Rc<Places>) -> Self {
        let named = document.descendants().filter_map(|node| {
            let (parent, name) = (node.parent_element()?, node.attribute("name")?);
            Some(((parent.id(), name), node))
        });
        // The first of several nodes with one name counts.
        let mut names = HashMap::new();
        named.for_each(|(key, node)| _ = names.entry(key).or_insert(node));
        Self { document, places, names, steps: Cell::new(0), remarks: RefCell::default() }
    }

    /// Where an element begins, in words.
    pub fn place(&self, node: XmlNode) -> String {
        self.places.words(self.document.text_pos_at(node.range().start).row)
    }

    /// An element within another by its name.
    pub fn child(&self, of: XmlNode, name: &str) -> Option<XmlNode<'a>> {
        self.names.get(&(of.id(), name)).copied()
    }

    /// Remarks on approximated inputs, each once.
    pub fn take_remarks(&self) -> Vec<String> {
        self.remarks.take().into_iter().collect()
    }

    fn remark(&self, node: XmlNode, what: &str) {
        self.remarks.borrow_mut().insert(format!("{}: {what}", self.place(node)));
    }

    fn beyond<T>(&self, node: XmlNode, what: &str) -> Result<T> {
        Err(Unread::Beyond(format!("{}: {what}", self.place(node))))
    }

    fn step(&self, at: XmlNode) -> Result<()> {
        self.steps.set(self.steps.get() + 1);
        if self.steps.get() <= MOST_STEPS {
            return Ok(());
        }
        self.beyond(at, &format!("its nodes lead in a circle, or there are more than {MOST_STEPS} of them"))
    }

    /// The value of an input of a surface.
    pub fn input(&self, input: XmlNode<'a>) -> Result<Found> {
        self.steps.set(0);
        self.follow(input)
    }

    /// The node that an input or output is connected to, and the name of its output; `None` for a value.
    pub fn target(&self, end: XmlNode<'a>) -> Result<Option<(XmlNode<'a>, Option<&'a str>)>> {
        self.step(end)?;
        let output = end.attribute("output");
        if let Some(name) = end.attribute("interfacename") {
            let graph = end.ancestors().find(|node| node.has_tag_name("nodegraph"));
            let Some(input) = graph.and_then(|graph| self.child(graph, name)) else {
                return self.beyond(end, &format!("there is no input \"{name}\" around it"));
            };
            return self.target(input);
        }
        let Some(name) = end.attribute("nodegraph").or(end.attribute("nodename")) else { return Ok(None) };
        // An output is among the nodes; an input is inside one of them.
        let holder = if end.has_tag_name("output") { Some(end) } else { end.parent_element() };
        let scope = holder.and_then(|holder| holder.parent_element()).unwrap_or(self.document.root_element());
        let found = self.child(scope, name).or_else(|| self.child(self.document.root_element(), name));
        let Some(node) = found else { return self.beyond(end, &format!("there is no node \"{name}\"")) };
        if !node.has_tag_name("nodegraph") {
            return Ok(Some((node, output)));
        }
        let outputs = || node.children().filter(|child| child.has_tag_name("output"));
        let inner = match output {
            Some(output) => self.child(node, output),
            None => outputs().next(),
        };
        let Some(inner) = inner else { return self.beyond(end, &format!("\"{name}\" has no such output")) };
        match self.target(inner)? {
            Some(target) => Ok(Some(target)),
            None => self.beyond(inner, "the output is connected to nothing"),
        }
    }

    /// The element that determines an input: the input itself, or the input of the surrounding graph.
    fn telling(&self, end: XmlNode<'a>) -> Option<XmlNode<'a>> {
        let mut at = end;
        for _ in 0..MOST_STEPS {
            let Some(name) = at.attribute("interfacename") else { return Some(at) };
            at = at.ancestors().find(|node| node.has_tag_name("nodegraph")).and_then(|g| self.child(g, name))?;
        }
        None
    }

    /// The text of an input of a node, which the surrounding graph may give.
    fn word(&self, node: XmlNode<'a>, input: &str) -> Option<&'a str> {
        self.telling(self.child(node, input)?)?.attribute("value")
    }

    fn follow(&self, input: XmlNode<'a>) -> Result<Found> {
        let found = match self.target(input)? {
            Some((node, output)) => self.node(node, output)?,
            None => Found::Constant(self.numbers(input)?),
        };
        // Documents before 1.39 select components at the input.
        match input.attribute("channels") {
            Some(channels) => self.swizzled(input, found, channels),
            None => Ok(found),
        }
    }

    /// The numbers of a value.
    fn numbers(&self, input: XmlNode<'a>) -> Result<Vec<f32>> {
        let Some(told) = self.telling(input).filter(|told| told.attribute("value").is_some()) else {
            return self.beyond(input, "the input has no value");
        };
        let text = told.attribute("value").unwrap_or_default();
        let wrong = || {
            let name = input.attribute("name").unwrap_or_default();
            Unread::Wrong(format!(
                "{}: the value \"{text}\" of \"{name}\" is neither a number nor 2 to 4 of them",
                self.place(told)
            ))
        };
        let number = |word: &str| match word.trim() {
            "true" => Some(1.0),
            "false" => Some(0.0),
            word => word.parse::<f32>().ok(),
        };
        let numbers: Option<Vec<f32>> = text.split(',').take(5).map(number).collect();
        let mut numbers = numbers.filter(|numbers| numbers.len() <= 4).ok_or_else(wrong)?;
        let factor = self.unit_factor(told);
        numbers.iter_mut().for_each(|x| *x *= factor);
        if told.attribute("type").is_some_and(|kind| kind.starts_with("color"))
            && let [r, g, b, ..] = &mut numbers[..]
        {
            [*r, *g, *b] = color_spaces::in_rec_709(self.color_space(told), [*r, *g, *b]);
        }
        Ok(numbers)
    }

    fn node(&self, node: XmlNode<'a>, output: Option<&str>) -> Result<Found> {
        self.step(node)?;
        match node.tag_name().name() {
            "image" | "tiledimage" | "gltf_image" | "gltf_colorimage" => self.image(node, output),
            "constant" => self.follow(self.needed(node, "value")?),
            "dot" | "convert" => self.follow(self.needed(node, "in")?),
            "extract" => {
                let found = self.follow(self.needed(node, "in")?)?;
                let index = self.constant(node, "index", &[0.0])?[0];
                self.extracted(node, found, index as usize)
            }
            "swizzle" => {
                let found = self.follow(self.needed(node, "in")?)?;
                self.swizzled(node, found, self.word(node, "channels").unwrap_or("x"))
            }
            "separate2" | "separate3" | "separate4" => {
                let found = self.follow(self.needed(node, "in")?)?;
                self.swizzled(node, found, output.unwrap_or_default().trim_start_matches("out"))
            }
            "multiply" => self.combined(node, true),
            "add" => self.combined(node, false),
            other => self.beyond(node, &format!("the node \"{other}\" is not read")),
        }
    }

    fn needed(&self, node: XmlNode<'a>, name: &str) -> Result<XmlNode<'a>> {
        match self.child(node, name) {
            Some(input) => Ok(input),
            None => self.beyond(node, &format!("the node has no input \"{name}\"")),
        }
    }

    /// An input of a node that must be a constant.
    pub fn constant(&self, node: XmlNode<'a>, name: &str, default: &[f32]) -> Result<Vec<f32>> {
        let Some(input) = self.child(node, name) else { return Ok(default.into()) };
        match self.follow(input)? {
            Found::Constant(numbers) if numbers.len() >= default.len() => Ok(numbers),
            Found::Constant(_) => self.beyond(input, &format!("\"{name}\" has too few numbers")),
            Found::Picture(_) => self.beyond(input, &format!("\"{name}\" is not the same everywhere")),
        }
    }

    fn pair(&self, node: XmlNode<'a>, name: &str, default: Vec2) -> Result<Vec2> {
        let numbers = self.constant(node, name, &default.to_array())?;
        Ok(Vec2::new(numbers[0], numbers[1]))
    }

    /// The product or the sum of two inputs, one of which is a constant.
    fn combined(&self, node: XmlNode<'a>, multiplies: bool) -> Result<Found> {
        let [a, b] = ["in1", "in2"].map(|name| self.needed(node, name).and_then(|input| self.follow(input)));
        let apply = |a: Vec3, b: Vec3| if multiplies { a * b } else { a + b };
        match (a?, b?) {
            (Found::Constant(a), Found::Constant(b)) => {
                let count = a.len().max(b.len()).min(3);
                Ok(Found::Constant(apply(triple(&a), triple(&b)).to_array()[..count].into()))
            }
            (Found::Picture(mut picture), Found::Constant(numbers))
            | (Found::Constant(numbers), Found::Picture(mut picture)) => {
                let number = triple(&numbers);
                if multiplies {
                    picture.factor *= number;
                }
                picture.added = apply(picture.added, number);
                Ok(Found::Picture(picture))
            }
            _ => self.beyond(node, "two pictures are combined, which is not read"),
        }
    }

    fn extracted(&self, node: XmlNode<'a>, found: Found, index: usize) -> Result<Found> {
        let channel = [Channel::R, Channel::G, Channel::B, Channel::A].get(index);
        match (found, channel) {
            (Found::Constant(numbers), Some(_)) if numbers.len() == 1 => Ok(Found::Constant(numbers)),
            (Found::Constant(numbers), Some(_)) if index < numbers.len() => Ok(Found::Constant(vec![numbers[index]])),
            (Found::Picture(picture), Some(&channel)) => {
                // A component of a component is the same one.
                let channel = picture.channel.unwrap_or(channel);
                let of = |v: Vec3, other: f32| Vec3::splat(if index < 3 { v[index] } else { other });
                let (factor, added) = (of(picture.factor, 1.0), of(picture.added, 0.0));
                Ok(Found::Picture(Box::new(Picture {
                    channel: Some(channel),
                    is_color: false,
                    factor,
                    added,
                    ..*picture
                })))
            }
            _ => self.beyond(node, "there is no such component"),
        }
    }

    fn swizzled(&self, node: XmlNode<'a>, found: Found, channels: &str) -> Result<Found> {
        let index = |letter: char| "xyzw".find(letter).or_else(|| "rgba".find(letter));
        let indices: Option<Vec<usize>> = channels.chars().take(5).map(index).collect();
        match indices.as_deref() {
            Some([index]) => self.extracted(node, found, *index),
            Some([0, 1] | [0, 1, 2] | [0, 1, 2, 3]) => Ok(found),
            Some([a, b, c]) if a == b && b == c => self.extracted(node, found, *a),
            _ => self.beyond(node, &format!("the components \"{channels}\" are in another order, which is not read")),
        }
    }

    /// The color space of an element, given there or on an ancestor.
    fn color_space(&self, element: XmlNode) -> ColorSpace {
        let name = space_name(element);
        color_spaces::named(name).unwrap_or_else(|| {
            let is_linear = name.starts_with("lin_");
            let taken = if is_linear { "linear Rec. 709" } else { "sRGB" };
            self.remark(element, &format!("the color space \"{name}\" is taken for {taken}"));
            if is_linear { ColorSpace::Linear } else { ColorSpace::Srgb }
        })
    }

    fn image(&self, node: XmlNode<'a>, output: Option<&str>) -> Result<Found> {
        let input = self.needed(node, "file")?;
        let told = self.telling(input).filter(|told| !told.attribute("value").unwrap_or_default().trim().is_empty());
        let Some(told) = told else { return self.beyond(input, "no picture is named") };
        let file = told.attribute("value").unwrap_or_default().trim();
        if file.contains('<') || file.contains('{') {
            let what = if ["<UDIM>", "<UVTILE>"].iter().any(|token| file.contains(token)) {
                "is one of several tiles, which are not read; join them to one picture"
            } else {
                "stands for several, which are not read; name one of them"
            };
            return self.beyond(told, &format!("the picture \"{file}\" {what}"));
        }
        // The innermost prefix counts.
        let prefix = told.ancestors().find_map(|around| around.attribute("fileprefix")).unwrap_or_default();
        let layer = self.layer(node, file);
        let kind =
            if node.has_tag_name("gltf_colorimage") { "color4" } else { node.attribute("type").unwrap_or("color3") };
        // Only colors are converted from a space.
        let color_space = if kind.starts_with("color") {
            color_spaces::of_picture(self.color_space(told), space_name(told), file)
        } else {
            ColorSpace::Linear
        };
        let picture = Picture {
            file: format!("{prefix}{file}{layer}"),
            color_space,
            channel: None,
            is_color: kind != "float",
            transform: self.transform(node)?,
            wrap: ["uaddressmode", "vaddressmode"].map(|name| self.wrap(node, name)),
            uv_set: self.uv_set(node)?,
            factor: self.factor_of_gltf(node)?,
            added: Vec3::ZERO,
        };
        let found = Found::Picture(Box::new(picture));
        if output == Some("outa") { self.extracted(node, found, 3) } else { Ok(found) }
    }

    /// What the name of a picture's layer adds to that of its file.
    fn layer(&self, node: XmlNode<'a>, file: &str) -> String {
        let layer = self.word(node, "layer").filter(|layer| !layer.is_empty()).map(|layer| format!("#{layer}"));
        let layer = layer.unwrap_or_default();
        if layer.is_empty() || split(&format!("{file}{layer}")).is_some() {
            return layer;
        }
        self.remark(node, "the layer of the picture is not chosen by its name, as only exr files have layers");
        String::new()
    }

    /// What is shown beyond the edges of a picture.
    fn wrap(&self, node: XmlNode<'a>, input: &str) -> Wrap {
        match self.word(node, input) {
            Some("clamp") => Wrap::Clamp,
            Some("mirror") => Wrap::Mirror,
            Some("constant") => {
                self.remark(node, "the picture repeats in place of one color beyond its edges");
                Wrap::Repeat
            }
            _ => Wrap::Repeat,
        }
    }

    /// `gltf_image` and `gltf_colorimage` also multiply by their own factor.
    fn factor_of_gltf(&self, node: XmlNode<'a>) -> Result<Vec3> {
        let name = match node.tag_name().name() {
            "gltf_image" => "factor",
            "gltf_colorimage" => "color",
            _ => return Ok(Vec3::ONE),
        };
        let numbers = self.constant(node, name, &[1.0])?;
        Ok(triple(&numbers))
    }
}

/// The name of the color space of an element, given there or on an ancestor.
fn space_name<'a>(element: XmlNode<'a>) -> &'a str {
    element.ancestors().find_map(|node| node.attribute("colorspace")).unwrap_or_default()
}

/// Whether a picture of this name has float texels, which no transfer function encodes.
pub fn holds_floats(file: &str) -> bool {
    let (file, _) = split(file).unwrap_or((file, ""));
    let extension = file.rsplit('.').next().unwrap_or_default();
    ["exr", "hdr"].iter().any(|float| extension.eq_ignore_ascii_case(float))
}

/// The first three of some numbers, or one for all.
fn triple(numbers: &[f32]) -> Vec3 {
    match numbers {
        [x] => Vec3::splat(*x),
        [x, y] => Vec3::new(*x, *y, 0.0),
        [x, y, z, ..] => Vec3::new(*x, *y, *z),
        [] => Vec3::ZERO,
    }
}
