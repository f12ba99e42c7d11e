//! What the comparison says, in one plain sentence, and what to do about it.

use super::{ComparisonContext, ComparisonPanel, KindChoice};
use crate::{
    actions::{Action, BakeAction},
    widgets::copyable,
};
use egui::{Button, RichText, Ui};
use lapidary_core::camera::Camera;

/// Mean FLIP below which no difference is seen side by side, and below which differences are small.
const UNSEEN: f64 = 0.02;
const SMALL: f64 = 0.05;

/// Data behind the picture that is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Without shadows.
    Unshadowed,
    /// A draft.
    Draft,
    /// Objects were moved after the bake.
    Moved,
    /// A whole bake of what is shown.
    #[default]
    Baked,
}

/// What is compared, beside the figures.
#[derive(Clone, Copy, Debug, Default)]
pub struct Subject<'a> {
    /// Data behind the picture.
    pub stage: Stage,
    /// Whether a bake runs.
    pub is_baking: bool,
    /// Whether there is a scene to bake.
    pub can_bake: bool,
    /// The camera of the picture, if the bake is not for its view yet.
    pub camera: Option<&'a Camera>,
}

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Remedy {
    BakeNow,
    BakeForView,
}

/// Shows the sentence and its button.
pub fn show(ui: &mut Ui, panel: &ComparisonPanel, context: &ComparisonContext, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        if let Some(problem) = context.problem {
            drop(copyable(ui, RichText::new(problem).color(ui.visuals().error_fg_color)));
            return;
        }
        let Some(measured) = context.measured else {
            ui.weak(super::waiting(panel));
            return;
        };
        let (flip, is_finished) = (measured.metrics.flip, measured.reference.finished);
        ui.label(sentence(panel.kind, flip, is_finished, &context.subject));
        let Some(remedy) = remedy(panel.kind, flip, is_finished, &context.subject) else { return };
        let (label, help) = match remedy {
            Remedy::BakeNow => ("Bake now", "Bakes the scene as it is shown"),
            Remedy::BakeForView => (
                "Bake more for this view",
                "Bakes again, with vertices where this view needs them; other views may get worse",
            ),
        };
        if ui.add(Button::new(label)).on_hover_text(help).clicked() {
            if let Some(camera) = context.subject.camera.filter(|_| remedy == Remedy::BakeForView) {
                actions.push(Action::Bake(BakeAction::ForViews(vec![camera.clone()])));
            }
            actions.push(Action::Bake(BakeAction::Begin { resume: false }));
        }
    });
}

/// What the figures mean.
fn sentence(kind: KindChoice, flip: f64, is_finished: bool, subject: &Subject) -> String {
    let size = match flip {
        _ if flip < UNSEEN => "no visible difference",
        _ if flip < SMALL => "small differences",
        _ => "large differences",
    };
    let so_far = if is_finished { "" } else { " so far" };
    if kind == KindChoice::Look {
        return format!("Two looks: {size}.");
    }
    match (subject.stage, subject.is_baking) {
        (Stage::Unshadowed, true) => "This is the preview without shadows. Wait for the bake.".into(),
        (Stage::Unshadowed, false) => "This is the preview without shadows.".into(),
        (Stage::Draft, true) => {
            format!("This is the draft, with soft and coarse shadows: {size}{so_far}. Wait for the bake.")
        }
        (Stage::Draft, false) => format!("This is the draft, with soft and coarse shadows: {size}{so_far}."),
        (Stage::Moved, true) => format!("Shadows of moved objects are a preview: {size}{so_far}. Wait for the bake."),
        (Stage::Moved, false) => format!("Shadows of moved objects are a preview: {size}{so_far}."),
        (Stage::Baked, _) if flip < UNSEEN => format!("The picture is right: {size} from the reference{so_far}."),
        (Stage::Baked, _) => format!("The picture has {size} from the reference{so_far}."),
    }
}

/// What to do about it; nothing while a bake runs, or if the picture is right. A picture of another program may differ for any reason.
fn remedy(kind: KindChoice, flip: f64, is_finished: bool, subject: &Subject) -> Option<Remedy> {
    if matches!(kind, KindChoice::Look | KindChoice::File) || subject.is_baking || !subject.can_bake {
        return None;
    }
    match subject.stage {
        Stage::Baked => (is_finished && flip >= UNSEEN && subject.camera.is_some()).then_some(Remedy::BakeForView),
        Stage::Unshadowed | Stage::Draft | Stage::Moved => Some(Remedy::BakeNow),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use std::sync::LazyLock;

    const FINISHED: bool = true;

    fn subject(stage: Stage, is_baking: bool) -> Subject<'static> {
        static CAMERA: LazyLock<Camera> = LazyLock::new(|| Camera::look_at(Vec3::Z, Vec3::ZERO, 40.0));
        Subject { stage, is_baking, can_bake: true, camera: Some(&CAMERA) }
    }

    fn said(flip: f64, subject: Subject) -> (String, Option<Remedy>) {
        let kind = KindChoice::Samples;
        (sentence(kind, flip, FINISHED, &subject), remedy(kind, flip, FINISHED, &subject))
    }

    #[test]
    fn a_draft_is_called_one_however_small_its_error_is_and_waits_for_the_bake_that_runs() {
        for flip in [0.002, 0.3] {
            let (words, remedy) = said(flip, subject(Stage::Draft, true));
            assert!(words.contains("draft") && words.ends_with("Wait for the bake.") && remedy.is_none(), "{words}");
            let (words, remedy) = said(flip, subject(Stage::Draft, false));
            assert!(!words.contains("Wait") && remedy == Some(Remedy::BakeNow), "{words}");
        }
    }

    #[test]
    fn a_whole_bake_is_right_or_gets_more_for_this_view() {
        let baked = |flip| said(flip, subject(Stage::Baked, false));
        let (words, remedy) = baked(0.004);
        assert!(words.contains("no visible difference") && remedy.is_none(), "{words}");
        let (words, remedy) = baked(0.03);
        assert!(words.contains("small differences") && remedy == Some(Remedy::BakeForView), "{words}");
        assert!(baked(0.2).0.contains("large differences"));
        let opened = Subject { can_bake: false, ..subject(Stage::Baked, false) };
        assert_eq!(said(0.2, opened).1, None, "a dataset alone cannot be baked");
        let for_view = Subject { camera: None, ..subject(Stage::Baked, false) };
        assert_eq!(said(0.2, for_view).1, None, "it was baked for this view");
        let noisy = super::remedy(KindChoice::Paths, 0.2, !FINISHED, &subject(Stage::Baked, false));
        assert_eq!(noisy, None, "the noise is the reference's");
        assert_eq!(super::remedy(KindChoice::File, 0.2, FINISHED, &subject(Stage::Baked, false)), None);
    }

    #[test]
    fn unfinished_references_say_so_and_two_looks_need_no_bake() {
        let draft = subject(Stage::Moved, false);
        let words = sentence(KindChoice::Paths, 0.02, !FINISHED, &draft);
        assert!(words.contains("moved objects") && words.contains("so far"), "{words}");
        assert_eq!(sentence(KindChoice::Look, 0.02, FINISHED, &draft), "Two looks: small differences.");
        assert_eq!(remedy(KindChoice::Look, 0.2, FINISHED, &draft), None);
        assert!(said(0.2, subject(Stage::Unshadowed, false)).0.contains("preview"), "negative control");
    }
}
