//! Asks questions: unsaved changes, recovered work, missing files of a session, and files outside the folder of a scene or
//! material.

use super::state::{
    EditorState,
    prompt::{Again, Prompt},
};
use crate::{
    actions::{Action, FileAction},
    document::{autosave::Recovery, session::LoadedSession},
    jobs::opening::Target,
    materials,
    widgets::copyable,
};
use egui::{Button, Context, Modal, RichText, ScrollArea, Ui};
use std::{path::Path, time::SystemTime};

/// The answer.
enum Answer {
    Save,
    Discard,
    Cancel,
    Recover(usize),
    DiscardAll,
    Look,
    OpenWithout,
    ReadOutside,
    Choose(usize),
}

/// Shows the waiting question, if any, and acts on its answer.
pub fn show(ctx: &Context, state: &mut EditorState, actions: &mut Vec<Action>) {
    let Some(prompt) = state.questions.waiting.front() else { return };
    if state.dialogs.is_open() {
        return;
    }
    let title = state.work.title();
    let modal = Modal::new(egui::Id::unique("prompt")).show(ctx, |ui| {
        ui.set_max_width(440.0);
        match prompt {
            Prompt::Unsaved { .. } => unsaved(ui, &title),
            Prompt::Recover(found) => recover(ui, found),
            Prompt::Missing { loaded, .. } => missing(ui, loaded),
            Prompt::Outside { file, names, then } => outside(ui, file, names, then),
            Prompt::Several { file, names, .. } => several(ui, file, names),
            Prompt::About => about(ui),
        }
    });
    let closed = modal.should_close().then_some(Answer::Cancel);
    if let Some(answer) = modal.inner.or(closed) {
        take(ctx, state, answer, actions);
    }
}

fn unsaved(ui: &mut Ui, title: &str) -> Option<Answer> {
    ui.heading("Save the changes?");
    ui.add_space(4.0);
    ui.label(format!("{title} has unsaved changes. They are lost if you discard them."));
    buttons(ui, [("Save", Answer::Save), ("Discard", Answer::Discard), ("Cancel", Answer::Cancel)])
}

fn recover(ui: &mut Ui, found: &[Recovery]) -> Option<Answer> {
    ui.heading("Recover unsaved work?");
    ui.add_space(4.0);
    ui.label("Lapidary closed before these were saved:");
    let mut answer = None;
    for (i, recovery) in found.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.button("Recover").clicked() {
                answer = Some(Answer::Recover(i));
            }
            let name =
                recovery.session_path.as_ref().map_or_else(|| never_saved(recovery), |p| p.display().to_string());
            ui.label(name);
            ui.weak(age(recovery.saved_at));
        });
    }
    answer.or(buttons(ui, [("Discard all", Answer::DiscardAll), ("Ask again next time", Answer::Cancel)]))
}

/// Names a document without a session by its scene.
fn never_saved(recovery: &Recovery) -> String {
    let name = recovery.subject.as_deref().and_then(Path::file_name);
    name.map_or("never saved".into(), |name| format!("{}, never saved", name.to_string_lossy()))
}

fn missing(ui: &mut Ui, loaded: &LoadedSession) -> Option<Answer> {
    ui.heading("Files are missing");
    ui.add_space(4.0);
    ui.label("Some files of the session were not found. They may have moved.");
    ScrollArea::vertical().max_height(160.0).show(ui, |ui| {
        for file in &loaded.missing {
            ui.horizontal_wrapped(|ui| {
                ui.label(file.what);
                copyable(ui, RichText::new(file.path.display().to_string()).weak());
            });
        }
    });
    let answers =
        [("Search a folder...", Answer::Look), ("Open without them", Answer::OpenWithout), ("Cancel", Answer::Cancel)];
    buttons(ui, answers)
}

fn outside(ui: &mut Ui, file: &Path, names: &[String], then: &Again) -> Option<Answer> {
    ui.heading("Read files outside the folder?");
    ui.add_space(4.0);
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    ui.label(format!(
        "{name} names files outside its folder. Their contents become part of the dataset. Read them only if you trust \
         {name}; its folder is remembered."
    ));
    ScrollArea::vertical().max_height(160.0).show(ui, |ui| {
        for name in names {
            copyable(ui, RichText::new(name).weak());
        }
    });
    match then {
        Again::Open(_) => buttons(
            ui,
            [
                ("Read them", Answer::ReadOutside),
                ("Open without them", Answer::OpenWithout),
                ("Cancel", Answer::Cancel),
            ],
        ),
        Again::Load(_) => buttons(ui, [("Read them", Answer::ReadOutside), ("Cancel", Answer::Cancel)]),
    }
}

fn several(ui: &mut Ui, file: &Path, names: &[String]) -> Option<Answer> {
    ui.heading("Which material?");
    ui.add_space(4.0);
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    ui.label(format!("{name} has {} materials.", names.len()));
    let chosen = ScrollArea::vertical().max_height(240.0).show(ui, |ui| {
        let clicked = names.iter().map(|name| ui.selectable_label(false, name).clicked()).collect::<Vec<_>>();
        clicked.into_iter().position(|is_clicked| is_clicked)
    });
    chosen.inner.map(Answer::Choose).or(buttons(ui, [("Cancel", Answer::Cancel)]))
}

fn about(ui: &mut Ui) -> Option<Answer> {
    ui.heading(concat!("Lapidary ", env!("CARGO_PKG_VERSION")));
    ui.add_space(4.0);
    ui.label("Look-dev with noise-free all-frequency light: bake visibility once, then edit materials and light.");
    ui.add_space(4.0);
    ui.label(
        "Based on Cheslack-Postava, Wang, Akerlund and Pellacini: Fast, Realistic Lighting and Material Design using \
         Nonlinear Cut Approximation, SIGGRAPH Asia 2008.",
    );
    buttons(ui, [("Close", Answer::Cancel)])
}

fn buttons<const N: usize>(ui: &mut Ui, answers: [(&str, Answer); N]) -> Option<Answer> {
    ui.add_space(10.0);
    let mut chosen = None;
    ui.horizontal(|ui| {
        for (text, answer) in answers {
            if ui.add(Button::new(text).min_size([84.0, 24.0].into())).clicked() {
                chosen = Some(answer);
            }
        }
    });
    chosen
}

fn age(time: SystemTime) -> String {
    let minutes = time.elapsed().unwrap_or_default().as_secs() / 60;
    match minutes {
        0 => "just now".into(),
        1..=119 => format!("{minutes} min ago"),
        120..=2879 => format!("{} hours ago", minutes / 60),
        _ => format!("{} days ago", minutes / 1440),
    }
}

fn take(ctx: &Context, state: &mut EditorState, answer: Answer, actions: &mut Vec<Action>) {
    // Looking for files keeps the question open.
    if matches!(answer, Answer::Look) {
        return actions.push(Action::File(FileAction::Relink(None)));
    }
    match (state.questions.waiting.pop_front(), answer) {
        (Some(Prompt::Unsaved { then }), Answer::Save) => {
            state.questions.after_save = Some(then);
            actions.push(Action::File(FileAction::Save));
        }
        (Some(Prompt::Unsaved { then }), Answer::Discard) => state.leave_now(ctx, then),
        (Some(Prompt::Recover(found)), Answer::DiscardAll) => discard(state, found),
        (Some(Prompt::Recover(mut found)), Answer::Recover(i)) => {
            state.open(Target::Recovered(found.swap_remove(i)));
        }
        (Some(Prompt::Missing { loaded, path, recovery }), Answer::OpenWithout) => {
            state.open(Target::Session { loaded, path, recovery, look_in: None });
        }
        (Some(Prompt::Outside { file, then, .. }), Answer::ReadOutside) => {
            let mut preferences = state.work.preferences.clone();
            preferences.outside.remember(&file);
            state.work.prefer(preferences);
            match then {
                Again::Open(target) => state.open(target),
                Again::Load(material) => materials::load(&state.work, &mut state.loader, material, file),
            }
        }
        (Some(Prompt::Several { file, names, material }), Answer::Choose(chosen)) => {
            let mut named = file.into_os_string();
            named.push(format!("#{}", names[chosen]));
            materials::load(&state.work, &mut state.loader, material, named.into());
        }
        (Some(Prompt::Outside { then: Again::Open(target), .. }), Answer::OpenWithout) => state.open_without(target),
        _ => {}
    }
}

fn discard(state: &mut EditorState, found: Vec<Recovery>) {
    for recovery in found {
        if let Err(error) = recovery.discard() {
            state.work.messages.warning(format!("Cannot remove an autosave: {error}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn ages_are_told_in_the_unit_that_fits() {
        let ago = |secs| age(SystemTime::now() - Duration::from_secs(secs));
        assert_eq!(
            [ago(5), ago(300), ago(3 * 3600), ago(3 * 86_400)],
            ["just now", "5 min ago", "3 hours ago", "3 days ago"]
        );
    }
}
