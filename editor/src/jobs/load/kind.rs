//! The kind of a file: by its extension, by its shape for pictures, and by its contents for JSON.

use lapidary_core::{brdf::ContentKind, input};
use lapidary_interchange::{
    formats::{FileFormat, MaterialFormat, PictureFormat, SceneFormat, listed},
    image::dimensions,
    import::MaterialFile,
};
use std::path::Path;

/// Kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A scene to import and bake.
    Scene,
    /// A baked scene.
    Dataset,
    /// A session of this program.
    Session,
    /// An environment map.
    Environment,
    /// A picture for a map.
    Texture,
    /// A material file.
    Material,
    /// The file of a BRDF.
    Brdf,
    /// A list of local lights.
    Lights,
    /// None of these.
    Unknown,
}

/// The kind of a file. Reads at most the header of a picture and the text of a JSON file.
pub fn kind_of(path: &Path) -> Kind {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match name.rsplit_once('.').map_or("", |(_, extension)| extension) {
        "cuts" => Kind::Dataset,
        "lapidary" => Kind::Session,
        "json" => kind_of_json(path),
        extension if ContentKind::EXTENSIONS.contains(&extension) => Kind::Brdf,
        _ if SceneFormat::of(path).is_some() => Kind::Scene,
        _ if PictureFormat::is_of_light(path) => Kind::Environment,
        _ if PictureFormat::of(path).is_some() => kind_of_picture(path),
        _ if MaterialFormat::of(path).is_some_and(|format| format.loads) => Kind::Material,
        _ => Kind::Unknown,
    }
}

/// A picture twice as wide as high is most likely an environment map.
fn kind_of_picture(path: &Path) -> Kind {
    match dimensions(path) {
        Ok([width, height]) if u64::from(width) == 2 * u64::from(height) => Kind::Environment,
        // Opening a damaged picture reports its error.
        _ => Kind::Texture,
    }
}

fn kind_of_json(path: &Path) -> Kind {
    let Ok(text) = input::read_text(path) else { return Kind::Unknown };
    if serde_json::from_str::<MaterialFile>(&text).is_ok() {
        return Kind::Material;
    }
    // A glTF or other JSON file has no such keys; a material with a mistake is opened as a material, to report the mistake.
    let Ok(serde_json::Value::Object(keys)) = serde_json::from_str(&text) else { return Kind::Unknown };
    if keys.contains_key("lapidary_session") {
        Kind::Session
    } else if keys.contains_key("model") && keys.contains_key("parameters") {
        Kind::Material
    } else if keys.get("lights").is_some_and(|lights| lights.is_array()) {
        Kind::Lights
    } else {
        Kind::Unknown
    }
}

/// Why a file of unknown kind cannot be opened.
pub fn foreign(path: &Path) -> String {
    let what = if path.exists() { "Lapidary does not know this kind of file" } else { "file not found" };
    let named = |endings: Vec<&str>| listed(&endings, ", ");
    let pictures = |is_light| PictureFormat::ALL.iter().filter(move |format| format.is_light == is_light);
    let usual = |is_light| pictures(is_light).map(|format| format.endings()[0]).collect();
    format!(
        "{what}; open a scene ({}), a dataset (.cuts), a session (.lapidary, .json), an environment ({}), a picture ({}), \
         a material ({}), a BRDF ({}) or lights (.json) ({})",
        named(SceneFormat::all_endings(|_| true)),
        named(usual(true)),
        named(usual(false)),
        named(MaterialFormat::all_endings(|format| format.loads)),
        named(ContentKind::EXTENSIONS.to_vec()),
        path.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::image::Image;
    use lapidary_interchange::image;

    #[test]
    fn extensions_decide_in_any_case() {
        let kinds = [
            ("a.obj", Kind::Scene),
            ("a.b.GLB", Kind::Scene),
            ("a.gltf", Kind::Scene),
            ("a.ply", Kind::Scene),
            ("a.cuts", Kind::Dataset),
            ("a.lapidary", Kind::Session),
            ("a.EXR", Kind::Environment),
            ("a.hdr", Kind::Environment),
            ("a.MTLX", Kind::Material),
            ("a.fbx", Kind::Unknown),
            ("cuts", Kind::Unknown),
            ("", Kind::Unknown),
            ("missing.json", Kind::Unknown),
            ("missing.png", Kind::Texture),
        ];
        for (path, kind) in kinds {
            assert_eq!(kind_of(Path::new(path)), kind, "{path}");
        }
    }

    #[test]
    fn pictures_are_told_apart_by_shape_and_json_by_contents() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        image::write(&Image::filled([8, 4], Vec3::ONE), &path("wide.png")).unwrap();
        image::write(&Image::filled([8, 5], Vec3::ONE), &path("square.png")).unwrap();
        assert_eq!(kind_of(&path("wide.png")), Kind::Environment);
        assert_eq!(kind_of(&path("square.png")), Kind::Texture);
        let json = |text: &str| {
            std::fs::write(path("a.json"), text).unwrap();
            kind_of(&path("a.json"))
        };
        assert_eq!(json(r#"{"name": "gold", "model": "ggx"}"#), Kind::Material);
        assert_eq!(json(r#"{"model": "gxx", "parameters": {}}"#), Kind::Material);
        assert_eq!(json(r#"{"lapidary_session": 1}"#), Kind::Session);
        assert_eq!(json(r#"{"asset": {"version": "2.0"}}"#), Kind::Unknown);
        assert_eq!(json(r#"{"lights": [{"kind": "laser"}]}"#), Kind::Lights);
        assert_eq!(json(r#"{"lights": 3}"#), Kind::Unknown);
        assert_eq!(json("[1, 2"), Kind::Unknown);
    }

    #[test]
    fn a_foreign_file_is_told_what_can_be_opened() {
        assert_eq!(
            foreign(Path::new("a.fbx")),
            "file not found; open a scene (.obj, .gltf, .glb, .ply), a dataset (.cuts), a session (.lapidary, .json), an \
             environment (.hdr, .exr), a picture (.png, .jpg, .tif, .webp, .ktx2, .tga), a material (.json, .mtlx), a \
             BRDF (.binary, .wgsl) or lights (.json) (a.fbx)"
        );
        assert!(foreign(Path::new(".")).contains("does not know"));
    }
}
