//! Lit points that several solvers share, so that each ray is cast once.

use crate::{
    baked::Baked,
    light::{
        bounce::{GlossRig, MeshlessRig, RadiosityRig, SourceRig, WaveletRig},
        situation::{Changes, Pending, Situation},
    },
};

/// Shared inputs of the solvers.
pub struct Rigs {
    baked: Baked,
    sources: Option<Pending<SourceRig>>,
    meshless: Option<Pending<MeshlessRig>>,
    radiosity: Option<Pending<RadiosityRig>>,
    wavelet: Option<Pending<WaveletRig>>,
    /// Made at the first use.
    gloss: Option<GlossRig>,
}

impl Rigs {
    /// Creates the rigs of a dataset.
    pub fn new(baked: &Baked) -> Self {
        Self {
            baked: baked.clone(),
            sources: SourceRig::new(baked).map(Pending::new),
            meshless: MeshlessRig::new(baked).map(Pending::new),
            radiosity: RadiosityRig::new(baked).map(Pending::new),
            wavelet: WaveletRig::new(baked).map(Pending::new),
            gloss: None,
        }
    }

    /// Records changes.
    pub fn note(&mut self, changes: Changes) {
        self.sources.iter_mut().for_each(|rig| rig.note(changes));
        self.meshless.iter_mut().for_each(|rig| rig.note(changes));
        self.radiosity.iter_mut().for_each(|rig| rig.note(changes));
        self.wavelet.iter_mut().for_each(|rig| rig.note(changes));
    }

    /// Surface sources under direct light; `None` for a dataset without sources.
    pub fn sources(&mut self, situation: &Situation) -> Option<&mut SourceRig> {
        Some(self.sources.as_mut()?.lit(situation))
    }

    /// Meshless basis under direct light; `None` for a dataset without a basis.
    pub fn meshless(&mut self, situation: &Situation) -> Option<&mut MeshlessRig> {
        Some(self.meshless.as_mut()?.lit(situation))
    }

    /// Functions of the objects under direct light; `None` for a dataset without them.
    pub fn radiosity(&mut self, situation: &Situation) -> Option<&mut RadiosityRig> {
        Some(self.radiosity.as_mut()?.lit(situation))
    }

    /// Rays between sources, which no light changes, and the sources under direct light; `None` for a dataset without sources.
    pub fn gloss(&mut self, situation: &Situation) -> Option<(&mut GlossRig, &SourceRig)> {
        let sources = self.sources.as_mut()?.lit(situation);
        if self.gloss.is_none() {
            self.gloss = GlossRig::new(&self.baked);
        }
        Some((self.gloss.as_mut()?, sources))
    }

    /// Quads under direct light; `None` for a dataset without wavelet transport.
    pub fn wavelet(&mut self, situation: &Situation) -> Option<&mut WaveletRig> {
        Some(self.wavelet.as_mut()?.lit(situation))
    }
}
