//! Every shader parses and is valid as it is joined; every struct and constant that both sides share is the same.

use crate::{
    device::{
        ModelSet, ShaderSource, kernels,
        layout::{self, constants},
        shaders::Program,
    },
    gpu::entries,
};
use lapidary_core::implicit;
use lapidary_core::{
    brdf::{BrdfModel, MIN_ALPHA, SurfaceParameters},
    implicit::forest::nodes::Block,
};
use naga::{
    Literal, Module, TypeInner,
    valid::{Capabilities, ValidationFlags, Validator},
};
use std::mem::offset_of;

fn programs() -> impl Iterator<Item = Program> {
    kernels::programs().chain(entries::ALL.map(|entry| entry.program))
}

fn modules() -> Vec<(&'static str, Module)> {
    let parse = |program: Program| {
        let text = ShaderSource::Embedded.text(&program, &ModelSet::all()).unwrap();
        let module = naga::front::wgsl::parse_str(&text);
        (program.name, module.unwrap_or_else(|e| panic!("{}: {}", program.name, e.emit_to_string(&text))))
    };
    programs().map(parse).collect()
}

#[test]
fn every_program_is_valid_without_optional_features() {
    let modules = modules();
    assert!(!modules.is_empty());
    let failures: Vec<String> = modules
        .iter()
        .filter_map(|(name, module)| {
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
            validator.validate(module).err().map(|e| format!("{name}: {e:?}"))
        })
        .collect();
    assert!(failures.is_empty(), "{failures:#?}");
    for (program, (name, module)) in programs().zip(&modules) {
        let is_kernel = kernels::programs().any(|kernel| kernel.name == *name);
        let expected = match program.output {
            Some(_) => 3,
            None if is_kernel => 1,
            None => 2,
        };
        assert_eq!(module.entry_points.len(), expected, "{name}");
    }
}

#[test]
fn validation_finds_a_broken_program() {
    let text = ShaderSource::Embedded
        .text(&entries::DISPLAY.program, &ModelSet::all())
        .unwrap()
        .replace("return vec4(with_lines(", "return vec3(with_lines(");
    let valid = naga::front::wgsl::parse_str(&text)
        .is_ok_and(|m| Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&m).is_ok());
    assert!(!valid);
}

#[test]
fn programs_are_read_from_a_folder_as_from_the_binary() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let source = ShaderSource::Folder(folder);
    for program in programs() {
        assert_eq!(
            source.text(&program, &ModelSet::all()).unwrap(),
            ShaderSource::Embedded.text(&program, &ModelSet::all()).unwrap()
        );
    }
    let files = source.files();
    assert!(!files.is_empty() && files.iter().all(|f| f.is_file()));
    assert!(ShaderSource::Folder("nowhere".into()).text(&entries::DISPLAY.program, &ModelSet::all()).is_err());
}

/// Name and offset of each member, and the size.
type Shape = (Vec<(String, u32)>, u32);

fn shape_in(modules: &[(&str, Module)], name: &str) -> Vec<Shape> {
    let structs = modules.iter().flat_map(|(_, m)| m.types.iter()).filter(|(_, t)| t.name.as_deref() == Some(name));
    structs
        .filter_map(|(_, t)| match &t.inner {
            TypeInner::Struct { members, span } => {
                let members = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect();
                Some((members, *span))
            }
            _ => None,
        })
        .collect()
}

macro_rules! shape {
    ($type:ty, $($member:ident),*) => {
        (vec![$((stringify!($member).to_owned(), offset_of!($type, $member) as u32)),*], size_of::<$type>() as u32)
    };
}

fn rust_shapes() -> Vec<(&'static str, Shape)> {
    vec![
        (
            "FrameUniforms",
            shape!(
                layout::FrameUniforms,
                clip_from_world,
                world_from_view,
                eye,
                tan_half_fov,
                pixel_offset,
                size,
                background_color,
                background,
                environment_turn,
                environment_intensity,
                leaf_solid_angle,
                tree_height,
                view_mode,
                wireframe,
                source_tree_height,
                sample,
                catcher,
                stride,
                caught_color,
                caught,
                caught_per_radiance,
                lets_light_through,
                share_weights,
                mirrored_height,
                shows_emission,
                sample_distance,
                seen,
                brightest,
                picture_sample,
                of_lobe,
                picture_stride,
                center,
                padding
            ),
        ),
        (
            "Vertex",
            shape!(
                layout::Vertex,
                position,
                cut_offset,
                normal,
                cut_len,
                tangent,
                handedness,
                uv,
                is_valid,
                source_cut_offset,
                second_uv,
                color
            ),
        ),
        ("Triangle", shape!(layout::Triangle, vertices, material)),
        (
            "TextureSlot",
            shape!(
                layout::TextureSlot,
                first,
                width,
                height,
                kind,
                scale,
                offset,
                turn,
                strength,
                lookup,
                low,
                pattern,
                high,
                octaves
            ),
        ),
        (
            "Material",
            shape!(layout::Material, model, reads, surface, table, estimate, normal_map, bump_map, parameters),
        ),
        ("Tables", shape!(layout::Tables, linear_from_srgb, albedo)),
        ("MaterialParameter", shape!(layout::MaterialParameter, value, has_vertex_color, map)),
        ("PastUniforms", shape!(layout::PastUniforms, world_from_view, eye, focal, center, size)),
        ("BoxNode", shape!(layout::BoxNode, low, first, high, triangles)),
        ("RayUniforms", shape!(layout::RayUniforms, directions, words)),
        (
            "BoundaryUniforms",
            shape!(layout::BoundaryUniforms, directions, words, groups, groups_per_block, places, starts),
        ),
        ("FanUniforms", shape!(layout::FanUniforms, directions)),
        ("Fan", shape!(layout::Fan, frame, origin)),
        ("ShadowRayUniforms", shape!(layout::ShadowRayUniforms, rays)),
        ("ShadowRay", shape!(layout::ShadowRay, origin, reach, direction, padding)),
        ("FanHit", shape!(layout::FanHit, triangle, distance, barycentric)),
        ("RayOrigin", shape!(layout::RayOrigin, origin, height, normal, is_above)),
        ("LitUniforms", shape!(layout::LitUniforms, cuts, tau, tree_height)),
        (
            "TurnedUniforms",
            shape!(
                layout::TurnedUniforms,
                columns,
                shift,
                fraction,
                samples_per_steradian,
                intensity,
                leaves,
                leaf_spread
            ),
        ),
        ("Means", shape!(layout::Means, radiance, luminance_sq, weighted, luminance)),
        ("MeansUniforms", shape!(layout::MeansUniforms, parents)),
        ("Slice", (vec![("first".into(), 0)], size_of::<u32>() as u32)),
        ("Disc", shape!(layout::Disc, position, area, normal, padding)),
        ("Block", shape!(Block, center, axis, coherence, area, radius, thickness, cone_cos, cone_sin, below)),
        ("Rider", shape!(layout::Rider, corners, share, barycentric, is_back, padding)),
        (
            "WalkUniforms",
            shape!(layout::WalkUniforms, first_leaf, root_blocks, limit, scale, turn, has_kept, closes, side, padding),
        ),
        ("LightUniforms", shape!(layout::LightUniforms, turn, sends, side)),
        ("LeafLighting", shape!(layout::LeafLighting, reflectance, emitted, received)),
        ("LeafIrradiance", shape!(layout::LeafIrradiance, of_sky, direct, bounced, last)),
        ("GlossyLeaf", shape!(layout::GlossyLeaf, tangent, leaf, bitangent, model, normal, first)),
        ("GlossUniforms", shape!(layout::GlossUniforms, eye, side, turn, has_sent, padding)),
        ("Reflected", shape!(layout::Reflected, sky, faces_eye, leaves, irradiance)),
        ("LeafUniforms", shape!(layout::LeafUniforms, weighs_albedo, has_reflected)),
        ("LeafValue", shape!(layout::LeafValue, sky, open, others, weight)),
        ("VertexUniforms", shape!(layout::VertexUniforms, plane, is_as_baked)),
        ("LevelUniforms", shape!(layout::LevelUniforms, first, end, enough)),
        ("RowUniforms", shape!(layout::RowUniforms, rays, solid_angle, first_slot, slots)),
        ("Node", shape!(layout::Node, radiance, spread, place, radius)),
        (
            "ShadowView",
            shape!(layout::ShadowView, origin, depth_scale, right, half_width, up, half_height, forward, padding),
        ),
        (
            "LocalLight",
            shape!(
                layout::LocalLight,
                position,
                emission,
                forward,
                first_view,
                intensity,
                views_per_point,
                half_width,
                cos_edge,
                half_height,
                cos_full,
                area,
                grid,
                padding
            ),
        ),
        ("BasisLevel", shape!(layout::BasisLevel, cells_per_metre, radius, end, padding)),
        (
            "BasisUniforms",
            shape!(
                layout::BasisUniforms,
                levels,
                level_count,
                last_slot,
                shown_level,
                shown_function,
                of_objects,
                directional_levels
            ),
        ),
        ("Cell", shape!(lapidary_core::meshless::Cell, place, level, first, count, padding)),
        ("CutUniforms", shape!(layout::CutUniforms, least, turn, side, height, first_texel, padding, more_padding)),
        ("LeafBeside", shape!(layout::LeafBeside, leaf, weight)),
        ("CutVertex", shape!(layout::CutVertex, number, first, end)),
        ("BasisFunction", shape!(layout::BasisFunction, position, normal)),
        ("LitQuad", shape!(layout::LitQuad, corner, first, square_u, side, square_v, cells, frame)),
        ("Coefficient", shape!(layout::Coefficient, vector)),
        ("StaleMarks", shape!(layout::StaleMarks, materials, patches)),
        (
            "Display",
            shape!(
                layout::Display,
                exposure,
                count_top,
                tone_map,
                view_mode,
                transparent,
                lets_light_through,
                samples,
                vignette
            ),
        ),
        ("Sun", shape!(layout::Sun, axis, height, right, sine, up, tangent)),
        ("SunUniforms", shape!(layout::SunUniforms, suns, count, largest_offset, padding)),
        ("MirroredScene", shape!(layout::MirroredScene, ground, shows_ground, largest_offset, padding)),
    ]
}

#[test]
fn shared_structs_have_the_same_members_offsets_and_sizes() {
    let modules = modules();
    for (name, expected) in rust_shapes() {
        let found = shape_in(&modules, name);
        assert!(!found.is_empty(), "no shader has a struct {name}");
        assert!(found.iter().all(|shape| *shape == expected), "{name}: {found:?}, but {expected:?}");
    }
    // The comparison sees a difference.
    let (members, size) = &rust_shapes()[0].1;
    let moved = (members.iter().map(|(n, o)| (n.clone(), o + 4)).collect::<Vec<_>>(), *size);
    assert!(shape_in(&modules, "FrameUniforms").iter().all(|shape| *shape != moved));
}

/// Types of buffers without a struct of their own: radii, patches, stops of a color scale, the table of sRGB, areas, counts, texels.
const PLAIN: [&str; 10] = [
    "array<Float32>",
    "array<Uint32>",
    "array<vec2<Uint32>>",
    "array<vec4<Float32>>",
    "array<vec4<Float32>, 16>",
    "array<vec4<Float32>, 64>",
    "array<vec4<Uint32>, 256>",
    "array<vec4<Uint32>>",
    "array<atomic<Uint32>>",
    "atomic<Uint32>",
];

/// Names of the structs, and plain types, that a buffer of the shaders holds.
fn held_by(module: &Module, buffer: naga::Handle<naga::Type>, held: &mut Vec<String>) {
    match &module.types[buffer].inner {
        TypeInner::Struct { members, .. } => {
            held.push(module.types[buffer].name.clone().unwrap_or_default());
            let structs = members.iter().map(|m| m.ty);
            structs.filter(|ty| holds_struct(module, *ty)).for_each(|ty| held_by(module, ty, held));
        }
        TypeInner::Array { base, .. } if holds_struct(module, *base) => held_by(module, *base, held),
        TypeInner::Array { base, size, .. } => {
            let words = |scalar: &naga::Scalar| format!("{:?}{}", scalar.kind, 8 * scalar.width);
            let element = match &module.types[*base].inner {
                TypeInner::Scalar(scalar) => words(scalar),
                TypeInner::Vector { size, scalar } => format!("vec{}<{}>", *size as u32, words(scalar)),
                TypeInner::Atomic(scalar) => format!("atomic<{}>", words(scalar)),
                other => format!("{other:?}"),
            };
            held.push(match size {
                naga::ArraySize::Constant(count) => format!("array<{element}, {count}>"),
                _ => format!("array<{element}>"),
            });
        }
        TypeInner::Atomic(scalar) => held.push(format!("atomic<{:?}{}>", scalar.kind, 8 * scalar.width)),
        other => held.push(format!("{other:?}")),
    }
}

fn holds_struct(module: &Module, ty: naga::Handle<naga::Type>) -> bool {
    match &module.types[ty].inner {
        TypeInner::Struct { .. } => true,
        TypeInner::Array { base, .. } => holds_struct(module, *base),
        _ => false,
    }
}

/// What the buffers of a module hold that no Rust type is compared with.
fn unknown_types(module: &Module, known: &[&str]) -> Vec<String> {
    let buffers = module.global_variables.iter().map(|(_, variable)| variable);
    let shared = |space| matches!(space, naga::AddressSpace::Uniform | naga::AddressSpace::Storage { .. });
    let mut held = Vec::new();
    buffers.filter(|variable| shared(variable.space)).for_each(|variable| held_by(module, variable.ty, &mut held));
    held.retain(|name| !known.contains(&name.as_str()) && !PLAIN.contains(&name.as_str()));
    held
}

#[test]
fn every_buffer_of_the_shaders_holds_types_that_are_compared() {
    let (modules, shapes) = (modules(), rust_shapes());
    let known: Vec<&str> = shapes.iter().map(|(name, _)| *name).collect();
    for (program, module) in &modules {
        let unknown = unknown_types(module, &known);
        assert!(unknown.is_empty(), "{program}: {unknown:?} are compared with no Rust type");
    }
    for left_out in ["TextureSlot", "Node"] {
        let fewer: Vec<&str> = known.iter().copied().filter(|name| *name != left_out).collect();
        let found = modules.iter().any(|(_, module)| unknown_types(module, &fewer).iter().any(|name| name == left_out));
        assert!(found, "negative control: {left_out}");
    }
}

/// A scalar constant of the shaders, in full precision.
fn constant(modules: &[(&str, Module)], name: &str) -> Vec<f64> {
    let find = |m: &Module| {
        let (_, c) = m.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name))?;
        match m.global_expressions[c.init] {
            naga::Expression::Literal(Literal::F32(x)) => Some(f64::from(x)),
            naga::Expression::Literal(Literal::U32(x)) => Some(f64::from(x)),
            _ => None,
        }
    };
    modules.iter().filter_map(|(_, m)| find(m)).collect()
}

#[test]
fn shared_constants_have_the_same_values() {
    let modules = modules();
    let mut expected: Vec<(String, f64)> = [
        &crate::shade::refine::CONSTANTS[..],
        &crate::shade::mirror::CONSTANTS,
        &crate::shade::mirror::rays::CONSTANTS,
        &crate::shade::mirrors::cone::CONSTANTS,
        &crate::cpu::picture::smoothed::CONSTANTS,
    ]
    .concat()
    .into_iter()
    .map(|(n, x)| (n.into(), x.into()))
    .collect();
    for (name, value) in [
        ("BACKGROUND_MAP", constants::BACKGROUND_MAP),
        ("BACKGROUND_FLAT", constants::BACKGROUND_FLAT),
        ("TWO_SIDED", constants::TWO_SIDED),
        ("FIELD_NONE", constants::FIELD_NONE),
        ("FIELD_ENVIRONMENT", constants::FIELD_ENVIRONMENT),
        ("FIELD_SOURCES", constants::FIELD_SOURCES),
        ("NO_MIRRORS", constants::NO_MIRRORS),
        ("MIRRORS_READ_MAP", constants::MIRRORS_READ_MAP),
        ("MIRRORS_HAVE_RAYS", constants::MIRRORS_HAVE_RAYS),
        ("SEEN_WITH_MIRRORS", constants::SEEN_WITH_MIRRORS),
        ("SEEN_IN_MIRRORS", constants::SEEN_IN_MIRRORS),
        ("EMISSION_POINT", constants::EMISSION_POINT),
        ("EMISSION_SPOT", constants::EMISSION_SPOT),
        ("EMISSION_DIRECTIONAL", constants::EMISSION_DIRECTIONAL),
        ("EMISSION_RECTANGLE", constants::EMISSION_RECTANGLE),
        ("NO_SHADOW", constants::NO_SHADOW),
        ("KERNEL_RADIUS", constants::KERNEL_RADIUS),
        ("KIND_LINEAR", constants::KIND_LINEAR),
        ("KIND_SRGB", constants::KIND_SRGB),
        ("KIND_FLOAT", constants::KIND_FLOAT),
        ("KIND_PROCEDURAL", constants::KIND_PROCEDURAL),
        ("PATTERN_CHECKER", lapidary_core::texture::Pattern::Checker as u32),
        ("PATTERN_NOISE", lapidary_core::texture::Pattern::Noise as u32),
        ("NOISE_CELLS", lapidary_core::texture::NOISE_CELLS),
        ("POOL_WIDTH_LOG2", constants::POOL_WIDTH_LOG2),
        ("MOST_PARAMETERS", constants::MOST_PARAMETERS as u32),
        ("MOST_SUNS", constants::MOST_SUNS as u32),
        ("MOST_DIRECTIONS", constants::MOST_DIRECTIONS as u32),
        ("MOVED", constants::MOVED),
        ("SENDS_LAST", constants::SENDS_LAST),
        ("SENDS_EMISSION", constants::SENDS_EMISSION),
        ("SENDS_ALL", constants::SENDS_ALL),
        ("VERTEX_IS_OPEN", constants::VERTEX_IS_OPEN),
        ("VERTEX_IS_MOVED", constants::VERTEX_IS_MOVED),
        ("VERTEX_HAS_NEW_CUT", constants::VERTEX_HAS_NEW_CUT),
        ("POSED_PLANES", constants::POSED_PLANES),
        ("POSED_GROWTH", constants::POSED_GROWTH),
        ("POSED_BOUNCE", constants::POSED_BOUNCE),
        ("POSED_UNCOVERED", constants::POSED_UNCOVERED),
        ("FULL_SHARE", lapidary_core::ray::OPEN.into()),
        ("MOST_AREAS", constants::MOST_AREAS as u32),
        ("TILE_SIDE", constants::TILE_SIDE),
        ("MOST_BASIS_LEVELS", constants::MOST_BASIS_LEVELS as u32),
        ("CELL_SIDE", crate::light::bounce::meshless::gloss::CELLS.side as u32),
        ("SENT_SIDE", crate::light::sent::KNOTS.side as u32),
        ("SENT_COLUMNS", crate::gpu::light::SENT_COLUMNS as u32),
        ("CUT_WIDTH_LOG2", lapidary_core::cut::packed::TEXTURE_WIDTH.ilog2()),
    ] {
        expected.push((name.into(), value.into()));
    }
    expected.extend(implicit::CONSTANTS.map(|(name, value)| (name.into(), value.into())));
    expected.extend(implicit::WHOLE_CONSTANTS.map(|(name, value)| (name.into(), value.into())));
    for (name, value) in [
        ("MIN_ALPHA", MIN_ALPHA),
        ("MOST_LUMINANCE", SurfaceParameters::LIST[0].range[1]),
        ("MOST_TAPS", lapidary_core::texture::MOST_TAPS as f32),
        ("TEXELS_PER_WIDTH", lapidary_core::texture::TEXELS_PER_WIDTH),
        ("FRAC_1_PI", std::f32::consts::FRAC_1_PI),
        ("FRAC_2_PI", std::f32::consts::FRAC_2_PI),
        ("PI", std::f32::consts::PI),
        ("OCTAHEDRON_SIDE", lapidary_core::sphere::octahedron::SIDE as f32),
        ("LARGEST_SOLID_ANGLE", lapidary_core::cut::LARGEST_SOLID_ANGLE),
        ("LEAST_DISTANCE", crate::shade::node_field::LEAST_DISTANCE),
        ("LINE_WIDTH", crate::shade::wireframe::LINE_WIDTH),
        ("LINE_FADE", crate::shade::wireframe::LINE_FADE),
        ("LINE_OPACITY", crate::shade::wireframe::LINE_OPACITY),
        ("LEAST_ALBEDO", crate::sketch::LEAST_ALBEDO),
        ("LEAST_GLOSSY_ALBEDO", crate::light::implicit::gloss::LEAST_GLOSSY_ALBEDO),
        ("LEAST_OPEN", crate::light::implicit::covered::LEAST_OPEN),
        ("MOST_GROWTH", crate::light::implicit::MOST_GROWTH),
        ("LEAST_SHARE", crate::sketch::LEAST_SHARE),
        ("OTHER", crate::sketch::OTHER),
        ("SQUASH", lapidary_core::surfel::distance::SQUASH),
        ("LAYERS", lapidary_core::surfel::distance::LAYERS),
        ("LEAST_WEIGHT", lapidary_core::surfel::distance::LEAST_WEIGHT),
        ("POINT_RADIUS", crate::light::bounce::meshless::functions::POINT_RADIUS),
        ("BASIS_GREY", crate::shade::painter::BASIS_GREY),
    ] {
        expected.push((name.into(), value.into()));
    }
    for (i, mode) in crate::ViewMode::ALL.into_iter().enumerate() {
        assert_eq!(mode as usize, i);
    }
    let modes = [
        "SHADED",
        "NORMALS",
        "ALBEDO",
        "ROUGHNESS",
        "VISIBILITY_CUT",
        "MERGED_CUT",
        "BRDF_EVALUATIONS",
        "BASIS_LEVEL",
        "BASIS_FUNCTION",
        "BASIS_COEFFICIENTS",
        "GLOSS",
    ];
    expected.extend(modes.iter().enumerate().map(|(i, name)| (format!("VIEW_{name}"), i as f64)));
    expected.extend(
        [
            ("MODE_SHADED", 0.0),
            ("MODE_ALBEDO", 2.0),
            ("MODE_VISIBILITY_CUT", 4.0),
            ("MODE_BRDF_EVALUATIONS", 6.0),
            ("MODE_BASIS_LEVEL", 7.0),
            ("MODE_GLOSS", 10.0),
        ]
        .map(|(n, x)| (n.into(), x)),
    );
    let model = |&m: &BrdfModel| (format!("MODEL_{}", m.key().replace('-', "_").to_uppercase()), f64::from(m as u32));
    expected.extend(BrdfModel::ALL.iter().map(model));
    for (name, value) in &expected {
        let found = constant(&modules, name);
        assert!(!found.is_empty(), "no shader has a constant {name}");
        assert!(found.iter().all(|x| (x - value).abs() < 1e-9), "{name} is {found:?}, but {value}");
    }
    assert!(constant(&modules, "NO_SUCH_CONSTANT").is_empty());
}
