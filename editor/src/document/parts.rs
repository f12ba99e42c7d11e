//! Materials of parts: parts with another material than the mesh's, and the materials added for them.

use super::{Document, ShownMaterials, ViewSettings};
use lapidary_core::{
    material::Material,
    opacity::Opacity,
    parts::{Part, Variants},
    scene::{Mesh, Scene},
};
use lapidary_render::Assigned;
use std::collections::BTreeMap;

/// Parts with another material than the mesh's, by its index in the document.
pub type Assignment = BTreeMap<Part, usize>;

impl Document {
    /// Number of the scene's own materials; added ones come after them.
    pub fn own_materials(&self) -> usize {
        self.materials.len().saturating_sub(self.added)
    }

    /// The material of a part, by index.
    pub fn material_of(&self, part: Part) -> usize {
        let assigned = self.assigned.get(&part).filter(|&&material| material < self.materials.len());
        assigned.copied().unwrap_or(part.material as usize)
    }

    /// Name of a part: its object's, or its mesh material's if the object has none.
    pub fn part_name(&self, part: Part) -> String {
        match self.objects.get(part.object as usize) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => format!("Part of {}", self.material_name(part.material as usize)),
        }
    }

    /// The parts' materials with another one for some of them.
    pub fn assigning(&self, others: impl IntoIterator<Item = (Part, usize)>) -> Assignment {
        let mut assigned = self.assigned.clone();
        for (part, material) in others {
            if material == part.material as usize {
                assigned.remove(&part);
            } else {
                assigned.insert(part, material);
            }
        }
        assigned
    }

    /// The material of each triangle for renderers; `None` if the mesh's apply.
    pub fn assigned_to(&self, mesh: &Mesh) -> Assigned {
        let is_any = self.added > 0 || !self.assigned.is_empty();
        let of = |triangle| Part::of_triangle(mesh, triangle).map_or(0, |part| self.material_of(part) as u32);
        is_any.then(|| (0..mesh.triangles.len()).map(of).collect())
    }

    /// With materials for the parts whose opacity in a scene differs from their material's.
    pub fn with_opacities_of_parts(mut self, scene: &Scene) -> Self {
        for other in &scene.part_opacities {
            let material = as_added(&self, other.shown(&scene.materials));
            self.assigned.extend(other.parts.iter().map(|&part| (part, self.materials.len())));
            self.materials.push(material);
            self.added += 1;
        }
        self
    }

    /// Gives a scene the opacities of the document.
    pub fn give_opacities(&self, scene: &mut Scene) {
        let assigned = self.assigned.keys().map(|&part| (part, self.material_of(part)));
        scene.take_opacities(&self.materials, self.own_materials(), assigned, &self.shared_textures());
    }

    /// A scene without a mesh but with the document's opacities, for [`bake_hash`].
    pub fn opacities_for(&self, scene: &Scene) -> Scene {
        let Scene { materials, textures, objects, .. } = scene;
        let (materials, textures, objects) = (materials.clone(), textures.clone(), objects.clone());
        let mut found = Scene { materials, textures, objects, ..Scene::default() };
        self.give_opacities(&mut found);
        found
    }

    /// Whether opacities differ from a baked scene's.
    pub fn lets_through_otherwise(&self, scene: &Scene) -> bool {
        let textures = self.shared_textures();
        let shown = |index: usize| self.materials.get(index).map(|material| Opacity::of(material, &textures));
        let own = scene.materials.iter().take(self.own_materials()).enumerate();
        let is_other = |(index, own): (usize, &Material)| shown(index) != Some(Opacity::of(own, &scene.textures));
        let of_scene = scene.part_opacities.iter().flat_map(|other| &other.parts);
        let is_other_part =
            |part: &Part| shown(self.material_of(*part)).is_some_and(|now| now != scene.opacity_of(*part));
        own.into_iter().any(is_other) || self.assigned.keys().chain(of_scene).any(is_other_part)
    }

    /// The shown variant: `Some(None)` for the file's default, `None` for a mixture.
    pub fn shown_variant(&self, variants: &Variants) -> Option<Option<usize>> {
        let is_shown = |variant: &Option<usize>| {
            variants.shown(*variant).all(|(part, material)| self.material_of(part) == material as usize)
        };
        (0..variants.names.len()).map(Some).chain([None]).find(is_shown)
    }

    /// An unused material name: this one, or with a number.
    pub fn free_name(&self, name: &str) -> String {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
        let stem = if stem.is_empty() { "Material" } else { stem };
        let is_free = |name: &String| self.materials.iter().all(|material| material.name != *name);
        let numbered = (2..).map(|number| format!("{stem} {number}"));
        [name.to_owned()].into_iter().filter(|name| !name.is_empty()).chain(numbered).find(is_free).unwrap_or_default()
    }

    /// Renumbers the materials that the document and its looks refer to.
    pub fn renumber_materials(&mut self, renumbering: &Renumbering) {
        renumber(&mut self.assigned, renumbering);
        self.view.renumber_materials(renumbering);
        self.looks.iter_mut().for_each(|look| look.state.renumber_materials(renumbering, &self.materials));
    }
}

impl ViewSettings {
    /// Renumbers the solo material.
    pub fn renumber_materials(&mut self, renumbering: &Renumbering) {
        if let ShownMaterials::Solo(index) = &mut self.materials {
            *index = renumbering.of(*index);
        }
    }
}

/// Renumbers the materials of an assignment.
pub fn renumber(assigned: &mut Assignment, renumbering: &Renumbering) {
    assigned.values_mut().for_each(|material| *material = renumbering.of(*material));
}

/// The scene's own materials in a document: their number, and the ground's among them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnMaterials {
    /// Including the ground's.
    pub count: usize,
    /// Index of the ground's, which is the last, if there is one.
    pub ground: Option<usize>,
}

/// A change in the number of the scene's own materials, which moves the added ones behind them.
#[derive(Clone, Copy, Debug)]
pub struct Renumbering {
    /// The scene's own so far.
    pub before: OwnMaterials,
    /// And now.
    pub after: OwnMaterials,
}

impl Renumbering {
    /// Stands for the material of a hidden ground, and for a material that is gone.
    const HIDDEN_GROUND: usize = usize::MAX;
    const GONE: usize = usize::MAX - 1;

    /// The new index of a material; a removed one gets an unused index.
    pub fn of(&self, index: usize) -> usize {
        let Self { before, after } = *self;
        let is_ground = index == Self::HIDDEN_GROUND || before.ground == Some(index);
        if is_ground {
            after.ground.unwrap_or(Self::HIDDEN_GROUND)
        } else if index == Self::GONE {
            Self::GONE
        } else if index >= before.count {
            index - before.count + after.count
        } else if index < after.count && after.ground != Some(index) {
            index
        } else {
            Self::GONE
        }
    }
}

/// `material` as one that is added: with a name of its own.
pub fn as_added(document: &Document, material: Material) -> Material {
    Material { name: document.free_name(&material.name), ..material }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{parts::PartVariants, scene::Object};

    fn part(object: u32, material: u32) -> Part {
        Part { object, material }
    }

    fn document() -> Document {
        let named = |name: &str| Material { name: name.into(), ..Default::default() };
        let materials = ["Brass", "Wood", "Brass 2"].map(named).to_vec();
        Document { materials, added: 1, objects: vec!["Knob".into(), "Door".into()], ..Document::empty() }
    }

    #[test]
    fn a_part_has_what_it_was_assigned_or_what_the_mesh_says() {
        let mut document = document();
        document.assigned = document.assigning([(part(0, 0), 2), (part(1, 1), 1)]);
        assert_eq!(document.assigned, [(part(0, 0), 2)].into(), "its own material is no assignment");
        assert_eq!([part(0, 0), part(1, 0), part(1, 1)].map(|part| document.material_of(part)), [2, 0, 1]);
        let mesh = Mesh {
            triangles: vec![[0, 1, 2]; 3],
            triangle_material: vec![0, 0, 1],
            triangle_object: vec![0, 1, 1],
            ..Default::default()
        };
        assert_eq!(document.assigned_to(&mesh).as_deref(), Some(&[2, 0, 1][..]));
        document.assigned = document.assigning([(part(0, 0), 0)]);
        assert!(document.assigned.is_empty());
        document.added = 0;
        assert!(document.assigned_to(&mesh).is_none(), "the mesh says it all");
        document.assigned.insert(part(0, 0), 9);
        assert_eq!(document.material_of(part(0, 0)), 0, "one that is not there");
    }

    /// The scene of `document`: knob of brass, door of brass and wood.
    fn scene() -> Scene {
        let objects = ["Knob", "Door"].map(|name| Object { name: name.into() }).to_vec();
        Scene { materials: document().materials[..2].to_vec(), objects, ..Default::default() }
    }

    #[test]
    fn parts_that_let_through_other_light_than_their_bake_are_noticed() {
        let (mut document, mut baked) = (document(), scene());
        document.assigned = [(part(1, 1), 0)].into();
        assert!(!document.lets_through_otherwise(&baked), "all stop all light");
        document.materials[2].parameters.set("geometry_opacity", 0.5);
        assert!(!document.lets_through_otherwise(&baked), "no part has it");
        document.assigned = [(part(1, 1), 2)].into();
        assert!(document.lets_through_otherwise(&baked));
        document.give_opacities(&mut baked);
        assert!(!document.lets_through_otherwise(&baked), "it was baked");
        document.assigned.clear();
        assert!(document.lets_through_otherwise(&baked), "and is undone");
        document.assigned = [(part(1, 1), 2)].into();
        document.materials[2].parameters.set("geometry_opacity", 0.25);
        assert!(document.lets_through_otherwise(&baked), "another opacity");
    }

    #[test]
    fn a_bake_opens_with_the_opacity_of_its_parts() {
        let (mut edited, mut baked) = (document(), scene());
        edited.materials[2].parameters.set("geometry_opacity", 0.5);
        edited.assigned = [(part(0, 0), 2), (part(1, 0), 2), (part(1, 1), 2)].into();
        edited.give_opacities(&mut baked);
        let opened = Document::of_scene(&baked, None);
        let names: Vec<_> = opened.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!((names, opened.added), (vec!["Brass", "Wood", "Brass 2", "Wood 2"], 2));
        assert_eq!(opened.assigned, [(part(0, 0), 2), (part(1, 0), 2), (part(1, 1), 3)].into());
        assert!(!opened.lets_through_otherwise(&baked));
        assert!(Document::of_scene(&scene(), None).lets_through_otherwise(&baked), "negative control");
    }

    #[test]
    fn names_are_numbered_until_one_is_free() {
        let document = document();
        let names = ["Brass", "Brass 2", "Wood", "Gold", ""].map(|name| document.free_name(name));
        assert_eq!(names, ["Brass 3", "Brass 3", "Wood 2", "Gold", "Material 2"]);
    }

    #[test]
    fn what_was_added_moves_behind_a_ground_and_back() {
        let [bare, grounded] =
            [None, Some(2)].map(|ground| OwnMaterials { count: 2 + ground.map_or(0, |_| 1), ground });
        let shown = Renumbering { before: bare, after: grounded };
        let hidden = Renumbering { before: grounded, after: bare };
        assert_eq!([0, 1, 2, 3].map(|index| shown.of(index)), [0, 1, 3, 4]);
        for index in [0, 1, 2, 3, 4] {
            assert_eq!(shown.of(hidden.of(index)), index, "the ground's too");
        }
        assert!(hidden.of(2) > 1000, "negative control: no other material is taken for that of the ground");
        let fewer = Renumbering { before: bare, after: OwnMaterials { count: 1, ground: None } };
        assert_eq!((fewer.of(0), fewer.of(2)), (0, 1));
        assert!(fewer.of(1) > 1000 && shown.of(fewer.of(1)) > 1000, "what is gone stays so");
    }

    #[test]
    fn a_variant_is_shown_while_all_its_parts_are() {
        let mut document = document();
        let looks = |of, in_variants: &[u32]| PartVariants { part: of, plain: 0, in_variants: in_variants.to_vec() };
        let parts = vec![looks(part(0, 0), &[0, 1]), looks(part(1, 0), &[1, 1])];
        let variants = Variants { names: vec!["red".into(), "blue".into()], parts };
        assert_eq!(document.shown_variant(&variants), Some(None));
        for variant in [Some(0), Some(1), None] {
            let shown = variants.shown(variant).map(|(part, material)| (part, material as usize));
            document.assigned = document.assigning(shown);
            assert_eq!(document.shown_variant(&variants), Some(variant));
        }
        document.assigned = document.assigning([(part(0, 0), 2)]);
        assert_eq!(document.shown_variant(&variants), None, "a mixture");
    }
}
