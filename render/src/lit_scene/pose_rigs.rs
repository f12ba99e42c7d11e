//! What lights a posed scene, at one detail or another.

use crate::{
    baked::Baked,
    device::Compute,
    light::{
        implicit::{PoseRig, detail::ImplicitDetail},
        situation::{Changes, Pending},
    },
};
use std::thread::JoinHandle;

/// Rigs by detail, made on a thread before they are needed. The one used last and one beside it are kept.
#[derive(Default)]
pub struct PoseRigs {
    used: Option<Pending<PoseRig>>,
    beside: Option<Pending<PoseRig>>,
    in_the_making: Option<(ImplicitDetail, JoinHandle<PoseRig>)>,
}

impl PoseRigs {
    /// Notes what has changed.
    pub fn note(&mut self, changes: Changes) {
        [&mut self.used, &mut self.beside].into_iter().flatten().for_each(|rig| rig.note(changes));
    }

    /// Begins to make one on a thread. One is made at a time: it does nothing while that is another.
    pub fn prepare(&mut self, detail: ImplicitDetail, baked: &Baked, compute: impl FnOnce() -> Compute) {
        if !self.is_made(detail) && self.in_the_making.is_none() {
            let (baked, compute) = (baked.clone(), compute());
            let made = std::thread::spawn(move || PoseRig::new(&baked, &compute, detail));
            self.in_the_making = Some((detail, made));
        }
    }

    /// Whether one can be used at once.
    pub fn is_made(&mut self, detail: ImplicitDetail) -> bool {
        if let Some((_, made)) = self.in_the_making.take_if(|(_, making)| making.is_finished()) {
            self.beside = Some(Pending::new(joined(made)));
        }
        [&self.used, &self.beside].into_iter().flatten().any(|rig| rig.before().detail() == detail)
    }

    /// The rig of a detail to use, which is made or awaited if it is not there.
    pub fn at(
        &mut self,
        detail: ImplicitDetail,
        baked: &Baked,
        compute: impl FnOnce() -> Compute,
    ) -> &mut Pending<PoseRig> {
        if !self.is_made(detail) {
            let making = self.in_the_making.take_if(|(of, _)| *of == detail);
            let made = making.map_or_else(|| PoseRig::new(baked, &compute(), detail), |(_, made)| joined(made));
            self.beside = Some(Pending::new(made));
        }
        if self.detail() != Some(detail) {
            std::mem::swap(&mut self.used, &mut self.beside);
        }
        self.used.as_mut().expect("one of them is of that detail")
    }

    /// The detail of the one used last.
    pub fn detail(&self) -> Option<ImplicitDetail> {
        self.used.as_ref().map(|rig| rig.before().detail())
    }

    /// The one used last.
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

    fn cores() -> Compute {
        Compute::Cores
    }

    fn no_more() -> Compute {
        panic!("it is made already")
    }

    #[test]
    fn the_one_in_use_and_the_newest_are_kept() {
        let baked = Baked::from(blocked(white(), 4));
        let [a, b, c, ..] = ImplicitDetail::LADDER;
        let mut rigs = PoseRigs::default();
        assert!(rigs.detail().is_none() && rigs.at(a, &baked, cores).before().detail() == a);
        rigs.at(b, &baked, cores);
        assert!([a, b].into_iter().all(|detail| rigs.at(detail, &baked, no_more).before().detail() == detail));
        rigs.at(c, &baked, cores);
        let made = ImplicitDetail::LADDER.map(|detail| rigs.is_made(detail));
        assert_eq!(made, [false, true, true, false, false], "the one that was not used last is gone");
    }

    #[test]
    fn one_is_made_on_a_thread_and_is_that_of_its_detail() {
        let baked = Baked::from(blocked(white(), 4));
        let (mut rigs, detail) = (PoseRigs::default(), ImplicitDetail::LADDER[0]);
        rigs.prepare(detail, &baked, cores);
        rigs.prepare(detail, &baked, no_more);
        assert!(rigs.detail().is_none(), "it is not used before it is asked for");
        let poses = posed(Pose { translate: glam::Vec3::X, ..Pose::AS_BAKED });
        let situation = Situation { scene: baked.posed(&poses).unwrap(), poses, ..Situation::unlit(&baked) };
        let moved = |rig: &mut Pending<PoseRig>| rig.lit(&situation).moved_vertices().to_vec();
        let ahead = moved(rigs.at(detail, &baked, no_more));
        let made = &mut Pending::new(PoseRig::new(&baked, &cores(), detail));
        assert!(ahead == moved(made) && ahead.contains(&true));
        assert!(!rigs.is_made(ImplicitDetail::FINEST), "negative control");
    }
}
