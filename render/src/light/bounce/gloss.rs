//! Surface sources that send by direction: what a glossy surface reflects depends on where it is seen from (wavelet radiance transport,
//! Kontkanen et al. 2006, with its links replaced by rays and its coefficients by cells, see
//! `docs/decisions/0073-sources-that-send-by-direction.md`).
//!
//! The many bounces that diffuse sources send are known, from a basis. Groups of sources gather them anew, along rays with known ends,
//! once as diffuse senders send them and once by direction. The ratio of both, reflected by the BRDFs of now, corrects each source:
//! where all surfaces are diffuse, nothing changes. Light of lamps needs no rays; its reflection is evaluated at every source. Nothing
//! of a BRDF is kept.

mod groups;
mod reflection;

use super::SourceRig;
use crate::{
    appearance::{Appearance, ResolvedAppearance, narrowest_lobe},
    baked::Baked,
    light::{
        sent::{KNOTS, SentByDirection, Toward},
        situation::Situation,
        sky::SkyGrid,
    },
};
use glam::{Mat3, Vec3};
use groups::{Group, Groups, RayEnd};
use lapidary_core::{lights::Light, material::Material, scene::Mesh, sources::Source};
use rayon::prelude::*;
use reflection::{CELLS, Glossy, Transfer};
use std::{borrow::Cow, collections::BTreeMap};

/// Times that light is gathered by direction: reflections in reflections, this deep. Deeper ones stay those of diffuse surfaces.
const GATHERS: usize = 2;

/// Width of the narrowest lobe that sources send, as a microfacet alpha: about that of a knot.
const NARROWEST: f32 = 0.1;
/// Lobes that are narrower by less than this factor look the same.
const NEARLY: f32 = 0.9;

/// Tells which materials send light by wider lobes than they have.
pub fn remark_on_widened_lobes(appearance: &Appearance) -> Option<String> {
    let is_narrow = |material: &&Material| narrowest_lobe(material) < NEARLY * NARROWEST;
    let names: Vec<&str> = appearance.materials.iter().filter(is_narrow).map(|material| &*material.name).collect();
    let [first, others @ ..] = &names[..] else { return None };
    let which = match others.len() {
        0 => format!("\"{first}\" sends"),
        1 => format!("\"{first}\" and another material send"),
        more => format!("\"{first}\" and {more} other materials send"),
    };
    let roughness = NARROWEST.sqrt();
    Some(format!(
        "{which} bounced light as if of roughness {roughness:.2}: narrower highlights on other surfaces are blurred."
    ))
}

/// What sources send as diffuse surfaces, by where it comes from: radiance in W/(m² sr).
pub(super) struct DiffuseParts {
    /// Reflected light of lamps.
    pub lamps: Vec<Vec3>,
    /// Reflected light of the environment and of further bounces.
    pub rest: Vec<Vec3>,
    /// Emitted light.
    pub emitted: Vec<Vec3>,
}

/// Irradiance of the sources from some lamps in W/m².
pub(super) struct LampLight<'a> {
    pub lights: &'a [Light],
    pub irradiance: Vec<Vec3>,
}

/// Largest ratio of light by direction to that of a diffuse source, against divisions by nearly nothing.
const LARGEST_RATIO: f32 = 4096.0;
/// A material, and the frame and normal of a plane, bit by bit.
type PlaneKey = (u32, [[u32; 3]; 3]);
/// Groups of a plane that share their reflection at least: each takes 200 kB.
const SHARED_BY: usize = 4;

/// Keeps the rays of groups of sources, and sends light by direction.
pub struct GlossRig {
    baked: Baked,
    groups: Groups,
}

impl GlossRig {
    /// Without rays; `None` if the dataset has no sources.
    pub fn new(baked: &Baked) -> Option<Self> {
        let groups = Groups::of(&baked.dataset.indirect.as_ref()?.sources, &baked.dataset.scene.mesh);
        Some(Self { baked: baked.clone(), groups })
    }

    /// Traces the rays of some groups, and returns whether others have none yet.
    pub fn trace_some(&mut self) -> bool {
        self.groups.trace_some(&self.baked)
    }

    /// What the sources of `rig` send by direction, beside what they send as diffuse surfaces. `further` is irradiance of further
    /// bounces, one value per source or none. All rays have been traced.
    pub fn sent(&self, rig: &SourceRig, further: &[Vec3], situation: &Situation) -> SentByDirection {
        let appearance = ResolvedAppearance::from((*situation.appearance).clone());
        let parts = rig.diffuse_parts(further);
        let lit = Lit {
            rig: self,
            sources: rig.tree().sources(),
            mesh: &self.baked.dataset.scene.mesh,
            appearance: &appearance,
            sky: SkyGrid::of(situation),
            parts,
        };
        lit.sent(&rig.lamp_light(), rig)
    }
}

/// All sources under one light.
struct Lit<'a> {
    rig: &'a GlossRig,
    sources: &'a [Source],
    mesh: &'a Mesh,
    appearance: &'a ResolvedAppearance,
    sky: SkyGrid,
    parts: DiffuseParts,
}

/// What depends on the direction: the reflection of lamps by each source, where it is glossy, and the ratio of all other reflected
/// light to that of a diffuse surface, for each group.
struct ByDirection {
    lamps: Vec<Option<Box<Toward>>>,
    ratios: Vec<Toward>,
}

impl Lit<'_> {
    fn sent(&self, lamps: &[LampLight], rig: &SourceRig) -> SentByDirection {
        let surfaces = Surfaces::of(self);
        let ratios = vec![[Vec3::ONE; KNOTS.len()]; self.rig.groups.all().len()];
        let mut by_direction = ByDirection { lamps: self.lamps(lamps, &surfaces), ratios };
        let as_diffuse = self.arriving_of_diffuse();
        for _ in 0..GATHERS {
            let arriving = self.arriving(&by_direction);
            let ratios = (&arriving, &as_diffuse, &surfaces.of_groups).into_par_iter();
            let ratios = ratios.map(|(now, diffuse, surface)| ratios_of(now, diffuse, surfaces.transfer(surface)));
            by_direction.ratios = ratios.collect();
        }
        SentByDirection::new(rig.tree(), |source| (self.diffuse(source), self.toward(&by_direction, source)))
    }

    /// What sources have in common that reflect alike, if their material is the same all over.
    fn plane(&self, source: u32) -> Option<PlaneKey> {
        let surfel = &self.sources[source as usize].surfel;
        let index = self.appearance.material_of(self.mesh, surfel.place.triangle as usize);
        let material = self.appearance.material(index);
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        let Mat3 { x_axis, z_axis, .. } = self.mesh.frame(surfel);
        (!material.varies()).then(|| (index, [x_axis, z_axis, surfel.normal].map(bits)))
    }

    /// The surface of a source, if it has lobes.
    fn glossy(&self, source: u32) -> Option<Glossy> {
        let surfel = &self.sources[source as usize].surfel;
        let brdf = self.appearance.at_place(self.mesh, surfel.place).brdf;
        brdf.as_brdf().narrowest_lobe()?;
        Some(Glossy::new(brdf, self.mesh.frame(surfel), surfel.normal))
    }

    /// Reflection of lamps at each source of a glossy group.
    fn lamps(&self, lamps: &[LampLight], surfaces: &Surfaces) -> Vec<Option<Box<Toward>>> {
        let reflected = |(source, &group): (usize, &u32)| {
            surfaces.of_groups[group as usize].as_ref()?;
            let surface = self.glossy(source as u32)?;
            let at = self.sources[source].surfel.position;
            let mut sum = Box::new([Vec3::ZERO; KNOTS.len()]);
            for LampLight { lights, irradiance } in lamps.iter().filter(|lamp| lamp.irradiance[source] != Vec3::ZERO) {
                let reflected = surface.reflected_lamps(lights, at, irradiance[source]);
                sum.iter_mut().zip(reflected).for_each(|(sum, reflected)| *sum += reflected);
            }
            Some(sum)
        };
        self.rig.groups.of_sources().par_iter().enumerate().with_min_len(64).map(reflected).collect()
    }

    /// Mean radiance that arrives in the cells of each group.
    fn arriving(&self, sent: &ByDirection) -> Vec<[Vec3; CELLS.len()]> {
        self.arriving_from(|source, knot| self.toward(sent, source)(knot))
    }

    /// [`Self::arriving`] while all sources are diffuse.
    fn arriving_of_diffuse(&self) -> Vec<[Vec3; CELLS.len()]> {
        let diffuse: Vec<Vec3> = (0..self.sources.len()).map(|source| self.diffuse(source)).collect();
        self.arriving_from(|source, _| diffuse[source])
    }

    fn arriving_from(&self, radiance: impl Fn(usize, usize) -> Vec3 + Sync) -> Vec<[Vec3; CELLS.len()]> {
        let of_ray = |end: RayEnd| match end {
            RayEnd::Dark => Vec3::ZERO,
            RayEnd::Sky(direction) => self.sky.radiance(direction),
            RayEnd::Source { source, knot } => radiance(source as usize, knot as usize),
        };
        self.rig.groups.cells().map(|cell| cell.map(of_ray)).collect()
    }

    /// Radiance of a source that is diffuse.
    fn diffuse(&self, source: usize) -> Vec3 {
        let DiffuseParts { lamps, rest, emitted } = &self.parts;
        lamps[source] + rest[source] + emitted[source]
    }

    /// Radiance of a source toward each knot.
    fn toward(&self, sent: &ByDirection, source: usize) -> impl Fn(usize) -> Vec3 {
        let DiffuseParts { lamps, rest, emitted } = &self.parts;
        let (lamps, rest, emitted) = (lamps[source], rest[source], emitted[source]);
        let of_lamps = sent.lamps[source].as_ref();
        let ratios = &sent.ratios[self.rig.groups.of_sources()[source] as usize];
        move |knot| of_lamps.map_or(lamps, |toward| toward[knot]) + rest * ratios[knot] + emitted
    }
}

/// The surfaces of the groups. Groups of one plane and material share the reflection of their cells.
struct Surfaces {
    of_groups: Vec<Option<Surface>>,
    shared: Vec<Transfer>,
}

/// The glossy surface of a group.
enum Surface {
    /// Index of a shared reflection.
    Shared(usize),
    /// Of this group alone.
    Own(Box<Glossy>),
}

impl Surfaces {
    fn of(lit: &Lit) -> Self {
        let groups = lit.rig.groups.all();
        let own = |group: &Group| lit.glossy(group.source).map(|glossy| Surface::Own(Box::new(glossy)));
        let mut of_groups: Vec<Option<Surface>> = groups.par_iter().map(own).collect();
        let mut planes: BTreeMap<PlaneKey, Vec<usize>> = BTreeMap::new();
        for group in (0..groups.len()).filter(|&group| of_groups[group].is_some()) {
            lit.plane(groups[group].source).into_iter().for_each(|key| planes.entry(key).or_default().push(group));
        }
        let mut first = Vec::new();
        for members in planes.into_values().filter(|members| members.len() >= SHARED_BY) {
            members.iter().for_each(|&group| of_groups[group] = Some(Surface::Shared(first.len())));
            first.push(groups[members[0]].source);
        }
        let transfer = |&source: &u32| lit.glossy(source).expect("a surface with lobes").transfer();
        Self { of_groups, shared: first.par_iter().map(transfer).collect() }
    }

    fn transfer<'a>(&'a self, surface: &Option<Surface>) -> Option<Cow<'a, Transfer>> {
        Some(match surface.as_ref()? {
            Surface::Shared(index) => Cow::Borrowed(&self.shared[*index]),
            Surface::Own(glossy) => Cow::Owned(glossy.transfer()),
        })
    }
}

/// Ratios of what a group reflects to what a diffuse one would, under the light of diffuse senders.
fn ratios_of(now: &[Vec3; CELLS.len()], diffuse: &[Vec3; CELLS.len()], glossy: Option<Cow<Transfer>>) -> Toward {
    let mean = |cells: &[Vec3; CELLS.len()]| cells.iter().sum::<Vec3>() / CELLS.len() as f32;
    match glossy {
        None => [ratio(mean(now), mean(diffuse)); KNOTS.len()],
        Some(glossy) => {
            let reflected = glossy.albedo() * mean(diffuse);
            glossy.reflected(now).map(|toward| ratio(toward, reflected))
        }
    }
}

/// 1 where nothing would be sent.
fn ratio(now: Vec3, diffuse: Vec3) -> Vec3 {
    let of = |now: f32, diffuse: f32| if diffuse > 0.0 { (now / diffuse).min(LARGEST_RATIO) } else { 1.0 };
    Vec3::new(of(now.x, diffuse.x), of(now.y, diffuse.y), of(now.z, diffuse.z))
}

#[cfg(test)]
mod tests;
