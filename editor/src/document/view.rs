//! The settings of the view.

use glam::Vec3;
use lapidary_core::{
    brdf::{self, Parameters},
    cut::lit::DEFAULT_TAU,
    material::{BrdfModel, Material},
};
use lapidary_render::{Background, BasisView, BrdfSampling, Post, ViewMode};
use lapidary_studies::ladder::Cuts;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Width over height of delivered pictures, at least and at most.
pub const ASPECTS: [f32; 2] = [0.1, 10.0];

/// The background where there is no surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BackgroundKind {
    /// The environment.
    #[default]
    Environment,
    /// The environment out of focus.
    Blurred,
    /// One color.
    Flat,
    /// Transparent, shown as a checkerboard.
    Transparent,
    /// A picture, on which a ground catches shadows.
    Picture,
}

/// How the picture is made and shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewSettings {
    /// Exposure and tone curve.
    pub post: Post,
    /// The background where there is no surface.
    pub background: BackgroundKind,
    /// Blur of a blurred background, as a standard deviation in degrees.
    pub blur_degrees: f32,
    /// The file of a picture as background.
    pub backplate: Option<PathBuf>,
    /// Scene-linear color of a flat background.
    pub background_color: Vec3,
    /// Most nodes of the illumination cut, 1 to 32,768.
    pub illum_cut: u32,
    /// Largest share of a vertex's light that a node of its lit cut displaces, 0 to 1.
    pub tau: f32,
    /// How the BRDF is sampled on merged nodes.
    pub sampling: BrdfSampling,
    /// Whether sharp reflections show the scene.
    pub mirrors: bool,
    /// Jittered frames that are averaged at rest, 1 to 256.
    pub aa: u32,
    /// The quantity that the pixels show.
    pub mode: ViewMode,
    /// The part of the meshless basis that its views show.
    pub basis: BasisView,
    /// Materials to show.
    pub materials: ShownMaterials,
    /// Draws the triangles' edges over the picture.
    pub wireframe: bool,
    /// Width over height of the delivered pictures, which the viewport takes on; `None` for that of the window.
    pub aspect: Option<f32>,
    /// Draws lines around the parts of the picture that are safe for action and titles.
    pub safe_frames: bool,
    /// Milliseconds per picture while something moves; resolution adapts to it.
    pub frame_budget_ms: f32,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            post: Post::default(),
            background: BackgroundKind::default(),
            blur_degrees: 8.0,
            backplate: None,
            background_color: Vec3::splat(0.05),
            illum_cut: 256,
            tau: DEFAULT_TAU,
            sampling: BrdfSampling::default(),
            mirrors: true,
            aa: 16,
            mode: ViewMode::default(),
            basis: BasisView::default(),
            materials: ShownMaterials::default(),
            wireframe: false,
            aspect: None,
            safe_frames: false,
            frame_budget_ms: 100.0,
        }
    }
}

/// Materials that a picture shows; the document keeps its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShownMaterials {
    /// The document's own.
    #[default]
    Own,
    /// Gray clay on all, to judge light and shape.
    Clay,
    /// Middle gray of albedo 0.18 on all, to judge exposure.
    #[serde(alias = "grey")]
    Gray,
    /// A mirror on all, to judge reflections and smoothness.
    Chrome,
    /// One material; the others are gray clay.
    Solo(usize),
}

impl ShownMaterials {
    /// The material shown in place of the document's.
    pub fn instead_of(self, index: usize, own: &Material) -> Material {
        let all = |model, name, value: brdf::Value| {
            let parameters = Parameters::default().with(name, value);
            Material { name: own.name.clone(), model, parameters, double_sided: own.double_sided, ..Default::default() }
        };
        let clay = || all(BrdfModel::OrenNayar, "base_color", Vec3::splat(0.5).into());
        match self {
            Self::Own => own.clone(),
            Self::Solo(material) if material == index => own.clone(),
            Self::Clay | Self::Solo(_) => clay(),
            Self::Gray => all(BrdfModel::Lambert, "base_color", Vec3::splat(0.18).into()),
            Self::Chrome => {
                let mirror = all(BrdfModel::Ggx, "base_color", Vec3::splat(0.65).into());
                let parameters = mirror.parameters.with("metalness", 1.0).with("roughness", 0.1);
                Material { parameters, ..mirror }
            }
        }
    }
}

impl ViewSettings {
    /// The cuts that pictures merge.
    pub fn cuts(&self) -> Cuts {
        Cuts::of(self.sampling, self.illum_cut, self.tau)
    }

    /// The background for the renderers.
    pub fn background(&self) -> Background {
        match self.background {
            BackgroundKind::Environment => Background::Environment,
            BackgroundKind::Blurred => Background::Blurred(self.blur_degrees.to_radians()),
            BackgroundKind::Flat => Background::Flat(self.background_color),
            BackgroundKind::Transparent | BackgroundKind::Picture => Background::Transparent,
        }
    }
}
