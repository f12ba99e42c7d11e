//! The error of a picture, predicted from the variances within its clusters, without tracing a ray (paper, 3.3).
//!
//! On a node `C` of the merged cut the renderer multiplies means of radiance `l`, BRDF times cosine `ρ` and visibility `v`. The
//! paper reduces the product's error to covariances (after Bohrnstedt and Goldberger 1969) and bounds each by Cauchy and Schwarz,
//! as in Eq. 8: `|C| (<l> σv σρ + <v> σl σρ + <ρ> σl σv)`, where σ² are the variances over the node's leaves. That is
//! [`PredictedError::printed`]. It lacks two terms, which [`PredictedError::bound`] adds:
//!
//! - The third central moment, which the approximation leaves out: at most `|C| max(<v>, 1 - <v>) σl σρ`, because
//!   visibility lies between 0 and 1.
//! - The error of sampling the BRDF (Eq. 6) where Eq. 4 takes its mean: `|C| <l> <v> |ρ - <ρ>|`.
//!
//! With both, the sum over the nodes bounds the error, as far as the stored visibility is the mean at the pixel. A node without
//! stored cuts of its own (interpolation between vertices, a node inside a stored one) can have a larger error. The error reaches
//! the bound only if all nodes err with the same sign. For independent errors, the root of the sum of squares is the expected
//! error: [`PredictedError::expected`].
//!
//! The mean visibility in a node of a lit cut is weighted by the light, so the product of radiance and visibility is exact. The
//! remaining error comes from variation of that product with the BRDF: `|C| σlv σρ`, with `σlv² = <l²> <v> - <l>² <v>²`.
//!
//! Radiance variances are taken over the tree's leaves, computed with the means when the light changes. Visibility is binary, so
//! its variance is `<v> - <v>²`. BRDF variances use eight leaves of each node, which is exact for nodes with at most eight.

mod calibration;
mod moments;

use crate::{
    light::environment::SceneLighting,
    measure::{
        cut_light::{CutLight, NoCuts},
        region::picture_of,
    },
    renderer::Renderer,
    sampling::BrdfSampling,
    shade::{
        background::Backdrop,
        merge::{EightTerms, Shader},
        node_field::NodeField,
        pixel_sampler::PixelSampler,
        point_shader::PointShader,
        surface::{ReceiverX8, SurfacePoint},
    },
    view::{Progress, View},
};
pub use calibration::{Bin, Calibration, CalibrationError, calibrate};
use glam::Vec3;
use lapidary_core::{
    color::luminance,
    image::{Image, Region},
    light_tree::means_up_the_tree,
};
use moments::{Moments, NodeMoments};
use std::array::from_fn;

/// Predicted errors of a picture, each as a gray picture of luminances; black where there is no surface.
#[derive(Clone, Debug)]
pub struct PredictedError {
    /// Sum of the paper's terms over the nodes.
    pub printed: Image,
    /// Sum over the nodes including the terms that the paper omits.
    pub bound: Image,
    /// Root of the sum of squares of the same terms.
    pub expected: Image,
}

/// Predicts the error of a picture by cuts against [`Renderer::samples_reference`], per pixel; `None` if cancelled.
///
/// # Errors
/// A dataset without visibility of the environment.
pub fn predicted_error(
    renderer: &Renderer,
    view: &View,
    lighting: &SceneLighting,
    sampling: BrdfSampling,
    progress: &dyn Progress,
) -> Result<Option<PredictedError>, NoCuts> {
    let cuts = CutLight::Environment(lighting).cuts_of(&renderer.dataset)?;
    let view = view.of_surfaces();
    let backdrop = Backdrop::black();
    let sampler = PixelSampler::new(renderer, &view, &backdrop);
    let variance = radiance_variance(lighting);
    let shader = || Predictor { shader: Shader::new(lighting, cuts, sampling), lighting, variance: &variance };
    let all = picture_of(&sampler, Region::whole(view.size), shader, progress);
    let plane = |all: &Image, i: usize| Image {
        size: all.size,
        pixels: all.pixels.iter().map(|sums| Vec3::splat(sums[i])).collect(),
    };
    Ok(all.map(|all| PredictedError { printed: plane(&all, 0), bound: plane(&all, 1), expected: plane(&all, 2) }))
}

/// Variance of the radiance of the leaves below each node, by heap index.
fn radiance_variance(lighting: &SceneLighting) -> Vec<Vec3> {
    let radiance = &lighting.nodes.radiance;
    let squares: Vec<Vec3> = radiance[radiance.len() / 2..].iter().map(|&l| l * l).collect();
    let variance = |(mean_sq, &mean): (Vec3, &Vec3)| (mean_sq - mean * mean).max(Vec3::ZERO);
    means_up_the_tree(&squares).into_iter().zip(radiance).map(variance).collect()
}

/// Returns the three sums at a point as color components.
struct Predictor<'a> {
    shader: Shader<'a, &'a SceneLighting>,
    lighting: &'a SceneLighting,
    variance: &'a [Vec3],
}

impl PointShader for Predictor<'_> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        let Self { shader, lighting, variance } = self;
        let receiver = ReceiverX8::new(point);
        let (mut printed, mut bound, mut squares) = (0.0, 0.0, 0.0);
        shader.traverse(
            point,
            |_| (),
            |eight: &EightTerms| {
                for lane in (0..8).filter(|&lane| eight.terms[lane].visibility > 0.0) {
                    let node = node_moments(lighting, variance, &receiver, point, eight, lane);
                    let in_print = luminance(node.printed());
                    let whole = in_print + luminance(node.third_moment() + node.sampling());
                    printed += in_print;
                    bound += whole;
                    squares += whole * whole;
                }
            },
        );
        let expected: f32 = squares;
        Vec3::new(printed, bound, expected.sqrt()) * lighting.solid_angle()
    }
}

/// One of eight terms with its variances.
fn node_moments(
    lighting: &SceneLighting,
    variance: &[Vec3],
    receiver: &ReceiverX8,
    point: &SurfacePoint,
    eight: &EightTerms,
    lane: usize,
) -> NodeMoments {
    let node = eight.terms[lane].node;
    let is_received = eight.weight.to_array()[lane] > 0.0;
    let sampled = if is_received { eight.brdf_cos.lane(lane) } else { Vec3::ZERO };
    NodeMoments {
        leaves: (1_u32 << (lighting.height() - node.ilog2())) as f32,
        radiance: Moments { mean: eight.radiance.lane(lane), variance: variance[node as usize] },
        brdf: brdf_moments(lighting, receiver, point, node),
        sampled_brdf: sampled,
        visibility: eight.terms[lane].visibility.min(1.0),
        is_lit: eight.terms[lane].is_lit,
    }
}

/// Mean and variance of BRDF times cosine over eight leaves of a node, evenly spaced in tree order.
fn brdf_moments(lighting: &SceneLighting, receiver: &ReceiverX8, point: &SurfacePoint, node: u32) -> Moments {
    let leaves = 1_usize << (lighting.height() - node.ilog2());
    let first = node as usize * leaves;
    let index = from_fn(|i| first + (2 * i + 1) * leaves / 16);
    let direction = lighting.directions(index, point.position);
    let spread = lighting.leaf_inv_kappas(index, point.position);
    let values = point.reflect(receiver.local(direction), spread);
    let received = receiver.receives(direction).to_array().map(|mask| mask.to_bits() != 0);
    let value = |i: usize| if received[i] { values.lane(i) } else { Vec3::ZERO };
    let moments = Moments::of(from_fn::<_, 8, _>(value));
    // The variance of eight leaves about their own mean is one eighth less than over all leaves.
    let scale = if leaves > 8 { 8.0 / 7.0 } else { 1.0 };
    Moments { variance: moments.variance * scale, ..moments }
}

#[cfg(test)]
mod tests;
