//! The targets as tests. `cargo bolero test` runs the same functions under a fuzzer that observes the code coverage.

use lapidary_fuzz::{choices::Choices, targets};
use std::panic::RefUnwindSafe;

/// Passes choices to the target of this name.
fn reader(name: &str) -> impl Fn(&[u8]) + RefUnwindSafe {
    let target = targets::all().into_iter().find(|target| target.name() == name).expect("a target of this name");
    let folder = tempfile::tempdir().expect("a temporary folder");
    target.prepare(folder.path()).expect("a writable folder");
    move |bytes| {
        target.write(&mut Choices::new(bytes), folder.path()).expect("a writable folder");
        if let Err(finding) = target.read(folder.path()) {
            panic!("{finding}");
        }
    }
}

macro_rules! targets {
    ($($name:ident $iterations:literal),*) => {
        // A fuzzer finds a target by the function that contains `check!`.
        $(#[test]
        fn $name() {
            let check = bolero::check!().with_iterations($iterations).with_max_len(160);
            check.for_each(reader(stringify!($name)));
        })*

        #[test]
        fn every_target_is_a_test() {
            let tests = [$(stringify!($name)),*];
            assert!(targets::all().iter().map(|target| target.name().to_owned()).eq(tests));
        }
    };
}

targets!(
    obj 200, mtl 200, gltf 200, glb 200, ply 200, png 200, jpg 200, tga 200, webp 200, tif 200, ktx2 200, hdr 200, exr 200, lights 50, material 50,
    materialx 100, wgsl 50, session 50, cuts 20, bake 5, checkpoint 5
);

/// Detects a target that reads nothing correctly.
#[test]
fn sound_inputs_are_read() {
    for target in targets::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        target.prepare(folder.path()).expect("a writable folder");
        target.write(&mut Choices::new(&[]), folder.path()).expect("a writable folder");
        assert_eq!(target.read(folder.path()), Ok(()), "{}", target.name());
    }
}

/// Targets behind several gates test little if most inputs are refused at the first.
#[test]
fn enough_inputs_get_to_the_end() {
    for (name, output, least) in [("bake", "input.cuts", 20), ("cuts", "input.copy.cuts", 6)] {
        let all = targets::all();
        let target = all.iter().find(|target| target.name() == name).expect("a target of this name");
        let folder = tempfile::tempdir().expect("a temporary folder");
        target.prepare(folder.path()).expect("a writable folder");
        let mut random = fastrand::Rng::with_seed(29);
        let mut is_whole = || {
            let bytes: Vec<u8> = (0..random.usize(8..160)).map(|_| random.u8(..)).collect();
            target.write(&mut Choices::new(&bytes), folder.path()).expect("a writable folder");
            target.read(folder.path()).expect("it is read or refused");
            std::fs::remove_file(folder.path().join(output)).is_ok()
        };
        let whole = (0..60).filter(|_| is_whole()).count();
        assert!(whole >= least, "{whole} of 60 inputs of {name} get to the end");
    }
}
