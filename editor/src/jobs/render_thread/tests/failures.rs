//! Lost devices, panics and refused scenes.

use super::*;

#[test]
fn a_lost_device_is_made_again_three_times_and_then_reported() {
    let (log, mut thread) = start(Log { losses: 1, ..Log::default() });
    thread.request(request(1));
    complete(&mut thread);
    let made = |log: &Shared| log.lock().unwrap().made;
    assert_eq!(made(&log), 2);
    assert!(matches!(&thread.events()[..], [RenderEvent::Remark(text)] if text.contains("unplugged")));
    log.lock().unwrap().losses = 100;
    thread.request(request(2));
    let text = failure(&mut thread);
    assert!(text.contains("3 times") && text.contains("unplugged"), "{text}");
    assert_eq!(made(&log), 4, "three restarts in all");
}

#[test]
fn a_panic_is_reported_and_the_next_change_starts_anew() {
    let (log, mut thread) = start(Log { panics: 1, ..Log::default() });
    thread.request(request(1));
    thread.read_picture(3);
    assert!(failure(&mut thread).contains("a bug"));
    thread.request(request(2));
    complete(&mut thread);
    assert_eq!(log.lock().unwrap().made, 2);
}

#[test]
fn a_refused_scene_is_reported_once() {
    let (log, mut thread) = start(Log { refuse_scenes: true, ..Log::default() });
    let mut refused = request(1);
    thread.request(refused.clone());
    assert!(failure(&mut thread).contains("too large"));
    refused.look.view.camera.eye.x = 4.0;
    thread.request(refused.clone());
    linger();
    assert!(thread.events().is_empty() && thread.frames().is_none());
    log.lock().unwrap().refuse_scenes = false;
    refused.look.view.camera.eye.x = 5.0;
    thread.request(refused);
    complete(&mut thread);
}
