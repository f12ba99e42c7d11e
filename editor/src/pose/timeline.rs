//! The timeline: the clip of the scene file, and its time.

use crate::actions::{Action, PoseAction};
use egui::{Button, ComboBox, DragValue, Label, RichText, Slider, Ui};
use lapidary_core::animation::{Clip, ClipTime, Playback};

/// Default frames a second, as in film.
const FILM: f32 = 24.0;

/// How clips play.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timeline {
    /// Whether it plays.
    pub playing: bool,
    /// Whether a clip restarts at its end.
    pub looping: bool,
    /// Length of a step, in frames a second.
    pub frames_per_second: f32,
}

impl Default for Timeline {
    fn default() -> Self {
        Self { playing: false, looping: true, frames_per_second: FILM }
    }
}

impl Timeline {
    /// Plays, or stops. A clip that does not loop restarts if it is at its end.
    pub fn toggle(&mut self, time: &mut Option<ClipTime>, clips: &[Clip]) {
        self.playing = !self.playing;
        let is_over = |time: &ClipTime| clip_of(time, clips).is_some_and(|clip| time.seconds >= clip.seconds());
        if let Some(time) = time.as_mut().filter(|time| self.playing && !self.looping && is_over(time)) {
            time.seconds = 0.0;
        }
    }

    /// Lets `passed` seconds go by; at rest the first clip begins. Returns whether the end was reached.
    pub fn advance(&self, time: &mut Option<ClipTime>, clips: &[Clip], passed: f32) -> bool {
        let before = time.take().filter(|time| clip_of(time, clips).is_some());
        let Some(before) = before.or_else(|| beginning(clips)) else { return true };
        let clip = clip_of(&before, clips);
        let (wanted, mode) = (before.seconds + passed, if self.looping { Playback::Loop } else { Playback::Once });
        let seconds = clip.map_or(0.0, |clip| clip.time_at(wanted, mode));
        *time = Some(ClipTime { seconds, ..before });
        !self.looping && seconds < wanted
    }

    /// The time `frames` frames later, on whole frames.
    fn stepped(&self, time: &ClipTime, clip: &Clip, frames: f32) -> ClipTime {
        let frame = (time.seconds * self.frames_per_second).round() + frames;
        let mode = if self.looping { Playback::Loop } else { Playback::Once };
        ClipTime { seconds: clip.time_at(frame / self.frames_per_second, mode), ..time.clone() }
    }
}

fn clip_of<'a>(time: &ClipTime, clips: &'a [Clip]) -> Option<&'a Clip> {
    clips.iter().find(|clip| clip.name == time.clip)
}

/// The beginning of the first clip.
fn beginning(clips: &[Clip]) -> Option<ClipTime> {
    clips.first().map(|clip| ClipTime { clip: clip.name.clone(), seconds: 0.0 })
}

/// Input of the timeline.
pub struct TimelineContext<'a> {
    /// The clips; at least one.
    pub clips: &'a [Clip],
    /// The shown time; `None` at rest.
    pub time: Option<&'a ClipTime>,
    /// Why the time cannot be shown, in words.
    pub trouble: Option<String>,
}

/// Shows the timeline. Returns whether its position is dragged.
pub fn show(ui: &mut Ui, timeline: &mut Timeline, context: &TimelineContext, actions: &mut Vec<Action>) -> bool {
    let is_scrubbing = ui.horizontal(|ui| show_controls(ui, timeline, context, actions)).inner;
    if let Some(trouble) = &context.trouble {
        let text = RichText::new(trouble).color(ui.visuals().warn_fg_color);
        ui.add(Label::new(text).wrap());
    }
    is_scrubbing
}

fn show_controls(ui: &mut Ui, timeline: &mut Timeline, context: &TimelineContext, actions: &mut Vec<Action>) -> bool {
    choose_clip(ui, context, actions);
    let shown = context.time.cloned().or_else(|| beginning(context.clips)).unwrap_or_default();
    let Some(clip) = clip_of(&shown, context.clips) else { return false };
    transport(ui, timeline, &shown, clip, actions);
    let is_scrubbing = scrub(ui, &shown, clip, actions);
    ui.checkbox(&mut timeline.looping, "Loop");
    let rate = DragValue::new(&mut timeline.frames_per_second).range(1.0..=240.0).max_decimals(2).suffix(" fps");
    ui.add(rate).on_hover_text("Frames per second, for stepping");
    is_scrubbing
}

fn choose_clip(ui: &mut Ui, context: &TimelineContext, actions: &mut Vec<Action>) {
    let shown = context.time.map_or("At rest", |time| &time.clip);
    ComboBox::from_id_salt("clip").selected_text(shown).show_ui(ui, |ui| {
        if ui.selectable_label(context.time.is_none(), "At rest").clicked() {
            actions.push(Action::Pose(PoseAction::ClipTime(None)));
        }
        for clip in context.clips {
            if ui.selectable_label(context.time.is_some_and(|time| time.clip == clip.name), &clip.name).clicked() {
                actions
                    .push(Action::Pose(PoseAction::ClipTime(Some(ClipTime { clip: clip.name.clone(), seconds: 0.0 }))));
            }
        }
    });
}

/// Buttons to begin, step and play.
fn transport(ui: &mut Ui, timeline: &Timeline, shown: &ClipTime, clip: &Clip, actions: &mut Vec<Action>) {
    let mut go = |ui: &mut Ui, label: &str, help: &str, time: ClipTime| {
        if ui.add(Button::new(label)).on_hover_text(help).clicked() {
            actions.push(Action::Pose(PoseAction::ClipTime(Some(time))));
        }
    };
    go(ui, "|<", "Go to the start", ClipTime { seconds: 0.0, ..shown.clone() });
    go(ui, "<", "Step back one frame", timeline.stepped(shown, clip, -1.0));
    go(ui, ">", "Step forward one frame", timeline.stepped(shown, clip, 1.0));
    let label = if timeline.playing { "Stop" } else { "Play" };
    if ui.button(label).on_hover_text("Play or stop the clip (Space)").clicked() {
        actions.push(Action::Pose(PoseAction::Play));
    }
}

/// The position in the clip. Returns whether it is dragged.
fn scrub(ui: &mut Ui, shown: &ClipTime, clip: &Clip, actions: &mut Vec<Action>) -> bool {
    let (mut seconds, length) = (shown.seconds, clip.seconds());
    ui.spacing_mut().slider_width = (ui.available_width() - 320.0).max(80.0);
    let slider = Slider::new(&mut seconds, 0.0..=length.max(f32::MIN_POSITIVE)).fixed_decimals(2).suffix(" s");
    let response = ui.add_enabled(length > 0.0, slider).accessible_name("Clip position");
    if response.changed() {
        actions.push(Action::Pose(PoseAction::ClipTime(Some(ClipTime { seconds, ..shown.clone() }))));
    }
    ui.label(format!("of {length:.2} s"));
    response.dragged()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_interchange::{animation, import::ImportOptions};
    use std::path::Path;

    #[test]
    fn time_goes_on_begins_anew_or_ends_and_steps_are_whole_frames() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/bending-tower/bending-tower.gltf");
        let animation = animation::read(&path, &ImportOptions::default()).unwrap();
        let clips = &animation.clips;
        let at = |seconds: f32| ClipTime { clip: clips[0].name.clone(), seconds };
        let passed = |timeline: Timeline, before: Option<ClipTime>, seconds: f32| {
            let mut time = before;
            let stopped = timeline.advance(&mut time, clips, seconds);
            (time.unwrap().seconds, stopped)
        };
        let (looping, once) = (Timeline::default(), Timeline { looping: false, ..Timeline::default() });
        assert_eq!(clips[0].seconds(), 2.0);
        assert_eq!(passed(looping, None, 0.5), (0.5, false), "from rest");
        assert_eq!(passed(looping, Some(at(1.75)), 0.5), (0.25, false));
        assert_eq!(passed(once, Some(at(1.75)), 0.5), (2.0, true));
        assert_eq!(passed(once, Some(at(1.0)), 0.5), (1.5, false), "negative control");
        let begun = |timeline: Timeline, seconds: f32| {
            let (mut timeline, mut time) = (timeline, Some(at(seconds)));
            timeline.toggle(&mut time, clips);
            (timeline.playing, time.unwrap().seconds)
        };
        assert_eq!([begun(once, 2.0), begun(once, 1.5)], [(true, 0.0), (true, 1.5)], "at its end it begins anew");
        assert_eq!(begun(looping, 2.0), (true, 2.0));
        assert_eq!(begun(Timeline { playing: true, ..once }, 2.0), (false, 2.0), "stopped");
        let gone = ClipTime { clip: "gone".into(), seconds: 1.0 };
        assert_eq!(passed(looping, Some(gone), 0.5), (0.5, false), "of another file");
        assert_eq!(looping.stepped(&at(0.51), &clips[0], 1.0).seconds, 13.0 / 24.0);
        assert_eq!(looping.stepped(&at(0.0), &clips[0], -1.0).seconds, 47.0 / 24.0);
        assert_eq!(once.stepped(&at(0.0), &clips[0], -1.0).seconds, 0.0);
    }
}
