//! Undo against a model that keeps whole snapshots, and the cases that an artist meets.

use super::*;
use crate::document::{EnvironmentSettings, ViewSettings};
use lapidary_core::{brdf::GgxParameters, camera::Camera, dataset::BakeSettings, material::Material};

fn document() -> Document {
    Document { materials: vec![Material::default(); 3], ..Document::empty() }
}

fn roughness(index: usize, roughness: f32) -> Edit {
    let parameters = GgxParameters { roughness, ..Default::default() };
    Edit::Material { index, material: Box::new(Material { parameters: parameters.into(), ..Default::default() }) }
}

fn rotation(rotation_degrees: f32) -> Edit {
    Edit::Environment(EnvironmentSettings { rotation_degrees, ..Default::default() })
}

fn roughness_of(document: &Document, index: usize) -> f32 {
    document.materials[index].parameters.number("roughness")
}

#[test]
fn a_drag_is_one_step_and_undo_brings_back_the_value_before_it() {
    let (mut document, mut history) = (document(), History::new());
    for i in 0..20 {
        history.apply(&mut document, roughness(0, 0.6 + 0.01 * i as f32), "Roughness");
    }
    history.end_gesture();
    history.apply(&mut document, roughness(0, 0.1), "Roughness");
    assert_eq!(history.undo(&mut document).as_deref(), Some("Roughness"));
    assert_eq!(roughness_of(&document, 0), 0.6 + 0.01 * 19.0);
    assert!(history.undo(&mut document).is_some());
    assert_eq!(roughness_of(&document, 0), 0.5);
    assert_eq!(history.undo(&mut document), None);
    assert!(history.redo(&mut document).is_some());
    assert_eq!(roughness_of(&document, 0), 0.6 + 0.01 * 19.0);
}

#[test]
fn another_label_or_target_in_the_same_gesture_is_another_step() {
    let (mut document, mut history) = (document(), History::new());
    history.apply(&mut document, roughness(0, 0.1), "Roughness");
    history.apply(&mut document, roughness(1, 0.2), "Roughness");
    history.apply(&mut document, roughness(1, 0.3), "Reset");
    for expected in ["Reset", "Roughness", "Roughness"] {
        assert_eq!(history.undo_name(&document).as_deref(), Some(expected));
        history.undo(&mut document);
    }
    assert_eq!(history.undo_name(&document), None);
    assert_eq!(history.redo_name(&document).as_deref(), Some("Roughness"));
}

#[test]
fn what_changes_nothing_or_has_no_target_leaves_no_trace() {
    let (mut document, mut history) = (document(), History::new());
    history.apply(&mut document, roughness(0, 0.5), "Roughness");
    history.apply(&mut document, roughness(3, 0.1), "Roughness");
    assert_eq!((history.undo_name(&document), history.revision(), history.is_modified()), (None, 0, false));
    history.apply(&mut document, roughness(0, 0.1), "Roughness");
    history.apply(&mut document, roughness(0, 0.5), "Roughness");
    assert_eq!((history.undo_name(&document), history.is_modified()), (None, false), "a drag that came back");
    assert_eq!(history.revision(), 2);
}

#[test]
fn steps_for_materials_that_are_gone_are_skipped() {
    let (mut document, mut history) = (document(), History::new());
    history.apply(&mut document, rotation(10.0), "Rotation");
    history.apply(&mut document, roughness(2, 0.1), "Roughness");
    document.materials.truncate(1);
    assert_eq!(history.undo(&mut document).as_deref(), Some("Rotation"));
}

#[test]
fn the_saved_state_is_known_again_after_undo_and_lost_with_its_branch() {
    let (mut document, mut history) = (document(), History::new());
    history.apply(&mut document, rotation(10.0), "Rotation");
    history.mark_saved();
    history.apply(&mut document, rotation(20.0), "Rotation");
    assert!(history.is_modified());
    history.undo(&mut document);
    assert_eq!((document.environment.rotation_degrees, history.is_modified()), (10.0, false));
    history.undo(&mut document);
    assert!(history.is_modified());
    history.apply(&mut document, rotation(30.0), "Rotation");
    assert!(history.is_modified() && history.redo(&mut document).is_none());
    history.undo(&mut document);
    assert!(history.is_modified(), "the saved state can no longer be reached");
    assert!(History::unsaved().is_modified());
}

#[test]
fn a_thousand_steps_are_kept() {
    let (mut document, mut history) = (document(), History::new());
    for i in 1..=DEPTH + 5 {
        history.apply(&mut document, rotation(i as f32), "Rotation");
        history.end_gesture();
    }
    let mut undone = 0;
    while history.undo(&mut document).is_some() {
        undone += 1;
    }
    assert_eq!((undone, document.environment.rotation_degrees), (DEPTH, 5.0));
    assert!(history.is_modified());
}

/// Everything that edits change.
type Snapshot = (Vec<Material>, EnvironmentSettings, ViewSettings, Vec<Camera>, BakeSettings);

fn snapshot(d: &Document) -> Snapshot {
    (d.materials.clone(), d.environment.clone(), d.view.clone(), d.bookmarks.clone(), d.bake.clone())
}

/// Whole snapshots before each step, and the number of steps at which the document was saved.
struct Model {
    past: Vec<(Snapshot, Edit, &'static str)>,
    future: Vec<(Snapshot, Edit, &'static str)>,
    now: Snapshot,
    open: bool,
    saved: Option<usize>,
}

impl Model {
    fn apply(&mut self, after: Snapshot, edit: Edit, label: &'static str) {
        if after == self.now {
            return;
        }
        self.future.clear();
        let joins = self.open && self.past.last().is_some_and(|(_, e, l)| *l == label && e.same_target(&edit));
        self.saved = self.saved.filter(|&s| s < self.past.len() || (s == self.past.len() && !joins));
        if !joins {
            self.past.push((self.now.clone(), edit, label));
        }
        self.open = true;
        self.now = after;
        if joins && self.past.last().is_some_and(|(before, ..)| *before == self.now) {
            self.past.pop();
            self.open = false;
        }
    }

    fn go(&mut self, back: bool) {
        self.open = false;
        let (from, to) = if back { (&mut self.past, &mut self.future) } else { (&mut self.future, &mut self.past) };
        if let Some((there, edit, label)) = from.pop() {
            to.push((std::mem::replace(&mut self.now, there), edit, label));
        }
    }
}

/// A generator of Marsaglia's (xorshift, 2003), so that a failing seed can be run again.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        for (left, shift) in [(true, 13), (false, 7), (true, 17)] {
            self.0 ^= if left { self.0 << shift } else { self.0 >> shift };
        }
        (self.0 >> 11) % n
    }

    fn edit(&mut self) -> Edit {
        let value = self.below(4);
        match self.below(6) {
            0 => rotation(value as f32),
            1 => Edit::View(ViewSettings { aa: 16 + value as u32, ..Default::default() }),
            2 => Edit::Bookmarks(vec![Document::empty().camera; value as usize]),
            3 => Edit::Bake(Box::new(BakeSettings { pilot_clusters: 1024 + value as usize, ..Document::empty().bake })),
            _ => roughness(self.below(4) as usize, 0.5 + 0.1 * value as f32),
        }
    }
}

/// Whether history and model agree after each of some hundred random actions; `forget_gestures` breaks the history.
fn agrees(seed: u64, forget_gestures: bool) -> bool {
    let mut random = Random(seed);
    let (mut document, mut history) = (document(), History::new());
    let now = snapshot(&document);
    let mut model = Model { past: Vec::new(), future: Vec::new(), now, open: false, saved: Some(0) };
    (0..300).all(|_| {
        let revision = history.revision();
        let before = snapshot(&document);
        act(&mut random, &mut document, &mut history, &mut model, forget_gestures);
        let after = snapshot(&document);
        after == model.now
            && history.undo_name(&document).as_deref() == model.past.last().map(|(.., label)| *label)
            && history.redo_name(&document).as_deref() == model.future.last().map(|(.., label)| *label)
            && history.is_modified() == (model.saved != Some(model.past.len()))
            && (history.revision() != revision || after == before)
    })
}

fn act(random: &mut Random, document: &mut Document, history: &mut History, model: &mut Model, forget: bool) {
    match random.below(10) {
        0 => {
            model.open = false;
            if !forget {
                history.end_gesture();
            }
        }
        1 | 2 => {
            history.undo(document);
            model.go(true);
        }
        3 => {
            history.redo(document);
            model.go(false);
        }
        4 => {
            history.mark_saved();
            model.open = false;
            model.saved = Some(model.past.len());
        }
        _ => {
            let edit = random.edit();
            let label = ["A", "B"][random.below(2) as usize];
            history.apply(document, edit.clone(), label);
            let mut after = Document { materials: model.now.0.clone(), ..Document::empty() };
            (after.environment, after.view) = (model.now.1.clone(), model.now.2.clone());
            (after.bookmarks, after.bake) = (model.now.3.clone(), model.now.4.clone());
            if edit.fits(&after) {
                edit.clone().swap(&mut after);
            }
            model.apply(snapshot(&after), edit, label);
        }
    }
}

#[test]
fn random_edits_agree_with_whole_snapshots() {
    for seed in 1..=300 {
        assert!(agrees(u64::wrapping_mul(seed, 0x9e37_79b9_7f4a_7c15), false), "seed {seed}");
    }
}

#[test]
fn the_model_notices_a_history_that_forgets_where_gestures_end() {
    assert!((1..=20).any(|seed: u64| !agrees(seed * 0x1234_5677, true)));
}
