//! Layers of a picture: its light by origin, its surface properties, and the work done.

use super::{Studio, Taken};
use anyhow::{Result, bail};
use glam::Vec3;
use lapidary_core::ground::Ground;
use lapidary_interchange::image::Layer;
use lapidary_render::{Background, Components, Look, SurfaceLayers, ViewMode};
use std::{fmt, str::FromStr};

/// A layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerKind {
    /// The picture itself, which other programs show first.
    Beauty,
    /// Direct light of the environment, and the background.
    Environment,
    /// Direct light of local lights.
    Direct,
    /// All bounced light.
    Indirect,
    /// Shading normals in world space.
    Normal,
    /// Base color.
    Albedo,
    /// Perceptual roughness.
    Roughness,
    /// World positions in meters.
    Position,
    /// Distance along the optical axis in meters.
    Depth,
    /// Share of a pixel that surfaces cover.
    Coverage,
    /// Nodes of the visibility cuts.
    VisibilityNodes,
    /// Nodes of the merged cut.
    MergedNodes,
    /// BRDF evaluations.
    BrdfEvaluations,
}

impl LayerKind {
    /// All layers in file order.
    pub const ALL: [Self; 13] = [
        Self::Beauty,
        Self::Environment,
        Self::Direct,
        Self::Indirect,
        Self::Normal,
        Self::Albedo,
        Self::Roughness,
        Self::Position,
        Self::Depth,
        Self::Coverage,
        Self::VisibilityNodes,
        Self::MergedNodes,
        Self::BrdfEvaluations,
    ];

    /// Name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Beauty => "beauty",
            Self::Environment => "environment",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Roughness => "roughness",
            Self::Position => "position",
            Self::Depth => "depth",
            Self::Coverage => "coverage",
            Self::VisibilityNodes => "visibility-nodes",
            Self::MergedNodes => "merged-nodes",
            Self::BrdfEvaluations => "brdf-evaluations",
        }
    }

    /// Name in files: Nuke does not allow hyphens.
    fn file_name(self) -> String {
        self.name().replace('-', "_")
    }

    /// The light component that it shows, if any.
    fn component(self) -> Option<Components> {
        const NONE: Components = Components { environment: false, direct: false, indirect: false };
        match self {
            Self::Environment => Some(Components { environment: true, ..NONE }),
            Self::Direct => Some(Components { direct: true, ..NONE }),
            Self::Indirect => Some(Components { indirect: true, ..NONE }),
            _ => None,
        }
    }

    /// The count that it shows, if any.
    fn count(self) -> Option<ViewMode> {
        match self {
            Self::VisibilityNodes => Some(ViewMode::VisibilityCut),
            Self::MergedNodes => Some(ViewMode::MergedCut),
            Self::BrdfEvaluations => Some(ViewMode::BrdfEvaluations),
            _ => None,
        }
    }

    /// Whether the look's picture contains it; true for layers other than light components.
    fn is_in(self, look: &Look) -> bool {
        let shown = look.components;
        match self {
            Self::Environment => shown.environment || has_flat_background(look),
            Self::Direct => shown.direct,
            Self::Indirect => shown.indirect,
            _ => true,
        }
    }
}

/// A flat background shows without an environment too.
fn has_flat_background(look: &Look) -> bool {
    matches!(look.view.background, Background::Flat(radiance) if radiance != Vec3::ZERO)
}

/// The requested layers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum LayerList {
    /// All layers that the picture has.
    #[default]
    All,
    /// These layers.
    These(Vec<LayerKind>),
}

impl FromStr for LayerList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim() == "all" {
            return Ok(Self::All);
        }
        let kind = |name: &str| {
            let found = LayerKind::ALL.into_iter().find(|kind| kind.name() == name.trim().replace('_', "-"));
            found.ok_or_else(|| {
                let known: Vec<&str> = LayerKind::ALL.iter().map(|kind| kind.name()).collect();
                format!("\"{}\" is not a layer; list {}, or all", name.trim(), known.join(", "))
            })
        };
        text.split(',').map(kind).collect::<Result<_, _>>().map(Self::These)
    }
}

impl fmt::Display for LayerList {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::These(kinds) => f.write_str(&kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(",")),
        }
    }
}

impl LayerList {
    /// Most layers possible beside the picture.
    pub fn most(&self) -> usize {
        match self {
            Self::All => LayerKind::ALL.len() - 1,
            Self::These(kinds) => kinds.len().min(LayerKind::ALL.len() - 1),
        }
    }

    /// Layers for the picture of a look, each once in file order, always including the picture.
    ///
    /// # Errors
    /// A light component that is not in the picture.
    pub fn of(&self, look: &Look) -> Result<Vec<LayerKind>> {
        let wanted = |kind: &LayerKind| match self {
            Self::All => kind.is_in(look),
            Self::These(kinds) => *kind == LayerKind::Beauty || kinds.contains(kind),
        };
        let kinds: Vec<LayerKind> = LayerKind::ALL.into_iter().filter(wanted).collect();
        if let Some(missing) = kinds.iter().find(|kind| !kind.is_in(look)) {
            let shown = look.components.to_string();
            bail!(
                "the picture has no {0} light, so there is no layer {0}: it shows {shown}; see --components, and bake with \
                 --mode indirect or meshless for bounced light",
                missing.name()
            );
        }
        Ok(kinds)
    }
}

/// Renders a picture and its layers: light components and counts by separate passes, surface properties by camera rays. The light
/// components sum to the picture.
///
/// # Errors
/// As [`Studio::take`].
pub fn take_layers(
    studio: &mut Studio,
    look: &Look,
    kinds: &[LayerKind],
    cancelled: &dyn Fn() -> bool,
) -> Result<(Taken, Vec<Layer>)> {
    let beauty = studio.take(look, cancelled)?;
    let mut surfaces = None;
    let mut layers = Vec::new();
    for &kind in kinds {
        layers.push(match (kind.component(), kind.count()) {
            (Some(part), _) => {
                let taken = studio.take(&only(look, part), cancelled)?;
                Layer::color(&kind.file_name(), &taken.image)
            }
            (_, Some(mode)) => {
                let view = lapidary_render::View { mode, ..look.view.clone() };
                let taken = studio.take(&Look { view, ..look.clone() }, cancelled)?;
                Layer::scalar(&kind.file_name(), "Y", taken.image.pixels.iter().map(|pixel| pixel.x).collect())
            }
            _ if kind == LayerKind::Beauty => beauty_layer(look, &beauty),
            _ => surface_layer(kind, surfaces.get_or_insert_with(|| studio.surfaces(look))),
        });
    }
    Ok((beauty, layers))
}

/// One light component; the background belongs to the environment's, so it is counted once.
fn only(look: &Look, part: Components) -> Look {
    let mut alone = look.clone();
    let shown = look.components;
    alone.components = Components { environment: part.environment && shown.environment, ..part };
    alone.view.hides_background = !part.environment;
    if !look.catches_shadows() && look.view.ground() == Ground::Shadow {
        // As in the picture without an environment.
        alone.view.ground = Ground::On;
    }
    alone
}

/// The picture, with its coverage as alpha channel if the background is transparent.
fn beauty_layer(look: &Look, beauty: &Taken) -> Layer {
    let layer = Layer::color("", &beauty.image);
    if look.view.background == Background::Transparent { layer.with_alpha(&beauty.coverage) } else { layer }
}

fn surface_layer(kind: LayerKind, surfaces: &SurfaceLayers) -> Layer {
    let name = kind.file_name();
    match kind {
        LayerKind::Normal => Layer::vectors(&name, &surfaces.normal),
        LayerKind::Position => Layer::vectors(&name, &surfaces.position),
        LayerKind::Albedo => Layer::color(&name, &surfaces.albedo),
        LayerKind::Roughness => Layer::scalar(&name, "Y", surfaces.roughness.clone()),
        LayerKind::Depth => Layer::scalar(&name, "Z", surfaces.depth.clone()),
        _ => Layer::scalar(&name, "A", surfaces.coverage.clone()),
    }
}
