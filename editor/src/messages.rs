//! Messages to the user: notes at the lower right that disappear after reading time, errors that stay until dismissed, and a log of
//! all with the time.

use crate::widgets::copyable;
use egui::{
    Align, Align2, Area, Button, Context, Frame, Id, Layout, Order, Rect, RichText, ScrollArea, Ui, Window, vec2,
};
use std::time::{Duration, Instant};

/// Messages shown at once; older ones are in the log.
const SHOWN: usize = 4;
/// Messages kept in the log.
const KEPT: usize = 2000;
/// Width of the text in points.
const WIDTH: f32 = 340.0;

/// How much a message matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Something was done.
    Note,
    /// Something was repaired or left out.
    Warning,
    /// Something could not be done.
    Error,
}

/// A message and when it came.
#[derive(Clone, Debug)]
pub struct Entry {
    /// How much it matters.
    pub severity: Severity,
    /// A sentence.
    pub text: String,
    /// When it first came.
    pub at: Instant,
    /// How often it came.
    pub times: usize,
    /// When it leaves the corner of the window; `None` once it is gone.
    shown_until: Option<Shown>,
}

#[derive(Clone, Copy, Debug)]
enum Shown {
    UntilDismissed,
    Until(Instant),
}

/// All messages of this run.
pub struct Messages {
    entries: Vec<Entry>,
    start: Instant,
    /// The temporary text of the status line, and when it ends.
    remark: Option<(String, Instant)>,
    /// Whether the log window is open.
    pub log_open: bool,
}

impl Default for Messages {
    fn default() -> Self {
        Self { entries: Vec::new(), start: Instant::now(), remark: None, log_open: false }
    }
}

impl Messages {
    /// Something was done.
    pub fn note(&mut self, text: impl Into<String>) {
        self.add(Severity::Note, text.into());
    }

    /// Something was repaired or left out.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.add(Severity::Warning, text.into());
    }

    /// Something could not be done.
    pub fn error(&mut self, text: impl Into<String>) {
        self.add(Severity::Error, text.into());
    }

    /// Shows a text in the status line only, for as long as it takes to read.
    pub fn remark(&mut self, text: impl Into<String>) {
        let text = text.into();
        let end = Instant::now() + reading_time(&text);
        self.remark = Some((text, end));
    }

    /// Removes a message that is no longer true; the log keeps it.
    pub fn withdraw(&mut self, text: &str) {
        for entry in self.entries.iter_mut().filter(|e| e.text == text) {
            entry.shown_until = None;
        }
    }

    /// Many warnings of one job: one message gives their number, the log has each.
    pub fn warnings(&mut self, of: &str, texts: &[String]) {
        match texts {
            [] => {}
            [text] => self.warning(text),
            [first, ..] => {
                for text in texts {
                    self.log_silently(text);
                }
                self.warning(format!("{of}: {} warnings, listed in Help > Messages. First: {first}", texts.len()));
            }
        }
    }

    /// Whether a message contains a text.
    #[cfg(test)]
    pub fn any_contains(&self, text: &str) -> bool {
        self.entries.iter().any(|e| e.text.contains(text))
    }

    /// The last temporary text, for the status line.
    pub fn last_remark(&self) -> Option<&str> {
        self.remark.as_ref().map(|(text, _)| text.as_str())
    }

    /// The newest message not yet read, or error not dismissed, for the status line.
    pub fn last(&self) -> Option<&Entry> {
        self.entries.iter().rev().find(|e| e.shown_until.is_some())
    }

    fn add(&mut self, severity: Severity, text: String) {
        let now = Instant::now();
        self.remark = None;
        let shown_until = Some(match severity {
            Severity::Error => Shown::UntilDismissed,
            _ => Shown::Until(now + reading_time(&text)),
        });
        let known = self.entries.iter().position(|e| e.text == text && e.severity == severity);
        let times = known.map_or(1, |i| self.entries.remove(i).times + 1);
        self.entries.push(Entry { severity, text, at: now, times, shown_until });
        if self.entries.len() > KEPT {
            self.entries.remove(0);
        }
    }

    fn log_silently(&mut self, text: &str) {
        if !self.entries.iter().any(|e| e.text == text) {
            let (text, at) = (text.to_owned(), Instant::now());
            self.entries.push(Entry { severity: Severity::Warning, text, at, times: 1, shown_until: None });
        }
    }

    /// Paints the messages in the lower right corner of the picture, where none covers a control, and the log if it is open.
    pub fn show(&mut self, ctx: &Context, picture: Rect) {
        self.expire(ctx);
        let shown: Vec<usize> = self.shown().collect();
        if !shown.is_empty() {
            Area::new(Id::unique("messages"))
                .order(Order::Foreground)
                .anchor(
                    Align2::RIGHT_BOTTOM,
                    picture.right_bottom() - ctx.content_rect().right_bottom() - vec2(12.0, 12.0),
                )
                .show(ctx, |ui| self.show_shown(ui, &shown));
        }
        if self.log_open {
            self.show_log(ctx);
        }
    }

    /// Indices of messages in the corner, the newest last.
    fn shown(&self) -> impl Iterator<Item = usize> + use<> {
        let all: Vec<usize> = (0..self.entries.len()).filter(|&i| self.entries[i].shown_until.is_some()).collect();
        let skipped = all.len().saturating_sub(SHOWN);
        all.into_iter().skip(skipped)
    }

    /// Removes messages after their reading time, and wakes the window for the next removal. The status line of this
    /// frame is painted already.
    fn expire(&mut self, ctx: &Context) {
        let now = Instant::now();
        let is_over = |end: Instant| {
            let left = end.saturating_duration_since(now);
            ctx.request_repaint_after(left);
            left.is_zero()
        };
        for entry in &mut self.entries {
            if let Some(Shown::Until(end)) = entry.shown_until
                && is_over(end)
            {
                entry.shown_until = None;
            }
        }
        self.remark.take_if(|(_, end)| is_over(*end));
    }

    fn show_shown(&mut self, ui: &mut Ui, shown: &[usize]) {
        ui.set_max_width(WIDTH + 60.0);
        for &i in shown {
            let entry = &mut self.entries[i];
            let response = toast(ui, entry);
            if response.dismissed {
                entry.shown_until = None;
            } else if response.hovered && matches!(entry.shown_until, Some(Shown::Until(_))) {
                // A message under the pointer is still being read.
                entry.shown_until = Some(Shown::Until(Instant::now() + reading_time(&entry.text)));
            }
        }
    }

    fn show_log(&mut self, ctx: &Context) {
        let mut open = true;
        Window::new("Messages").open(&mut open).default_size([560.0, 320.0]).show(ctx, |ui| {
            if self.entries.is_empty() {
                ui.weak("No messages yet.");
                return;
            }
            if ui.button("Copy all").clicked() {
                ui.ctx().copy_text(self.text());
            }
            ScrollArea::both().auto_shrink(false).stick_to_bottom(true).show(ui, |ui| {
                for entry in &self.entries {
                    log_line(ui, entry, entry.at - self.start);
                }
            });
        });
        self.log_open = open;
    }

    fn text(&self) -> String {
        let line = |e: &Entry| format!("{} {}: {}\n", clock(e.at - self.start), name(e.severity), e.text);
        self.entries.iter().map(line).collect()
    }
}

/// Two seconds to notice it, plus 17 letters a second, a slow reader's pace.
fn reading_time(text: &str) -> Duration {
    Duration::from_secs(2) + Duration::from_millis(60) * text.chars().count() as u32
}

struct ToastResponse {
    dismissed: bool,
    hovered: bool,
}

fn toast(ui: &mut Ui, entry: &Entry) -> ToastResponse {
    let frame = Frame::popup(ui.style()).inner_margin(8);
    let inner = frame.show(ui, |ui| {
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            let close = ui.add(Button::new("\u{00d7}").frame(false).small());
            let close = close.on_hover_text("Dismiss").accessible_name("Dismiss message");
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                ui.set_max_width(WIDTH);
                if entry.severity != Severity::Note {
                    ui.label(RichText::new(name(entry.severity)).color(color(ui, entry.severity)).strong());
                }
                copyable(ui, &entry.text);
            });
            close.clicked()
        })
        .inner
    });
    ToastResponse { dismissed: inner.inner, hovered: inner.response.contains_pointer() }
}

fn log_line(ui: &mut Ui, entry: &Entry, since_start: Duration) {
    ui.horizontal_top(|ui| {
        ui.label(RichText::new(clock(since_start)).monospace().weak()).on_hover_text("Time since the program started");
        let times = if entry.times > 1 { format!(" ({} times)", entry.times) } else { String::new() };
        let text = RichText::new(format!("{}{times}", entry.text));
        copyable(ui, if entry.severity == Severity::Note { text } else { text.color(color(ui, entry.severity)) });
    });
}

fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    format!("{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

fn name(severity: Severity) -> &'static str {
    match severity {
        Severity::Note => "Note",
        Severity::Warning => "Warning",
        Severity::Error => "Error",
    }
}

/// The color of a severity in the theme.
pub fn color(ui: &Ui, severity: Severity) -> egui::Color32 {
    match severity {
        Severity::Note => ui.visuals().text_color(),
        Severity::Warning => ui.visuals().warn_fg_color,
        Severity::Error => ui.visuals().error_fg_color,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::{Harness, kittest::Queryable};

    fn harness(messages: Messages) -> Harness<'static, Messages> {
        Harness::new_ui_state(|ui, messages: &mut Messages| messages.show(ui.ctx(), ui.ctx().content_rect()), messages)
    }

    #[test]
    fn errors_stay_until_they_are_dismissed_and_the_log_keeps_them() {
        let mut messages = Messages { log_open: true, ..Messages::default() };
        messages.error("no such file");
        let mut harness = harness(messages);
        harness.run_steps(3);
        harness.get_by_label("Dismiss message").click();
        harness.run_steps(3);
        assert!(harness.query_by_label("Dismiss message").is_none());
        assert!(harness.query_by_label("no such file").is_some(), "the log has it");
    }

    #[test]
    fn notes_go_when_they_were_read() {
        let mut messages = Messages::default();
        messages.note("saved");
        messages.entries[0].shown_until = Some(Shown::Until(Instant::now()));
        messages.warning("fresh");
        messages.expire(&Context::default());
        let shown: Vec<_> = messages.shown().map(|i| messages.entries[i].text.clone()).collect();
        assert_eq!(shown, ["fresh"]);
        assert_eq!(messages.entries.len(), 2);
    }

    #[test]
    fn the_status_line_says_what_is_new_and_what_is_still_wrong() {
        let mut messages = Messages::default();
        let last = |messages: &Messages| messages.last().map(|e| e.text.clone());
        messages.error("no such file");
        messages.remark("undone");
        assert_eq!(messages.last_remark(), Some("undone"));
        messages.note("a bake is under way");
        assert_eq!((messages.last_remark(), last(&messages).as_deref()), (None, Some("a bake is under way")));
        messages.withdraw("a bake is under way");
        assert_eq!(last(&messages).as_deref(), Some("no such file"), "errors stay until they are dismissed");
        messages.entries[0].shown_until = None;
        assert!(last(&messages).is_none() && messages.entries.len() == 2);
        messages.remark("undone");
        messages.remark = messages.remark.map(|(text, _)| (text, Instant::now()));
        messages.expire(&Context::default());
        assert!(messages.last_remark().is_none());
    }

    #[test]
    fn what_is_said_again_is_counted_and_many_warnings_are_one_message() {
        let mut messages = Messages::default();
        messages.warning("thin");
        messages.warning("thin");
        assert_eq!((messages.entries.len(), messages.entries[0].times), (1, 2));
        messages.warnings("Import", &["a".into(), "b".into(), "a".into()]);
        let texts: Vec<_> = messages.entries.iter().map(|e| e.text.as_str()).collect();
        assert_eq!(texts.len(), 4, "{texts:?}");
        assert!(texts[3].starts_with("Import: 3 warnings"));
        assert_eq!(messages.shown().count(), 2);
        messages.warnings("Bake", &[]);
        assert_eq!(messages.entries.len(), 4);
    }

    #[test]
    fn longer_messages_stay_longer() {
        assert!(reading_time(&"long ".repeat(40)) > 4 * reading_time("short") / 2);
        assert_eq!(clock(Duration::from_secs(3725)), "1:02:05");
    }
}
