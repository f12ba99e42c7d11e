//! The features of glTF.

use super::{
    super::{Feature, Support},
    Approximated, LeftOut, Read, Unneeded,
};

const fn feature(keys: &'static str, name: &'static str, support: Support) -> Feature {
    super::feature(super::Format::Gltf, keys, name, support)
}

/// Primitives that are no surfaces.
pub(crate) const LINES: Feature = feature("", "points or lines", LeftOut("convert them to surfaces"));
/// Cameras without a perspective.
pub(crate) const ORTHOGRAPHIC: Feature = feature("", "orthographic lenses", LeftOut("use perspective cameras"));
/// The end of a light.
pub(crate) const RANGES: Feature = feature("range", "ends of light", LeftOut("light has no end"));
/// A normal map of a coat.
pub(crate) const COAT_NORMALS: Feature =
    feature("clearcoatNormalTexture", "normal maps of their coats", LeftOut("a coat has the normals of its base"));
/// A map of the stretch and direction of highlights.
pub(crate) const ANISOTROPY_MAPS: Feature =
    feature("anisotropyTexture", "maps of anisotropy", LeftOut("the highlight is stretched the same everywhere"));
/// A map of transmission.
pub(crate) const TRANSMISSION_MAPS: Feature =
    feature("transmissionTexture", "maps of transmission", LeftOut("they show opaque"));

/// Copies of meshes that no node places. They are shapes: a file that needs them is not shown without.
pub(crate) const INSTANCES: Feature = feature(
    "EXT_mesh_gpu_instancing",
    "instances in lists",
    LeftOut("a file that requires it is refused; make them nodes"),
);
/// Further colors of vertices.
pub(crate) const FURTHER_COLORS: Feature =
    feature("COLOR_1", "further sets of colors of vertices", LeftOut("the first set shows alone"));
/// Morph targets of what is no shape.
pub(crate) const TARGETS_OF_LOOKS: Feature =
    feature("", "morph targets of colors and texture coordinates", LeftOut("these stay as at rest"));

pub(super) const ALL: [Feature; 53] = [
    feature("", "version 2.0; buffers and pictures beside it, embedded or in a GLB", Read),
    feature("", "version 1.0", LeftOut("such a file is refused; convert it with the program gltf-pipeline")),
    feature("scenes", "scenes", Approximated("one is shown; choose another in the *Scene* tab, or by `--scene`")),
    feature("nodes", "the hierarchy of nodes, with mirrored ones", Read),
    feature("", "triangles, strips and fans; sparse accessors; accessors without data", Read),
    LINES,
    feature("NORMAL TANGENT TEXCOORD_0", "normals, tangents and texture coordinates", Read),
    feature("COLOR_0", "colors of vertices", Read),
    FURTHER_COLORS,
    feature("", "transparency of vertices", LeftOut("bake it to a texture of opacity")),
    feature("TEXCOORD_1", "second sets of texture coordinates", Read),
    feature("TEXCOORD_2", "further sets of texture coordinates", Approximated("their maps show with the first set")),
    feature("KHR_mesh_quantization", "quantized meshes", Read),
    feature("KHR_draco_mesh_compression EXT_meshopt_compression KHR_meshopt_compression", "compressed meshes", Read),
    INSTANCES,
    feature("JOINTS_0 WEIGHTS_0", "skins, with up to 64 sets of joints", Read),
    feature("targets", "morph targets of positions, normals and tangents", Read),
    TARGETS_OF_LOOKS,
    feature("animations", "animations of nodes, skins and morph targets", Read),
    feature("KHR_animation_pointer", "animations of materials, lights and cameras", Approximated("they stay at rest")),
    feature("cameras", "perspective cameras", Read),
    feature(
        "aspectRatio znear zfar",
        "the frame and depth of cameras",
        Unneeded("a picture has its own size, and no end in depth"),
    ),
    ORTHOGRAPHIC,
    feature(
        "KHR_lights_punctual",
        "lights",
        Approximated("candela are taken for W/sr and lux for W/m², at most 4,096 lights"),
    ),
    RANGES,
    feature("EXT_lights_image_based", "environments", LeftOut("load them as pictures")),
    feature("pbrMetallicRoughness", "base color, metalness, roughness and their maps", Read),
    feature("normalTexture emissiveTexture", "normal maps and emission", Read),
    feature("occlusionTexture", "maps of occlusion", LeftOut("occlusion is computed")),
    feature("alphaMode", "opacity by `MASK` and `BLEND`", Read),
    feature("doubleSided", "two-sided materials", Read),
    feature("sampler", "textures that repeat, are clamped or mirrored", Read),
    feature("magFilter minFilter", "filters of textures", Unneeded("maps are filtered over the footprint of a sample")),
    feature("KHR_texture_transform", "placement of textures", Read),
    feature("KHR_materials_variants", "variants of materials", Read),
    feature("KHR_materials_emissive_strength KHR_materials_ior", "strong emission, and index of refraction", Read),
    feature(
        "KHR_materials_specular",
        "weight and color of highlights",
        Approximated("a gray color changes the index of refraction, which keeps the mean reflectance"),
    ),
    feature("KHR_materials_clearcoat", "coats", Read),
    COAT_NORMALS,
    feature("KHR_materials_sheen", "sheen", Read),
    feature(
        "KHR_materials_anisotropy",
        "stretched highlights",
        Approximated("a direction snaps to the tangent or across it"),
    ),
    ANISOTROPY_MAPS,
    feature(
        "KHR_materials_transmission",
        "transmission",
        Approximated("light passes straight on, as through a thin sheet"),
    ),
    TRANSMISSION_MAPS,
    feature(
        "KHR_materials_pbrSpecularGlossiness",
        "materials of specular color and glossiness",
        Approximated("converted to metalness and roughness, with the mean of their map"),
    ),
    feature(
        "KHR_materials_volume KHR_materials_volume_scatter KHR_materials_diffuse_transmission",
        "light inside bodies",
        LeftOut("bodies show as thin sheets"),
    ),
    feature(
        "KHR_materials_iridescence KHR_materials_dispersion",
        "thin films and dispersion",
        LeftOut("highlights have no rainbow"),
    ),
    feature("KHR_materials_unlit", "unlit materials", LeftOut("they are lit as others; make them emissive")),
    feature("EXT_texture_webp KHR_texture_basisu", "pictures in WebP and KTX2", Read),
    feature("EXT_texture_avif MSFT_texture_dds", "pictures of other formats", LeftOut("export them as PNG or JPEG")),
    feature(
        "KHR_node_visibility MSFT_lod",
        "hidden nodes, and nodes for other distances",
        LeftOut("all of them show; delete those that should not"),
    ),
    feature("KHR_xmp_json_ld KHR_xmp", "metadata", Unneeded("they do not change the picture")),
    feature("extras", "data of other programs", Unneeded("they have no meaning here")),
];
