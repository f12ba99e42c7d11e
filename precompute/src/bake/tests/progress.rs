//! Progress of a bake: each long phase reports in steps.

use super::{job, with};
use crate::{
    bake,
    observer::{Event, Observer, Phase},
    test_scenes::{cuboid, room, scene_of},
};
use glam::Vec3;
use lapidary_core::dataset::BakeParts;
use std::sync::Mutex;

/// Phases with their totals and reports.
#[derive(Default)]
struct Heard(Mutex<Vec<(Phase, u64, Vec<u64>)>>);

impl Observer for Heard {
    fn event(&self, event: Event) {
        let mut heard = self.0.lock().unwrap();
        match event {
            Event::Started { phase, total, .. } => heard.push((phase, total, Vec::new())),
            Event::Advanced { done } => heard.last_mut().unwrap().2.push(done),
            Event::Warning { .. } => {}
        }
    }
}

#[test]
fn every_phase_tells_how_far_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut triangles = room(Vec3::ZERO, Vec3::splat(2.0)).to_vec();
    triangles.extend(cuboid(Vec3::new(1.0, 0.3, 1.2), Vec3::splat(0.25)));
    let job = with(job(folder.path(), "room.cuts"), |s| {
        (s.mode, s.indirect.sources, s.meshless.levels, s.meshless.sender_levels) =
            (BakeParts::ALL.with(BakeParts::RADIOSITY), 512, 3, 2);
        s.object_bases.functions = 2000;
        s.indirect.viewpoint = Some(Vec3::splat(0.9));
    });
    let heard = Heard::default();
    bake(scene_of(&triangles), &job, &heard).unwrap();
    let heard = heard.0.into_inner().unwrap();
    let long = [
        Phase::Tessellate,
        Phase::Pilot,
        Phase::Visibility,
        Phase::Points,
        Phase::SourceTree,
        Phase::SourceVisibility,
        Phase::SourceEnvironment,
        Phase::Basis,
        Phase::Transport,
        Phase::ObjectBases,
    ];
    let mut in_steps = 0;
    for phase in long {
        let (_, total, told) = heard.iter().find(|(heard, ..)| *heard == phase).unwrap();
        let farthest = *told.iter().max().unwrap_or(&0) as f64 / *total as f64;
        in_steps += usize::from(told.len() > 1);
        if matches!(phase, Phase::Points | Phase::Basis) {
            assert!(told.is_sorted() && told.len() > 100, "{phase:?} told {told:?}");
        }
        assert!(told.len() > 1 || *total < 100, "{phase:?} told {told:?} of {total}");
        assert!((0.25..2.0).contains(&farthest), "{phase:?} came to {farthest} of its total");
    }
    assert!(in_steps >= 5, "{in_steps} phases told steps");
}
