//! Wavelet transport from end to end: a room of quads with a glossy floor, against traced paths.

use crate::common::Folder;
use glam::Vec3;
use lapidary_core::wavelet::{
    operator::{Operator, TransportCoefficient},
    series::GlobalTransport,
};
use std::sync::Arc;

/// A room of two meters, open toward +Z, with a red wall and a floor of rough metal (GGX alpha 0.3).
const ROOM: &str = "mtllib room.mtl
v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1
o floor\nusemtl gloss\nf 4 3 2 1
o ceiling\nusemtl white\nf 5 6 7 8
o back\nf 1 2 6 5
o right\nf 2 3 7 6
o left\nusemtl red\nf 1 5 8 4\n";
const MATERIALS: &str = "newmtl gloss\nKd 0.85 0.82 0.75\nPr 0.55\nPm 1
newmtl white\nKd 0.7 0.7 0.7\nnewmtl red\nKd 0.63 0.06 0.05\n";
const LAMP: &str = r#"{"lights": [{"kind": "point", "position": [0.2, 1.5, 0.1], "intensity": [3, 3, 3]}]}"#;
const VIEW: &str = "--env none --lights lamp.json --eye 0,1,4.6 --target 0,0.9,0 --fov 36";

fn room() -> Folder {
    let folder = Folder::new();
    for (name, text) in [("room.obj", ROOM), ("room.mtl", MATERIALS), ("lamp.json", LAMP)] {
        folder.write(name, text.into());
    }
    folder
}

#[test]
fn gloss_sees_gloss_as_traced_paths_do() {
    let folder = room();
    let told =
        folder.succeed("bake room.obj -o room.cuts --mode wavelet --tau 1e-4 --max-vertices 300 --progress none");
    assert!(told.contains("wavelet transport between 5 quads"), "{told}");
    assert!(folder.succeed("info room.cuts").contains("on 5 quads"));
    folder.succeed("verify room.cuts");
    let picture = format!("{VIEW} --size 40x40 --aa 16");
    folder.succeed(&format!(
        "bounces room.cuts {picture} --solution wavelet --spp 1024 --no-samples --out truth --quiet"
    ));
    let row = folder.json("truth/bounces.json")["solutions"][0].clone();
    let [error, energy, with_noise] = ["error", "energy", "rel_rmse"].map(|name| row[name].as_f64().expect("a number"));
    assert!(error < 0.1 && (energy - 1.0).abs() < 0.05, "{error} {energy}");
    // Negative control: what is sent is received, and the other way.
    let mut turned = folder.dataset("room.cuts");
    let transport = Arc::make_mut(turned.wavelet.as_mut().expect("wavelet transport"));
    let functions = transport.basis.functions();
    let of_sender = |sender: usize| {
        let entries = transport.direct.column(sender).iter();
        entries.map(move |&(receiver, value)| TransportCoefficient {
            receiver: functions[sender],
            sender: functions[receiver as usize],
            value,
        })
    };
    let (basis, direct) = Operator::of((0..functions.len()).flat_map(of_sender).collect());
    let global = GlobalTransport::of(&direct, 1e-4).operator;
    (transport.basis, transport.direct, transport.global) = (basis, direct, global);
    turned.write(&folder.path("turned.cuts")).expect("a writable folder");
    let wrong = folder.off_from_paths("turned.cuts", "wavelet", &picture);
    assert!(wrong > 2.0 * with_noise, "negative control: {wrong} beside {with_noise}");
}

#[test]
fn an_edit_of_the_material_shows_in_the_last_reflection() {
    let folder = room();
    folder.succeed("bake room.obj -o room.cuts --mode wavelet --tau 1e-3 --max-vertices 300 --progress none");
    let light = |options: &str| {
        let view = "--size 24x24 --components indirect --backend cpu --out a.exr --quiet";
        folder.succeed(&format!("render room.cuts {VIEW} --solution wavelet {view} {options}"));
        let picture = lapidary_interchange::image::read(&folder.path("a.exr")).expect("a picture");
        picture.pixels.iter().sum::<Vec3>()
    };
    let (before, after) = (light(""), light("--base-color 0.1,0.1,0.1"));
    assert!(before.min_element() > 0.0, "{before}");
    assert!(after.max_element() < 0.5 * before.max_element(), "{before} {after}");
    // Walls that were baked diffuse know no directions, but are no brighter as metal.
    let brightest = |options: &str| {
        light(options);
        let picture = lapidary_interchange::image::read(&folder.path("a.exr")).expect("a picture");
        picture.pixels.iter().map(|pixel| pixel.max_element()).fold(0.0, f32::max)
    };
    let (diffuse, metal) = (brightest("--roughness 1 --metalness 0"), brightest("--roughness 0.3 --metalness 1"));
    assert!(metal < 1.5 * diffuse, "{metal} {diffuse}");
}

#[test]
fn other_scenes_are_refused_before_the_work() {
    let folder = room();
    folder.write("room.obj", format!("{ROOM}f 1 2 3\n"));
    let told = folder.fail("bake room.obj -o room.cuts --mode wavelet --progress none");
    assert!(told.contains("triangle 10") && told.contains("--mode"), "{told}");
    assert!(!folder.path("room.cuts").exists());
    let told = folder.fail("bake scene.obj -o a.cuts --mode wavelet --tau 2 --progress none");
    assert!(told.contains("--tau"), "{told}");
}
