//! Wavelet transport on disk, with settings and report.
//!
//! Tensors (P patches, N functions, K coefficients of one bounce or of all):
//!
//! | name | type | shape | |
//! |---|---|---|---|
//! | `wavelet_patches` | f32 | P, 18 | corner, both edges, and tangent, bitangent and normal of the frame, meters |
//! | `wavelet_patch_numbers` | u32 | P, 3 | material, object, and cells of directions along an edge |
//! | `wavelet_functions` | u32 | N, 3 | patch, function of places and function of directions, ascending |
//! | `wavelet_direct_starts`, `wavelet_global_starts` | u64 | N + 1 | first coefficient of each sender, and the end |
//! | `wavelet_direct_receivers`, `wavelet_global_receivers` | u32 | K | receiver of each coefficient |
//! | `wavelet_direct_values`, `wavelet_global_values` | f32 | K, 3 | its value for red, green and blue |
//!
//! A function of a square is a number: the path of its support in the quadtree, then two bits.

use super::{
    Dataset,
    error::Damage,
    reader::Reader,
    stored::{StoredPart, is_size},
    tensors::{Tensor, owned, tensor},
};
use crate::{
    scene::Scene,
    sphere::concentric::HemisphereCells,
    wavelet::{
        WaveletTransport,
        operator::{Operator, RadianceBasis, RadianceFunction},
        patch::Patch,
        reflecting::ReflectingPatch,
        square::Function,
    },
};
use glam::{Mat3, Vec3};
use safetensors::Dtype;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Most halvings of a patch in a dataset.
const MOST_LEVELS: u32 = 8;

/// Settings of wavelet transport.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaveletSettings {
    /// Coefficients of each power in the series of bounces up to this are left out (τ of the wavelet paper, 4.4), and those of one
    /// bounce up to a tenth of it.
    pub compression: f32,
}

impl Default for WaveletSettings {
    /// Ten times the paper's threshold, for the same pictures: see `docs/lab-notes/2026-11-29-wavelet-transport.md`.
    fn default() -> Self {
        Self { compression: 1e-4 }
    }
}

/// Report of wavelet transport.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaveletReport {
    /// Quads of the scene.
    pub patches: usize,
    /// Functions of radiance on them.
    pub functions: usize,
    /// Coefficients of one bounce.
    pub direct: usize,
    /// Coefficients of all bounces.
    pub global: usize,
    /// Coefficients of each power of one bounce, from the first on.
    pub powers: Vec<usize>,
    /// Bytes of both matrices.
    pub bytes: u64,
}

/// Wavelet transport in a dataset.
pub(super) struct StoredWavelet;

impl StoredPart for StoredWavelet {
    fn is_in(&self, dataset: &Dataset) -> bool {
        dataset.wavelet.is_some()
    }

    fn tensors<'a>(&self, dataset: &'a Dataset) -> Vec<Tensor<'a>> {
        dataset.wavelet.as_deref().map_or_else(Vec::new, tensors)
    }

    fn read(&self, reader: &Reader, dataset: &mut Dataset) -> Result<(), Damage> {
        dataset.wavelet = reader.wavelet(&dataset.scene)?.map(Into::into);
        Ok(())
    }

    fn settings(&self, dataset: &Dataset) -> Vec<(&'static str, bool)> {
        vec![("compression", is_size(dataset.settings.wavelet.compression))]
    }

    fn check(&self, dataset: &Dataset) -> Result<(), Damage> {
        let patches = dataset.wavelet.as_ref().map_or(&[][..], |transport| &transport.patches);
        patches.iter().enumerate().try_for_each(|(index, patch)| {
            let is_valid = is_valid(patch, &dataset.scene);
            if is_valid { Ok(()) } else { Err(Damage::of_part(WaveletDamage::Patch(index))) }
        })
    }
}

fn is_valid(ReflectingPatch { patch, cells, .. }: &ReflectingPatch, scene: &Scene) -> bool {
    let frame = patch.frame;
    let is_turned = (frame.transpose() * frame).abs_diff_eq(Mat3::IDENTITY, 1e-3);
    let is_placed = patch.corner.is_finite() && patch.edges.iter().all(|edge| edge.is_finite());
    is_turned
        && is_placed
        && (patch.material as usize) < scene.materials.len()
        && (patch.object as usize) < scene.objects.len()
        && cells.side.is_power_of_two()
        && cells.side <= ReflectingPatch::MOST_CELLS_ALONG
        && patch.edges[0].cross(patch.edges[1]).normalize_or_zero().dot(frame.z_axis) > 0.999
}

/// The function of two numbers on a patch, if the bake could have made it.
fn function_of([space, angle]: [u32; 2], cells: HemisphereCells) -> Option<[Function; 2]> {
    let of = |bits: u32, level: u32| Function::from_bits(bits).filter(|function| function.is_in_basis(level));
    Some([of(space, MOST_LEVELS)?, of(angle, cells.side.ilog2())?])
}

/// The tensors of wavelet transport.
fn tensors(transport: &WaveletTransport) -> Vec<Tensor<'_>> {
    let place = |ReflectingPatch { patch, .. }: &ReflectingPatch| {
        let [tangent, bitangent, normal] = [patch.frame.x_axis, patch.frame.y_axis, patch.frame.z_axis];
        [patch.corner, patch.edges[0], patch.edges[1], tangent, bitangent, normal]
    };
    let numbers =
        |ReflectingPatch { patch, cells, .. }: &ReflectingPatch| [patch.material, patch.object, cells.side as u32];
    let of_function = |f: &RadianceFunction| [f.patch, f.space.to_bits(), f.angle.to_bits()];
    let places: Vec<[Vec3; 6]> = transport.patches.iter().map(place).collect();
    let numbers: Vec<[u32; 3]> = transport.patches.iter().map(numbers).collect();
    let functions: Vec<[u32; 3]> = transport.basis.functions().iter().map(of_function).collect();
    let mut tensors = vec![
        owned(tensor("wavelet_patches", Dtype::F32, [places.len(), 18], &places)),
        owned(tensor("wavelet_patch_numbers", Dtype::U32, [numbers.len(), 3], &numbers)),
        owned(tensor("wavelet_functions", Dtype::U32, [functions.len(), 3], &functions)),
    ];
    for (name, operator) in [("direct", &transport.direct), ("global", &transport.global)] {
        let starts: Vec<u64> = operator.starts().iter().map(|&start| start as u64).collect();
        let (receivers, values): (Vec<u32>, Vec<Vec3>) = operator.entries().iter().copied().unzip();
        tensors.extend([
            owned(tensor(&format!("wavelet_{name}_starts"), Dtype::U64, [starts.len()], &starts)),
            owned(tensor(&format!("wavelet_{name}_receivers"), Dtype::U32, [receivers.len()], &receivers)),
            owned(tensor(&format!("wavelet_{name}_values"), Dtype::F32, [values.len(), 3], &values)),
        ]);
    }
    tensors
}

impl Reader<'_> {
    /// Wavelet transport, if there is any.
    fn wavelet(&self, scene: &Scene) -> Result<Option<WaveletTransport>, Damage> {
        if !self.has("wavelet_patches") {
            return Ok(None);
        }
        let places: Vec<[Vec3; 6]> = self.array("wavelet_patches", Dtype::F32, &[18], None)?;
        let numbers: Vec<[u32; 3]> = self.array("wavelet_patch_numbers", Dtype::U32, &[3], Some(places.len()))?;
        if let Some(index) = numbers.iter().position(|[material, ..]| *material as usize >= scene.materials.len()) {
            return Err(Damage::of_part(WaveletDamage::Patch(index)));
        }
        let patch =
            |(&[corner, u, v, tangent, bitangent, normal], &[material, object, _]): (&[Vec3; 6], &[u32; 3])| Patch {
                corner,
                edges: [u, v],
                frame: Mat3::from_cols(tangent, bitangent, normal),
                area: u.cross(v).length(),
                material,
                object,
            };
        let mut patches = ReflectingPatch::all(places.iter().zip(&numbers).map(patch).collect(), &scene.materials);
        for (index, (patch, [.., side])) in patches.iter_mut().zip(numbers).enumerate() {
            if side == 0 {
                return Err(Damage::of_part(WaveletDamage::Patch(index)));
            }
            patch.cells = HemisphereCells { side: side as usize };
        }
        let functions: Vec<[u32; 3]> = self.array("wavelet_functions", Dtype::U32, &[3], None)?;
        let function = |[patch, space, angle]: [u32; 3]| {
            let [space, angle] = function_of([space, angle], patches.get(patch as usize)?.cells)?;
            Some(RadianceFunction { patch, space, angle })
        };
        let functions: Option<Vec<_>> = functions.into_iter().map(function).collect();
        let basis = functions.and_then(RadianceBasis::from_functions);
        let basis = basis.ok_or_else(|| Damage::of_part(WaveletDamage::Functions))?;
        let count = basis.functions().len();
        let [direct, global] = [self.operator("direct", count)?, self.operator("global", count)?];
        Ok(Some(WaveletTransport { patches, basis, direct, global }))
    }

    fn operator(&self, name: &'static str, functions: usize) -> Result<Operator, Damage> {
        let starts: Vec<u64> = self.array(&format!("wavelet_{name}_starts"), Dtype::U64, &[], Some(functions + 1))?;
        let receivers: Vec<u32> = self.array(&format!("wavelet_{name}_receivers"), Dtype::U32, &[], None)?;
        let values: Vec<Vec3> =
            self.array(&format!("wavelet_{name}_values"), Dtype::F32, &[3], Some(receivers.len()))?;
        let starts = starts.into_iter().map(|start| start as usize).collect();
        let operator = Operator::from_parts(starts, receivers.into_iter().zip(values).collect());
        operator.ok_or_else(|| Damage::of_part(WaveletDamage::Operator(name)))
    }
}

/// Errors of stored wavelet transport.
#[derive(Debug, Error, PartialEq)]
enum WaveletDamage {
    /// A patch is no quad of the scene.
    #[error("patch {0} of the wavelet transport is no quad of the scene")]
    Patch(usize),
    /// Functions do not exist, or are not in order.
    #[error("the functions of the wavelet transport do not exist or are not in order")]
    Functions,
    /// Coefficients lie between functions that do not exist, or are not finite.
    #[error("the matrix `{0}` of the wavelet transport has coefficients that are not finite or of no function")]
    Operator(&'static str),
}
