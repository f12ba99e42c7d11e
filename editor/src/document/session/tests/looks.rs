//! Looks in sessions.

use super::*;
use crate::document::looks::{LookPart, LookState, NamedLook};

/// A document with an added material, and looks: one of another paint, light, camera and view, and one of light alone.
fn with_looks(project: &mut Project) -> Document {
    let mut document = with_a_part(project);
    let mut other = document.clone();
    other.materials[1].parameters.set("base_color", Vec3::new(0.1, 0.2, 0.9));
    other.materials.push(Material { name: "chrome".into(), ..Default::default() });
    (other.added, other.hidden_ground) = (2, Some(Material { name: "Ground".into(), ..Default::default() }));
    other.assigned.insert(Part { object: 0, material: 1 }, 4);
    other.environment.spec = project.path("maps/evening.hdr").to_string_lossy().into_owned();
    other.lights.truncate(1);
    other.camera = camera("close");
    other.view.post.exposure = 1.5;
    let state = LookState::of(&other);
    let light = state.part(LookPart::Light);
    let look = |name: &str, state| NamedLook { name: name.into(), state };
    document.looks = vec![look("Blue", state), look("Evening", light)];
    document
}

#[test]
fn looks_survive_the_disk() {
    let mut project = Project::new();
    std::fs::write(project.path("maps/evening.hdr"), b"").unwrap();
    let mut document = with_looks(&mut project);
    let loaded = project.reloaded(&document);
    assert_eq!((&loaded.missing, &loaded.unknown), (&Vec::new(), &Unknown::default()));
    let (read, warnings) = loaded.clone().into_document(Some(&project.dataset.scene));
    assert_eq!(warnings, Vec::<String>::new());
    assert_same(&read, &document);
    let written = project.json()["looks"].clone();
    assert_eq!(written[0]["environment"]["spec"], "../maps/evening.hdr", "as all paths");
    assert!(written[1].get("materials").is_none() && written[1].get("view").is_none(), "{written}");
    let (alone, _) = loaded.into_document(None);
    save(&alone, &Unknown::default(), &project.file()).unwrap();
    assert_eq!(project.json()["looks"], written, "without the scene");
    document.looks[0].state.materials.as_mut().unwrap().assigned.clear();
    assert_ne!(read.looks, document.looks, "negative control");
}

#[test]
fn looks_follow_the_names_of_objects_and_materials() {
    let mut project = Project::new();
    let document = with_looks(&mut project);
    let loaded = project.reloaded(&document);
    let scene = &mut project.dataset.scene;
    scene.objects.swap(0, 1);
    scene.materials.swap(0, 2);
    let (read, _) = loaded.into_document(Some(scene));
    let [then, now] = [&document, &read].map(|document| document.looks[0].state.materials.clone().unwrap());
    assert_eq!(now.materials[1], then.materials[1]);
    assert_eq!(now.materials[0].name, then.materials[2].name);
    assert_eq!(now.assigned, [(Part { object: 0, material: 2 }, 3), (Part { object: 1, material: 1 }, 4)].into());
}

#[test]
fn what_is_wrong_in_a_look_costs_nothing_else() {
    let mut project = Project::new();
    let document = with_looks(&mut project);
    save(&document, &Unknown::default(), &project.file()).unwrap();
    let mut json = project.json();
    json["looks"][0]["environment"]["intensity"] = json!("much");
    json["looks"][0]["environment"]["fog"] = json!(1);
    json["looks"][0]["mood"] = json!("calm");
    json["looks"][1]["mood"] = json!("cold");
    json["looks"][0]["camera"]["target"] = json["looks"][0]["camera"]["eye"].clone();
    json["looks"][1]["name"] = json!("Blue");
    json["looks"].as_array_mut().unwrap().push(json!(7));
    std::fs::write(project.file(), json.to_string()).unwrap();
    let loaded = load(&project.file()).unwrap();
    let told = |text: &str| loaded.warnings.iter().any(|warning| warning.contains(text));
    assert!(told("looks[0]: environment.intensity cannot be \"much\""), "{:?}", loaded.warnings);
    assert!(told("looks[2] is no object") && told("no view direction"), "{:?}", loaded.warnings);
    assert!(told("it is now \"Blue 2\""), "{:?}", loaded.warnings);
    assert_eq!(loaded.warnings.len(), 4, "{:?}", loaded.warnings);
    assert_eq!(loaded.missing[0].path, project.path("maps/evening.hdr"));
    let unknown = loaded.unknown.clone();
    let (read, _) = loaded.into_document(Some(&project.dataset.scene));
    assert_eq!(read.looks.iter().map(|look| look.name.as_str()).collect::<Vec<_>>(), ["Blue", "Blue 2"]);
    assert_eq!(read.looks[0].state.materials, document.looks[0].state.materials);
    assert_eq!((&read.looks[0].state.camera, &read.looks[0].state.view), (&None, &document.looks[0].state.view));
    save(&read, &unknown, &project.file()).unwrap();
    let written = &project.json()["looks"];
    assert_eq!(
        (&written[0]["mood"], &written[0]["environment"]["fog"]),
        (&json!("calm"), &json!(1)),
        "what is unknown"
    );
    assert_eq!(written[1]["mood"], json!("cold"), "also of a look that has got another name");
}
