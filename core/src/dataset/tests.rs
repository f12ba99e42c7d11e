//! A dataset survives the disk; damaged files are rejected.

use super::*;
use crate::{
    cut::packed::pack_node,
    material::{Material, MaterialMaps},
    meshless::{Basis, ObjectBases, Owner, Transport},
    opacity::PartOpacity,
    parts::{Part, PartVariants, Variants},
    sources::Source,
    sphere::concentric::HemisphereCells,
    surfel::{MeshPlace, Surfel},
    test_scenes,
    texture::{Channel, Texture, TextureSlot},
    wavelet::{
        operator::{Operator, RadianceFunction, TransportCoefficient},
        patch::Patch,
        reflecting::ReflectingPatch,
        square::Function,
    },
};
use glam::{Mat3, Vec2, Vec3};
use std::path::{Path, PathBuf};

mod brdfs;
mod damage;

/// The shared triangle with cuts and marks that differ from vertex to vertex.
fn dataset() -> Dataset {
    let mut cuts = PackedCuts::default();
    for value in [0.0, 0.5, 1.0] {
        let offset = cuts.push_cut(&[pack_node(1, value), pack_node(1, 0.25)]);
        cuts.push_vertex(offset);
    }
    Dataset {
        two_sided: vec![true],
        vertex_valid: vec![true, false, true],
        cuts,
        settings: BakeSettings { lights: 64, pilot_clusters: 16, max_vertices: None, ..Default::default() },
        report: BakeReport { vertices: 3, ..Default::default() },
        ..test_scenes::dataset(&["m"], &[])
    }
}

fn written() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    dataset().write(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    (folder, path, bytes)
}

/// Reads a dataset without pictures.
fn read(path: &Path) -> Result<Dataset, DatasetError> {
    Dataset::read(path, |_, path| Err(ImageError::Decode { path: path.into(), reason: "no decoder".into() }))
}

/// The error of reading a file whose bytes were changed.
fn error_after(change: impl FnOnce(&mut Vec<u8>)) -> DatasetError {
    let (_folder, path, mut bytes) = written();
    change(&mut bytes);
    std::fs::write(&path, bytes).unwrap();
    read(&path).unwrap_err()
}

#[test]
fn a_picture_that_is_damaged_or_too_large_is_told_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let mut damaged = dataset();
    let texture = Texture { encoded: vec![1, 2, 3].into(), ..Texture::missing("wood.png") };
    damaged.scene.textures = vec![texture.into()];
    damaged.write(&path).unwrap();
    let message = read(&path).unwrap_err().to_string();
    assert!(message.contains("damaged: texture 0 cannot be read") && message.ends_with("a.cuts)"), "{message}");
    assert!(!message.contains("metadata"), "{message}");

    let source = ImageError::Memory { path: "wood.png".into(), needed: 5, available: 4 };
    let message = DatasetError::of_contents(&path, error::Damage::Picture { index: 0, source }).to_string();
    assert!(message.contains("5 MB") && message.contains("4 MB are free; close other programs"), "{message}");
    assert!(message.ends_with("a.cuts)") && !message.contains("damaged"), "{message}");
}

#[test]
fn everything_survives_the_disk() {
    let (_folder, path, _) = written();
    let (read, original) = (read(&path).unwrap(), dataset());
    assert_eq!(read.scene.mesh, original.scene.mesh);
    assert_eq!(read.scene.materials, original.scene.materials);
    assert_eq!((read.cuts, read.tree), (original.cuts, original.tree));
    assert_eq!((read.two_sided, read.vertex_valid), (original.two_sided, original.vertex_valid));
    assert_eq!((read.settings, read.report), (original.settings, original.report));
}

#[test]
fn second_texture_coordinates_and_colors_survive_the_disk_and_are_hashed() {
    let mut dataset = dataset();
    let hash = scene_hash(&dataset.scene);
    dataset.scene.mesh.second_uvs = vec![Vec2::new(0.25, 3.0), Vec2::X, Vec2::Y];
    let with_uvs = scene_hash(&dataset.scene);
    dataset.scene.mesh.colors = vec![Vec3::X, Vec3::Y, Vec3::splat(0.5)];
    assert!(hash != with_uvs && with_uvs != scene_hash(&dataset.scene));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    dataset.write(&path).unwrap();
    assert_eq!(read(&path).unwrap().scene.mesh, dataset.scene.mesh);
    dataset.scene.mesh.colors.pop();
    let message = dataset.write(&path).unwrap_err().to_string();
    assert!(message.contains("2 colors for 3 vertices"), "{message}");
}

#[test]
fn maps_of_every_parameter_survive_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let mut dataset = dataset();
    dataset.scene.textures = vec![Texture::missing("a.png").into()];
    let slot = |channel, strength| TextureSlot { channel, strength, ..Default::default() };
    dataset.scene.materials[0].maps = MaterialMaps::from([
        ("anisotropy", slot(Channel::G, 0.5)),
        ("ior", slot(Channel::B, 0.25)),
        ("bump", slot(Channel::A, 0.125)),
    ]);
    dataset.write(&path).unwrap();
    let read = read(&path).unwrap().scene.materials;
    assert_eq!(read, dataset.scene.materials);
    let strength = |kind| read[0].maps.get(kind).map(|slot| slot.strength);
    let in_place = ["anisotropy", "ior", "bump"].map(strength);
    assert_eq!(in_place, [Some(0.5), Some(0.25), Some(0.125)]);
}

#[test]
fn what_is_stored_and_not_rendered_survives_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let mut dataset = dataset();
    dataset.scene.textures = vec![Texture::missing("a.png").into()];
    let material = &mut dataset.scene.materials[0];
    material.model = crate::brdf::BrdfModel::OpenPbr;
    material.parameters.set("transmission_weight", 0.625);
    material.maps.set("thin_film_thickness", Some(TextureSlot { channel: Channel::G, ..Default::default() }));
    dataset.write(&path).unwrap();
    let mut read = read(&path).unwrap().scene.materials;
    assert_eq!(read, dataset.scene.materials);
    assert_eq!(read[0].stored().count(), 2);
    read[0].parameters.set("transmission_weight", 0.0);
    assert_ne!(read, dataset.scene.materials, "negative control");
}

/// Overwrites the first `from` in the header, padded with spaces to keep its length.
fn replace(bytes: &mut [u8], from: &str, to: &str) {
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
    bytes[at..at + from.len()].copy_from_slice(format!("{to:len$}", len = from.len()).as_bytes());
}

/// Makes a file one of an older version.
fn be_of_version(bytes: &mut [u8], version: u32) {
    let of = |version: u32| format!(r#"\"format_version\":{version}"#);
    replace(bytes, &of(FORMAT_VERSION), &of(version));
}

#[test]
fn a_file_of_version_1_is_read_with_its_empty_maps_and_misspelt_ones_are_told() {
    let (_folder, path, mut bytes) = written();
    let sides = r#"\"maps\":{},\"double_sided\":false"#;
    be_of_version(&mut bytes, 1);
    replace(&mut bytes, sides, r#"\"maps\":{\"ior\":null}"#);
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(read(&path).unwrap().scene.materials, dataset().scene.materials);
    let misspelt = error_after(|b| replace(b, sides, r#"\"maps\":{\"iro\":{}}"#));
    assert!(misspelt.to_string().contains("iro"), "{misspelt}");
}

#[test]
fn a_truncated_file_is_refused_at_every_length() {
    let (_folder, path, bytes) = written();
    for length in (0..bytes.len()).step_by(97) {
        std::fs::write(&path, &bytes[..length]).unwrap();
        assert!(matches!(read(&path), Err(DatasetError::Foreign { .. })), "length {length}");
    }
}

#[test]
fn foreign_and_newer_files_are_told_apart() {
    let foreign = error_after(|b| *b = b"v 0 0 0\nv 1 0 0\n# not a dataset at all\n".to_vec());
    assert!(matches!(foreign, DatasetError::Foreign { .. }), "{foreign}");
    let newer = error_after(|b| {
        let at = b.windows(19).position(|w| w == b"\\\"format_version\\\":").unwrap();
        b.insert(at + 19, b'1');
        let length = u64::from_le_bytes(b[..8].try_into().unwrap()) + 1;
        b[..8].copy_from_slice(&length.to_le_bytes());
    });
    let with_a_one: u32 = format!("1{FORMAT_VERSION}").parse().unwrap();
    assert!(matches!(newer, DatasetError::Newer { found, .. } if found == with_a_one), "{newer}");
}

#[test]
fn probes_that_cannot_be_are_refused() {
    let told = |lights_per_probe| {
        let mut dataset = dataset();
        dataset.report.audit = Some(BakeAudit { leaves_per_probe: lights_per_probe, ..Default::default() });
        dataset.validate()
    };
    assert!([1, 8, 16, 512].into_iter().all(|lights| told(lights).is_ok()));
    for lights in [0, 7, 12] {
        assert!(told(lights).unwrap_err().to_string().contains("lights per probe"), "{lights}");
        let mut dataset = dataset();
        let audit = Some(BakeAudit { leaves_per_probe: lights, ..Default::default() });
        dataset.report.indirect = Some(IndirectReport { audit, ..Default::default() });
        assert!(dataset.validate().unwrap_err().to_string().contains("sources per probe"), "{lights}");
    }
}

#[test]
fn a_single_flipped_bit_is_noticed() {
    let (_folder, path, bytes) = written();
    for back in [1, 40, 200, 400] {
        let mut changed = bytes.clone();
        let at = changed.len() - back;
        changed[at] ^= 1;
        std::fs::write(&path, changed).unwrap();
        let error = read(&path).unwrap_err();
        assert!(matches!(error, DatasetError::Damaged { reason: error::Damage::Checksum(_), .. }), "{error}");
    }
}

#[test]
fn a_failed_write_keeps_the_file_that_was_there() {
    let (folder, path, before) = written();
    let nowhere = folder.path().join("missing").join("a.cuts");
    assert!(matches!(dataset().write(&nowhere), Err(DatasetError::Io { action: "write", .. })));
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
#[cfg(unix)]
fn others_may_read_what_was_written() {
    use std::os::unix::fs::PermissionsExt;
    let (folder, path, _) = written();
    let plain = folder.path().join("plain");
    std::fs::write(&plain, b"as any other output").unwrap();
    let mode = |path: &std::path::Path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain));
}

#[test]
fn the_hash_sees_geometry_and_ignores_names() {
    let mut scene = dataset().scene;
    let hash = scene_hash(&scene);
    scene.materials[0].name = "renamed".into();
    assert_eq!(scene_hash(&scene), hash);
    scene.mesh.positions[1].x += 1e-6;
    assert_ne!(scene_hash(&scene), hash);
}

fn with_sources() -> Dataset {
    let mut dataset = dataset();
    let source = |i: u32| {
        let place = MeshPlace { triangle: 0, barycentric: Vec2::new(0.25, 0.125 * i as f32) };
        let surfel = Surfel { position: Vec3::new(i as f32, 0.0, 1.0), normal: Vec3::Y, place };
        Source { surfel, area: 0.5 + i as f32, spacing: 0.25 + i as f32 }
    };
    let mut cuts = PackedCuts::default();
    for node in [[1 << 12, 1 << 12 | 7], [1 << 12 | 9, 1 << 12]] {
        let offset = cuts.push_cut(&node);
        cuts.push_vertex(offset);
    }
    cuts.push_vertex(0);
    let mut environment_cuts = PackedCuts::default();
    for value in 0..4 {
        let offset = environment_cuts.push_cut(&[value]);
        environment_cuts.push_vertex(offset);
    }
    dataset.indirect = Some(IndirectBake { sources: (0..4).map(source).collect(), cuts, environment_cuts });
    dataset.settings.mode = BakeParts::ALL;
    dataset.report.indirect = Some(IndirectReport { sources: 4, area: 8.0, ..Default::default() });
    dataset
}

#[test]
fn sources_and_their_cuts_survive_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let original = with_sources();
    original.write(&path).unwrap();
    let again = read(&path).unwrap();
    let (a, b) = (again.indirect.unwrap(), original.indirect.unwrap());
    assert_eq!(a.sources, b.sources);
    assert_eq!((a.cuts, a.environment_cuts), (b.cuts, b.environment_cuts));
    assert_eq!((again.settings, again.report), (original.settings, original.report));
    dataset().write(&path).unwrap();
    assert!(read(&path).unwrap().indirect.is_none(), "a dataset without them");
}

#[test]
fn sources_of_version_3_are_as_far_apart_as_was_reported_or_as_follows_from_their_areas() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let spacings = |radius: f32, is_older: bool| -> Vec<f32> {
        let mut dataset = with_sources();
        dataset.report.indirect.as_mut().unwrap().radius = radius;
        dataset.write(&path).unwrap();
        if is_older {
            let mut bytes = std::fs::read(&path).unwrap();
            be_of_version(&mut bytes, 3);
            // Its checksum and the tensor itself.
            replace(&mut bytes, "source_spacings", "what_is_unknown");
            replace(&mut bytes, "source_spacings", "what_is_unknown");
            std::fs::write(&path, bytes).unwrap();
        }
        read(&path).unwrap().indirect.unwrap().sources.iter().map(|s| s.spacing).collect()
    };
    assert_eq!(spacings(0.3, true), [0.3; 4]);
    assert_eq!(spacings(0.0, true), [2.0_f32.sqrt(); 4], "areas of 0.5 to 3.5 m²");
    assert_eq!(spacings(0.3, false), [0.25, 1.25, 2.25, 3.25], "negative control");
}

#[test]
fn damaged_sources_are_named() {
    let error_of = |change: &dyn Fn(&mut IndirectBake)| {
        let mut dataset = with_sources();
        change(dataset.indirect.as_mut().unwrap());
        damage::refusal(&dataset)
    };
    assert!(error_of(&|b| b.sources[1].area = -1.0).contains("surface source 1"));
    assert!(error_of(&|b| b.sources[1].spacing = f32::NAN).contains("surface source 1"));
    assert!(error_of(&|b| b.sources[2].surfel.position.x = f32::NAN).contains("surface source 2"));
    assert!(error_of(&|b| b.sources[3].surfel.place.triangle = 1).contains("lies on triangle 1, but there are 1"));
    let three = error_of(&|b| b.sources.truncate(3));
    assert!(three.contains("3 surface sources"), "{three}");
    let cut = error_of(&|b| b.cuts = b.environment_cuts.clone());
    assert!(cut.contains("there are 4 cuts, not 3"), "{cut}");
    let node = error_of(&|b| {
        b.environment_cuts = PackedCuts::default();
        let offset = b.environment_cuts.push_cut(&[9 << 12]);
        (0..4).for_each(|_| b.environment_cuts.push_vertex(offset));
    });
    assert!(node.contains("entry 0 of `source_environment_cuts`"), "{node}");
}

fn with_meshless() -> Dataset {
    let place = MeshPlace { triangle: 0, barycentric: Vec2::splat(0.25) };
    let point = |x: f32| Surfel { position: Vec3::new(x, 0.0, 0.0), normal: Vec3::Y, place };
    let levels = [vec![point(0.0), point(1.0)], vec![point(0.0), point(0.5), point(1.0)]];
    let basis = Basis::new(&levels, 1.0, 1).unwrap();
    let rows = [vec![(1, Vec3::Y)], vec![], vec![(0, Vec3::X), (1, -Vec3::Z)], vec![], vec![(0, Vec3::ONE)]];
    let transport = Transport::from_rows(&rows, 2);
    Dataset { meshless: Some(MeshlessBake { basis, transport }.into()), ..dataset() }
}

#[test]
fn the_meshless_basis_and_its_links_survive_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let original = with_meshless();
    original.write(&path).unwrap();
    let (a, b) = (read(&path).unwrap().meshless.unwrap(), original.meshless.unwrap());
    assert_eq!(a.basis.points(), b.basis.points());
    assert_eq!((a.basis.offsets(), a.basis.radii()), (b.basis.offsets(), b.basis.radii()));
    assert_eq!((a.basis.sender_levels(), &a.transport), (1, &b.transport));
    dataset().write(&path).unwrap();
    assert!(read(&path).unwrap().meshless.is_none(), "a dataset without it");
}

/// A dataset with two functions of one object, on two levels.
fn with_object_bases() -> Dataset {
    let mut dataset = dataset();
    let at = |x: f32| dataset.scene.mesh.surfel(0, Vec2::new(x, 0.25), false);
    let level = |x: f32| vec![(at(x), Owner::on(&dataset.scene.mesh, &at(x)))];
    let bases = ObjectBases::new(&[level(0.5), level(0.125)], vec![1.0, 0.5], 0).unwrap();
    dataset.object_bases = Some(bases.into());
    dataset
}

#[test]
fn bases_of_objects_survive_the_disk_and_functions_beside_the_mesh_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let original = with_object_bases();
    original.write(&path).unwrap();
    let (a, b) = (read(&path).unwrap().object_bases.unwrap(), original.object_bases.clone().unwrap());
    assert_eq!((a.points(), a.owners(), a.offsets()), (b.points(), b.owners(), b.offsets()));
    assert_eq!((a.radii(), a.sender_level()), (b.radii(), b.sender_level()));
    let mut damaged = original;
    let mut points = b.points().to_vec();
    points[1].place.triangle = 7;
    let parts = (b.owners().to_vec(), b.offsets().to_vec(), b.radii().to_vec());
    damaged.object_bases = Some(ObjectBases::from_parts(points, parts.0, parts.1, parts.2, 0).unwrap().into());
    let refused = damaged.write(&path).unwrap_err().to_string();
    assert!(refused.contains("function 1 of the bases of objects"), "{refused}");
    dataset().write(&path).unwrap();
    assert!(read(&path).unwrap().object_bases.is_none(), "a dataset without them");
}

/// A dataset with wavelet transport from a quad to itself.
fn with_wavelet() -> Dataset {
    let dataset = dataset();
    let quad = Patch {
        corner: Vec3::new(0.0, 1.0, 0.0),
        edges: [Vec3::X * 2.0, Vec3::Z],
        frame: Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y),
        area: 2.0,
        material: 0,
        object: 0,
    };
    let mut patches = ReflectingPatch::all(vec![quad], &dataset.scene.materials);
    patches[0].cells = HemisphereCells { side: 4 };
    let of = |angle| RadianceFunction { patch: 0, space: Function::CONSTANT, angle };
    let deeper = Function::from_bits(Function::CONSTANT.to_bits() + 1).unwrap();
    let coefficient = |receiver, value| TransportCoefficient { receiver: of(receiver), sender: of(deeper), value };
    let coefficients = vec![coefficient(Function::CONSTANT, Vec3::X), coefficient(deeper, Vec3::splat(0.5))];
    let (basis, direct) = Operator::of(coefficients);
    let global = Operator::identity(2).plus(&direct);
    Dataset { wavelet: Some(WaveletTransport { patches, basis, direct, global }.into()), ..dataset }
}

#[test]
fn wavelet_transport_survives_the_disk_and_wrong_quads_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let original = with_wavelet();
    original.write(&path).unwrap();
    let (a, b) = (read(&path).unwrap().wavelet.unwrap(), original.wavelet.clone().unwrap());
    assert_eq!((&a.basis, &a.direct, &a.global), (&b.basis, &b.direct, &b.global));
    assert_eq!((a.patches[0].patch, a.patches[0].cells), (b.patches[0].patch, b.patches[0].cells));
    for damage in [
        |patch: &mut ReflectingPatch| patch.patch.material = 9,
        |patch: &mut ReflectingPatch| patch.patch.object = 9,
        |patch: &mut ReflectingPatch| patch.patch.corner.x = f32::NAN,
        |patch: &mut ReflectingPatch| patch.cells.side = 3,
    ] {
        let mut transport = (*b).clone();
        damage(&mut transport.patches[0]);
        let refused = Dataset { wavelet: Some(transport.into()), ..original.clone() }.write(&path).unwrap_err();
        assert!(refused.to_string().contains("patch 0 of the wavelet transport"), "{refused}");
    }
    dataset().write(&path).unwrap();
    assert!(read(&path).unwrap().wavelet.is_none(), "a dataset without it");
}

#[test]
fn only_functions_that_exist_are_read() {
    assert_eq!(Function::from_bits(Function::CONSTANT.to_bits()), Some(Function::CONSTANT));
    for bits in [0, 3, 8, 12, u32::MAX] {
        assert_eq!(Function::from_bits(bits), None, "{bits}");
    }
    assert!(Operator::from_parts(vec![0, 1], vec![(0, Vec3::ONE)]).is_some());
    for (starts, entry) in [(vec![0, 2], (0, Vec3::ONE)), (vec![0, 1], (1, Vec3::ONE)), (vec![0, 1], (0, Vec3::NAN))] {
        assert!(Operator::from_parts(starts, vec![entry]).is_none(), "{entry:?}");
    }
}

#[test]
fn opacities_of_parts_survive_the_disk_and_older_files_have_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let mut dataset = test_scenes::dataset(&["a", "b"], &[]);
    dataset.write(&path).unwrap();
    assert!(read(&path).unwrap().scene.part_opacities.is_empty());
    assert!(!String::from_utf8_lossy(&std::fs::read(&path).unwrap()).contains("part_opacities"), "as files of before");
    let mut material = Material::default();
    material.parameters.set("geometry_opacity", 0.5);
    dataset.scene.part_opacities = vec![PartOpacity { parts: vec![Part { object: 0, material: 0 }], material }];
    dataset.write(&path).unwrap();
    assert_eq!(read(&path).unwrap().scene.part_opacities, dataset.scene.part_opacities);
    dataset.scene.part_opacities[0].parts[0].material = 2;
    let refused = dataset.write(&path).unwrap_err().to_string();
    assert!(refused.contains("parts that let light through do not fit"), "{refused}");
}

#[test]
fn variants_survive_the_disk_and_older_files_have_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let mut dataset = test_scenes::dataset(&["a", "b"], &[]);
    dataset.write(&path).unwrap();
    assert!(read(&path).unwrap().scene.variants.is_empty());
    assert!(!String::from_utf8_lossy(&std::fs::read(&path).unwrap()).contains("variants"), "as files of before");
    let part = PartVariants { part: Part { object: 0, material: 0 }, plain: 0, in_variants: vec![1] };
    dataset.scene.variants = Variants { names: vec!["red".into()], parts: vec![part] };
    dataset.write(&path).unwrap();
    assert_eq!(read(&path).unwrap().scene.variants, dataset.scene.variants);
    dataset.scene.variants.parts[0].in_variants[0] = 2;
    let refused = dataset.write(&path).unwrap_err().to_string();
    assert!(refused.contains("its variants do not fit"), "{refused}");
}
