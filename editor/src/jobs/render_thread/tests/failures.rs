//! Lost devices, panics and refused scenes.

use super::*;

/// Waits for a remark, and the picture after it.
fn remark(thread: &mut RenderThread) -> (String, RenderedFrame) {
    let remark = |event| if let RenderEvent::Remark(text) = event { Some(text) } else { None };
    let text = wait_for("a remark", || thread.events().into_iter().find_map(remark));
    (text, complete(thread))
}

#[test]
fn a_lost_device_is_made_again_three_times_and_then_the_cpu_goes_on() {
    let (log, mut thread) = start(Log { losses: 1, ..Log::default() });
    thread.request(request(1));
    let (text, frame) = remark(&mut thread);
    assert!(text.contains("unplugged") && frame.backend == "fake", "{text}");
    let made = |log: &Shared| log.lock().unwrap().made;
    assert_eq!(made(&log), 2);
    log.lock().unwrap().losses = 100;
    thread.request(request(2));
    thread.read_picture(7);
    let mut events = Vec::new();
    wait_for("the answer", || {
        events.extend(thread.events());
        events.iter().any(|event| matches!(event, RenderEvent::Picture { id: 7, result: Ok(_) })).then_some(())
    });
    let says_so =
        |event: &RenderEvent| matches!(event, RenderEvent::Remark(text) if text.contains("in place of \"fake\""));
    assert_eq!(events.iter().filter(|event| says_so(event)).count(), 1);
    assert!(!events.iter().any(|event| matches!(event, RenderEvent::Failed(_))), "nothing is lost");
    assert_eq!(complete(&mut thread).backend, "cpu");
    assert_eq!(made(&log), 4, "three restarts in all");
}

#[test]
fn shaders_that_do_not_compile_leave_the_picture_to_the_cpu_until_they_are_read_again() {
    let (log, mut thread) = start(Log { error: Some("no such function".into()), ..Log::default() });
    thread.request(request(1));
    let (text, frame) = remark(&mut thread);
    assert!(text.contains("\"fake\"") && text.contains("no such function"), "{text}");
    assert_eq!(frame.backend, "cpu");
    log.lock().unwrap().error = None;
    thread.request(request(2));
    assert_eq!(complete(&mut thread).backend, "cpu");
    thread.reload();
    assert_eq!(complete(&mut thread).backend, "fake");
}

#[test]
fn while_shaders_are_compiled_the_last_picture_stays_and_requests_are_taken() {
    let (log, mut thread) = start(Log::default());
    thread.request(request(1));
    complete(&mut thread);
    log.lock().unwrap().compiles = true;
    let mut edited = request(1);
    edited.look.view.camera.eye.x = 3.0;
    thread.request(edited.clone());
    wait_for("the line that says so", || thread.compiles().then_some(()));
    let before = work(&log);
    for x in [4.0, 5.0] {
        edited.look.view.camera.eye.x = x;
        thread.request(edited.clone());
        std::thread::sleep(Duration::from_millis(20));
        assert!(thread.compiles(), "newer requests wait as long");
    }
    linger();
    assert!(thread.frames().is_none(), "the last picture stays");
    assert_eq!(work(&log), before);
    {
        let mut log = log.lock().unwrap();
        (log.compiles, log.micros_per_pixel) = (false, 1000);
    }
    wait_for("the end of the line", || (!thread.compiles()).then_some(()));
    assert!(thread.frames().is_none(), "it ends before the picture is there");
    log.lock().unwrap().micros_per_pixel = 0;
    assert_eq!(complete(&mut thread).pixels[0][0], 5, "the newest request");
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
fn a_scene_that_the_adapter_has_no_room_for_is_rendered_by_the_cpu() {
    let (log, mut thread) = start(Log { refuse_scenes: true, ..Log::default() });
    let mut edited = request(1);
    thread.request(edited.clone());
    let (text, frame) = remark(&mut thread);
    assert!(text.contains("need 2 bytes") && text.contains("allows 1"), "{text}");
    assert_eq!(frame.backend, "cpu");
    log.lock().unwrap().refuse_scenes = false;
    edited.look.view.camera.eye.x = 4.0;
    thread.request(edited.clone());
    assert_eq!(complete(&mut thread).backend, "cpu", "the same scene");
    edited.baked = Some(dataset().into());
    thread.request(edited);
    assert_eq!(complete(&mut thread).backend, "fake", "another bake of it");
    let says_so = |event: &RenderEvent| matches!(event, RenderEvent::Remark(text) if text.contains("in place of"));
    assert!(!thread.events().iter().any(says_so), "it is told once");
}

#[test]
fn what_the_cpu_cannot_do_either_is_reported_once() {
    let log: Shared = Arc::default();
    let factory = move || -> Result<Box<dyn Backend>, BackendError> {
        log.lock().unwrap().made += 1;
        Err(BackendError::NoAdapter { reason: "none is there".into() })
    };
    let mut thread = RenderThread::start(Arc::new(factory), silent());
    let mut refused = request(1);
    thread.request(refused.clone());
    assert!(failure(&mut thread).contains("none is there"));
    refused.look.view.camera.eye.x = 4.0;
    thread.request(refused);
    linger();
    assert!(thread.events().is_empty() && thread.frames().is_none());
}
