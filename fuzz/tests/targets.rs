//! The targets as tests. `cargo bolero test` runs the same functions under a fuzzer that watches which code an input
//! reaches.

use lapidary_fuzz::{choices::Choices, targets};

/// Hands choices to the target of this name.
fn fuzz(name: &str, iterations: usize) {
    let all = targets::all();
    let target = all.iter().find(|target| target.name() == name).expect("a target of this name");
    let folder = tempfile::tempdir().expect("a temporary folder");
    target.prepare(folder.path()).expect("a writable folder");
    bolero::check!().with_iterations(iterations).with_max_len(160).for_each(|bytes: &[u8]| {
        target.write(&mut Choices::new(bytes), folder.path()).expect("a writable folder");
        if let Err(finding) = target.read(folder.path()) {
            panic!("{finding}");
        }
    });
}

macro_rules! targets {
    ($($name:ident $iterations:literal),*) => {
        $(#[test]
        fn $name() {
            fuzz(stringify!($name), $iterations);
        })*

        #[test]
        fn every_target_is_a_test() {
            let tests = [$(stringify!($name)),*];
            assert!(targets::all().iter().map(|target| target.name().to_owned()).eq(tests));
        }
    };
}

targets!(
    obj 200, mtl 200, gltf 200, glb 200, ply 200, png 200, jpg 200, tga 200, hdr 200, exr 200, lights 50, material 50,
    session 50, cuts 20, bake 5, checkpoint 5
);

/// A target that reads nothing right is found out.
#[test]
fn sound_inputs_are_read() {
    for target in targets::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        target.prepare(folder.path()).expect("a writable folder");
        target.write(&mut Choices::new(&[]), folder.path()).expect("a writable folder");
        assert_eq!(target.read(folder.path()), Ok(()), "{}", target.name());
    }
}
