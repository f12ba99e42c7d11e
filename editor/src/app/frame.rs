//! A frame of the window: results of jobs, the interface, and its requests. It also runs without a window, in tests.

use super::{dismissal, keys, layout, prompts, state::EditorState, theme};
use crate::{
    actions::Action,
    typing::{escape_is_taken, keys_are_commands, take_escape},
    viewport,
};
use egui::{Event, Key, Ui, ViewportCommand};
use std::sync::PoisonError;

impl EditorState {
    /// One frame: results of jobs, the interface, its requests, and the next request to the render thread.
    pub fn frame(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if self.interface.themed.as_ref() != Some(&self.work.preferences) {
            theme::apply(&ctx, &self.work.preferences);
            self.interface.themed = Some(self.work.preferences.clone());
        }
        self.note_window_size(&ctx);
        self.collect(&ctx);
        self.work.bounds.update(self.pose.posed(&self.work, &ctx).as_ref(), self.work.selection.objects());
        self.take_pasted_camera(&ctx);
        let mut actions = Vec::new();
        let escape_is_taken = escape_is_taken(&ctx);
        let laid = layout::show(ui, self, &mut actions);
        self.take_drops(&ctx, &laid, &mut actions);
        self.show_dialog(&ctx, &mut actions);
        self.looks.collect(&ctx, &self.work.document, self.work.scene.rendered());
        self.ladder.collect(&ctx);
        self.hold_for_ladder();
        self.ladder.show(&ctx, &self.work, &mut actions);
        self.explain.show(&ctx, &self.work, &self.picture, &self.comparison.panel);
        prompts::show(&ctx, self, &mut actions);
        if !self.dialogs.is_open() && self.exporting.dialog.is_some() {
            let (exported, pixel_secs) = (self.exported(), self.picture.pixel_secs());
            self.exporting.show_dialog(&ctx, &self.work, exported, pixel_secs, &mut actions);
        }
        if !self.dialogs.is_open() && self.exporting.pictures.is_some() {
            let (shown, pixel_secs) = (self.shown_document(self.work.viewport_size), self.picture.pixel_secs());
            self.exporting.show_pictures_dialog(&ctx, &self.work, shown, pixel_secs, &mut actions);
        }
        self.work.messages.show(&ctx, laid.viewport.rect);
        self.ask_before_closing(&ctx, &mut actions);
        if !actions.is_empty() {
            // The screen shows the state before the actions.
            ctx.request_repaint();
        }
        for action in actions {
            self.perform(&ctx, action);
        }
        if escape_is_taken {
            take_escape(&ctx);
        }
        self.take_keys(&ctx);
        dismissal::shield(&ctx, laid.menus);
        self.environments.load(&self.work, &mut self.loader);
        self.pose.play(&mut self.work, &ctx);
        self.request_picture(&ctx, laid.viewport);
        self.comparison.follow(&self.work, &self.picture);
        self.safe.keep(&mut self.work, &ctx);
    }

    /// While the ladder runs, comparison and full picture leave it the cores: the user waits for it, and it measures times.
    pub(super) fn hold_for_ladder(&self) {
        let climbing = self.ladder.is_climbing();
        self.picture.render.hold(climbing);
        self.comparison.hold(climbing);
    }

    /// Performs the commands of keys that are not for a text field, one by one, so that two presses in one frame are two steps.
    fn take_keys(&mut self, ctx: &egui::Context) {
        let are_commands = keys_are_commands(ctx) && !self.is_asking();
        self.flicker(ctx, are_commands);
        if !are_commands {
            return;
        }
        let mut actions = Vec::new();
        if self.work.scene.rendered().is_some() {
            viewport::turn_environment(ctx, &self.work.document, &mut actions);
        }
        let commands = keys::pressed(ctx);
        if !commands.is_empty() || !actions.is_empty() {
            ctx.request_repaint();
        }
        actions.into_iter().for_each(|action| self.perform(ctx, action));
        for command in commands {
            let mut actions = Vec::new();
            self.command(command, &mut actions);
            actions.into_iter().for_each(|action| self.perform(ctx, action));
        }
    }

    /// Whether a dialog or a question is open, or opens in the next frame.
    fn is_asking(&self) -> bool {
        let has_dialog = self.dialogs.is_open() || self.exporting.is_asking();
        has_dialog || self.interface.keys_open || !self.questions.waiting.is_empty()
    }

    /// Shows the reference while R is held, if the press was for that. The press is then no command.
    fn flicker(&mut self, ctx: &egui::Context, are_commands: bool) {
        let is_press = |event: &Event| matches!(event, Event::Key { key: Key::R, pressed: true, modifiers, .. } if modifiers.is_none());
        let (is_held, is_pressed) = ctx.input(|i| (i.key_down(Key::R), i.events.iter().any(is_press)));
        let panel = &mut self.comparison.panel;
        let flickers = panel.open && is_held && (panel.flicker || is_pressed && are_commands);
        if panel.open && are_commands {
            ctx.input_mut(|i| i.events.retain(|event| !is_press(event)));
        }
        if flickers != panel.flicker {
            panel.flicker = flickers;
            ctx.request_repaint();
        }
    }

    /// Remembers how large the window is, for the next start.
    fn note_window_size(&mut self, ctx: &egui::Context) {
        let scale = self.work.preferences.ui_scale;
        self.interface.window_size = ctx.input(|i| {
            let window = i.viewport();
            let fills = window.maximized == Some(true) || window.fullscreen == Some(true);
            // The interface's points are larger than the window's by its scale.
            window.inner_rect.filter(|_| !fills).map(|rect| [rect.width() * scale, rect.height() * scale])
        });
    }

    /// Shows the file dialog, if one is open. Canceling a save dialog also cancels the action after it.
    fn show_dialog(&mut self, ctx: &egui::Context, actions: &mut Vec<Action>) {
        let was_open = self.dialogs.is_open();
        let chosen = self.dialogs.show(ctx);
        if was_open && !self.dialogs.is_open() && chosen.is_empty() {
            self.questions.after_save = None;
        }
        if let Some((files, folder)) = self.dialogs.left() {
            let mut preferences = self.work.preferences.clone();
            preferences.folders.remember(files, &folder);
            actions.push(Action::prefer(preferences));
        }
        actions.extend(chosen);
    }

    /// Takes the requested clipboard text, which arrives a frame later, or never if there is none.
    fn take_pasted_camera(&mut self, ctx: &egui::Context) {
        if self.interface.pasting_camera == 0 {
            return;
        }
        self.interface.pasting_camera -= 1;
        let pasted = ctx.input_mut(|i| {
            let place = i.events.iter().position(|e| matches!(e, Event::Paste(_)))?;
            Some(i.events.remove(place))
        });
        if let Some(Event::Paste(text)) = pasted {
            self.interface.pasting_camera = 0;
            self.paste_camera(&text);
        }
    }

    /// Takes results of jobs since the last frame.
    fn collect(&mut self, ctx: &egui::Context) {
        self.collect_opened();
        self.collect_loaded();
        let is_disturbed = self.picture.render.works() || self.exporting.is_running();
        self.baking.collect(&mut self.work, is_disturbed);
        self.baking.follow_ground(&mut self.work);
        self.picture.backplate.follow(&mut self.work, ctx);
        self.picture.collect(&mut self.work, ctx);
        self.comparison.collect(&mut self.work, ctx);
        self.exporting.collect(&mut self.work);
        self.collect_changed_files();
        self.environments.collect(ctx);
    }

    /// Asks about changes before the window closes.
    fn ask_before_closing(&mut self, ctx: &egui::Context, actions: &mut Vec<Action>) {
        if ctx.input(|i| i.viewport().close_requested()) && !self.questions.may_close {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            actions.push(Action::Quit);
        }
    }

    /// The window closes with nothing left to lose.
    pub fn finish(&mut self) {
        self.safe.forget_autosave(&mut self.work);
        if let Some(size) = self.interface.window_size {
            self.work.preferences.window_size = size;
        }
        self.work.preferences.gpu_path = self.memory.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Err(error) = self.work.preferences.save(&self.work.folders.config) {
            eprintln!("warning: {error:#}");
        }
    }
}
