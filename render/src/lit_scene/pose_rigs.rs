//! Rigs that light a posed scene, at several details.

use crate::{
    baked::Baked,
    device::Compute,
    light::{
        implicit::{PoseRig, detail::ImplicitDetail},
        situation::{Changes, Pending},
    },
};
use std::thread::JoinHandle;

/// Rigs by detail, built on a thread in advance. The last used one and one more are kept.
#[derive(Default)]
pub struct PoseRigs {
    used: Option<Pending<PoseRig>>,
    beside: Option<Pending<PoseRig>>,
    in_the_making: Option<(ImplicitDetail, JoinHandle<PoseRig>)>,
}

impl PoseRigs {
    /// Records changes.
    pub fn note(&mut self, changes: Changes) {
        [&mut self.used, &mut self.beside].into_iter().flatten().for_each(|rig| rig.note(changes));
    }

    /// Starts to build a rig on a thread. Only one is built at a time: the call does nothing while another is being built.
    pub fn prepare(&mut self, detail: ImplicitDetail, baked: &Baked, compute: &Compute) {
        if !self.is_made(detail) && self.in_the_making.is_none() {
            let (baked, compute) = (baked.clone(), compute.clone());
            let made = std::thread::spawn(move || PoseRig::new(&baked, &compute, detail));
            self.in_the_making = Some((detail, made));
        }
    }

    /// Whether a rig is ready.
    pub fn is_made(&mut self, detail: ImplicitDetail) -> bool {
        if let Some((_, made)) = self.in_the_making.take_if(|(_, making)| making.is_finished()) {
            self.beside = Some(Pending::new(joined(made)));
        }
        [&self.used, &self.beside].into_iter().flatten().any(|rig| rig.before().detail() == detail)
    }

    /// The rig of a detail; built or awaited if missing.
    pub fn at(&mut self, detail: ImplicitDetail, baked: &Baked, compute: &Compute) -> &mut Pending<PoseRig> {
        if !self.is_made(detail) {
            let making = self.in_the_making.take_if(|(of, _)| *of == detail);
            let made = making.map_or_else(|| PoseRig::new(baked, compute, detail), |(_, made)| joined(made));
            self.beside = Some(Pending::new(made));
        }
        if self.detail() != Some(detail) {
            std::mem::swap(&mut self.used, &mut self.beside);
        }
        self.used.as_mut().expect("one of them is of that detail")
    }

    /// The detail of the last used rig.
    pub fn detail(&self) -> Option<ImplicitDetail> {
        self.used.as_ref().map(|rig| rig.before().detail())
    }

    /// Whether the last used rig has glossy surfaces.
    pub fn is_glossy(&self) -> bool {
        self.used.as_ref().is_some_and(|rig| rig.before().is_glossy())
    }

    /// The last used rig.
    pub fn used(&mut self) -> Option<&mut Pending<PoseRig>> {
        self.used.as_mut()
    }
}

fn joined(made: JoinHandle<PoseRig>) -> PoseRig {
    made.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{
        implicit::tests::{blocked, posed},
        situation::Situation,
    };
    use crate::test_scenes::white;
    use lapidary_core::scene::pose::Pose;

    const CORES: &Compute = &Compute::Cores;

    #[test]
    fn the_one_in_use_and_the_newest_are_kept() {
        let baked = Baked::from(blocked(white(), 4));
        let [a, b, c, ..] = ImplicitDetail::LADDER;
        let mut rigs = PoseRigs::default();
        assert!(rigs.detail().is_none() && rigs.at(a, &baked, CORES).before().detail() == a);
        rigs.at(b, &baked, CORES);
        assert!([a, b].into_iter().all(|d| rigs.is_made(d) && rigs.at(d, &baked, CORES).before().detail() == d));
        rigs.at(c, &baked, CORES);
        let made = ImplicitDetail::LADDER.map(|detail| rigs.is_made(detail));
        assert_eq!(made, [false, true, true, false, false], "the rig that was not used last is gone");
    }

    #[test]
    fn one_is_made_on_a_thread_and_is_that_of_its_detail() {
        let baked = Baked::from(blocked(white(), 4));
        let (mut rigs, detail) = (PoseRigs::default(), ImplicitDetail::LADDER[0]);
        rigs.prepare(detail, &baked, CORES);
        rigs.prepare(ImplicitDetail::FINEST, &baked, CORES);
        assert!(rigs.in_the_making.as_ref().is_some_and(|(of, _)| *of == detail), "one at a time");
        assert!(rigs.detail().is_none(), "no rig is used before it is requested");
        let poses = posed(Pose { translate: glam::Vec3::X, ..Pose::AS_BAKED });
        let situation = Situation { scene: baked.posed(&poses).unwrap(), poses, ..Situation::unlit(&baked) };
        let moved = |rig: &mut Pending<PoseRig>| rig.lit(&situation).has_new_cut().to_vec();
        let ahead = moved(rigs.at(detail, &baked, CORES));
        let made = &mut Pending::new(PoseRig::new(&baked, CORES, detail));
        assert!(rigs.in_the_making.is_none(), "the thread's rig is used");
        assert!(ahead == moved(made) && ahead.contains(&true));
        assert!(!rigs.is_made(ImplicitDetail::FINEST), "negative control");
    }
}
