//! Coincident sheets of one object, which move together or apart.

use super::*;

/// A square, and triangles above it or in the same place, with a normal; the second sheet follows a given joint or target.
struct Sheets {
    height: f32,
    normal: f32,
    joint: u16,
    /// Displacement by a morph target.
    raised: f32,
    /// Whether they are one large triangle.
    is_large: bool,
}

impl Sheets {
    const ALIKE: Self = Self { height: 0.0, normal: 1.0, joint: 0, raised: 0.0, is_large: false };

    fn file(&self) -> TestFile {
        let nodes = json!([{ "name": "sheets", "mesh": 0, "skin": 0 }, { "name": "a" }, { "name": "b" }]);
        let mut file = TestFile::new(nodes, 3);
        let z = self.height;
        let square = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
        let second: &[f32] =
            if self.is_large { &[-1., -1., z, 9., -1., z, -1., 9., z] } else { &[0., 0., z, 1., 0., z, 1., 1., z] };
        let (count, positions) = (second.len() / 3, [&square[..], second].concat());
        let normals = [[0.0, 0.0, 1.0].repeat(4), [0.0, 0.0, self.normal].repeat(count)].concat();
        let joints = [vec![0; 16], [self.joint, 0, 0, 0].repeat(count)].concat();
        let attributes = [
            ("NORMAL", file.floats(&normals, "VEC3")),
            ("JOINTS_0", file.shorts(&joints, "VEC4")),
            ("WEIGHTS_0", file.floats(&[1.0, 0.0, 0.0, 0.0].repeat(4 + count), "VEC4")),
        ];
        file.mesh(&positions, &[0, 1, 2, 0, 2, 3, 4, 5, 6], &attributes);
        let raised = file.floats(&[vec![0.0; 12], [0.0, 0.0, self.raised].repeat(count)].concat(), "VEC3");
        file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": raised }]);
        file.skin(&[1, 2], &[[0.0; 3]; 2]);
        file.clip("slide", 2, "translation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0], "LINEAR");
        file
    }

    fn warnings(&self) -> Vec<String> {
        animation::read(&self.file().write(), &ImportOptions::default()).unwrap().warnings
    }
}

#[test]
fn sheets_in_one_place_that_move_apart_are_told() {
    let apart = [
        Sheets { joint: 1, ..Sheets::ALIKE },
        Sheets { joint: 1, is_large: true, ..Sheets::ALIKE },
        Sheets { raised: 0.1, ..Sheets::ALIKE },
    ];
    for sheets in apart {
        let warnings = sheets.warnings();
        assert!(
            matches!(&warnings[..], [told] if told.contains("\"sheets\"") && told.contains("apart")),
            "{warnings:?}"
        );
    }
    let told_apart = [
        Sheets::ALIKE,
        Sheets { is_large: true, ..Sheets::ALIKE },
        Sheets { joint: 1, height: 0.01, ..Sheets::ALIKE },
        Sheets { joint: 1, normal: -1.0, ..Sheets::ALIKE },
    ];
    for sheets in told_apart {
        assert_eq!(sheets.warnings(), [] as [String; 0], "negative control");
    }
}
