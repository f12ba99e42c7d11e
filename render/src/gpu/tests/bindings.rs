//! Bind groups as entries declare them, against those of the shaders: names and kinds.

use crate::{
    device::{
        Binding, GroupLayout, ModelSet, ShaderSource,
        kernels::{self, BOUNDARIES, BoundaryWork, FANS, FanWork, Hierarchy, RAYS, RayWork, Slice},
        shaders::Program,
    },
    gpu::entries,
};
use naga::{
    AddressSpace, ImageClass, Module, ScalarKind, StorageAccess, StorageFormat, TypeInner,
    valid::{Capabilities, ValidationFlags, Validator},
};

/// All programs with their groups 0, 1, ...
fn declared() -> Vec<(Program, Vec<GroupLayout>)> {
    let sliced = kernels::SLICED.map(|kernel| (kernel.program, [&[Slice::LAYOUT], kernel.groups].concat()));
    let drawing = entries::ALL.map(|entry| {
        let last = entry.groups.iter().skip(1).copied();
        (entry.program, entry.program.output.or(entry.groups.first().copied()).into_iter().chain(last).collect())
    });
    let rays = (RAYS, vec![Hierarchy::LAYOUT, RayWork::LAYOUT]);
    let boundaries = (BOUNDARIES, vec![Hierarchy::LAYOUT, BoundaryWork::LAYOUT]);
    let fans = (FANS, vec![Hierarchy::LAYOUT, FanWork::LAYOUT]);
    sliced.into_iter().chain(drawing).chain([rays, boundaries, fans]).collect()
}

fn kind(module: &Module, variable: &naga::GlobalVariable) -> Option<Binding> {
    match (variable.space, &module.types[variable.ty].inner) {
        (AddressSpace::Uniform, _) => Some(Binding::Uniform),
        (AddressSpace::Storage { access }, _) if access.contains(StorageAccess::STORE) => Some(Binding::Written),
        (AddressSpace::Storage { .. }, _) => Some(Binding::Storage),
        (_, TypeInner::Image { class: ImageClass::Storage { format, .. }, .. }) => match format {
            StorageFormat::Rgba32Float => Some(Binding::WrittenFloats),
            StorageFormat::Rgba32Uint => Some(Binding::WrittenUints),
            _ => None,
        },
        (_, TypeInner::Image { class: ImageClass::Depth { .. }, arrayed: true, .. }) => Some(Binding::DepthLayers),
        (_, TypeInner::Image { class: ImageClass::Sampled { kind: ScalarKind::Uint, .. }, .. }) => Some(Binding::Uint),
        (_, TypeInner::Image { class: ImageClass::Sampled { kind: ScalarKind::Float, .. }, .. }) => {
            Some(Binding::Float)
        }
        _ => None,
    }
}

/// What the entry points of a program read and write that its groups declare otherwise.
fn undeclared(program: Program, groups: &[GroupLayout]) -> Vec<String> {
    let text = ShaderSource::Embedded.text(&program, &ModelSet::all()).unwrap();
    let module = naga::front::wgsl::parse_str(&text).unwrap();
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap();
    let is_used = |handle: naga::Handle<naga::GlobalVariable>| {
        (0..module.entry_points.len()).any(|i| !info.get_entry_point(i)[handle].is_empty())
    };
    let used = module.global_variables.iter().filter(|(handle, _)| is_used(*handle)).map(|(_, variable)| variable);
    let bound = used.filter_map(|variable| Some((variable.binding?, variable.name.as_deref()?, variable)));
    bound
        .filter(|(place, name, variable)| {
            let group = groups.get(place.group as usize);
            let declared = group.and_then(|group| group.bindings.get(place.binding as usize));
            declared.is_none_or(|(declared, of_kind)| declared != name || kind(&module, variable) != Some(*of_kind))
        })
        .map(|(place, name, _)| format!("{}: {name} at {place:?}", program.name))
        .collect()
}

#[test]
fn bind_groups_have_the_names_and_kinds_of_the_shaders() {
    let declared = declared();
    let wrong: Vec<String> = declared.iter().flat_map(|(program, groups)| undeclared(*program, groups)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    for (program, groups) in &declared {
        let turned: Vec<GroupLayout> = groups.iter().rev().copied().collect();
        assert!(groups.len() < 2 || !undeclared(*program, &turned).is_empty(), "negative control: {}", program.name);
    }
}
