//! The list of features. Change a line when the code changes; `guide_has_the_table` writes the guide anew.

use super::{
    Feature,
    Format::{self, Material, MaterialX, Mtl, Obj, Picture, Ply},
    Support::{self, Approximated, LeftOut, Read, Unneeded},
};

pub(crate) mod gltf;

/// The features of all formats.
pub(super) const ALL: [&[Feature]; 7] = [&gltf::ALL, &OBJ, &MTL, &PLY, &MATERIALX, &MATERIAL, &PICTURES];

const fn feature(format: Format, keys: &'static str, name: &'static str, support: Support) -> Feature {
    Feature { format, keys, name, support }
}

const POLYGONS: Support = LeftOut("convert them to polygons in the program that made them");

const OBJ: [Feature; 13] = [
    feature(Obj, "v", "positions; a fourth number divides them", Read),
    feature(Obj, "vt vn", "texture coordinates and normals; those on some faces only are rebuilt", Read),
    feature(Obj, "f", "polygons with any number of corners, also concave; negative numbers", Read),
    feature(Obj, "o g", "objects and groups; each name is an object", Read),
    feature(Obj, "s", "smoothing groups and `s off`", Read),
    feature(Obj, "usemtl mtllib", "materials and their libraries", Read),
    feature(Obj, "", "colors of vertices, in sRGB from 0 to 1 or to 255", Read),
    feature(Obj, "l p", "lines and points", LeftOut("give them a thickness in the modelling program")),
    feature(
        Obj,
        "cstype vp bmat deg step curv curv2 surf parm trim hole scrv sp end con bzp bsp",
        "curves and surfaces of free form",
        POLYGONS,
    ),
    feature(Obj, "maplib usemap", "maps of faces", LeftOut("name the picture in the material (map_Kd)")),
    feature(Obj, "call csh", "calls of other files", LeftOut("join the files to one in the program that made them")),
    feature(
        Obj,
        "shadow_obj trace_obj",
        "other objects in shadows and reflections",
        LeftOut("shadows and reflections are those of the object itself"),
    ),
    feature(
        Obj,
        "mg lod bevel c_interp d_interp ctech stech",
        "settings of curves and of other renderers",
        Unneeded("faces are shown whole"),
    ),
];

const MTL: [Feature; 26] = [
    feature(Mtl, "newmtl", "materials by name", Read),
    feature(Mtl, "Kd map_Kd", "colors", Read),
    feature(
        Mtl,
        "Ks map_Ks",
        "specular colors",
        Approximated(
            "up to 0.2 the reflectance head on, above it a weight; the color of a metal where it outshines `Kd`, with a message",
        ),
    ),
    feature(Mtl, "Ns", "shininess", Approximated("as the roughness of equal width, where `Pr` is missing")),
    feature(Mtl, "map_Ns", "maps of shininess", LeftOut("convert them to maps of roughness (map_Pr)")),
    feature(Mtl, "Ni", "index of refraction, 1 to 4; 1 counts as not given", Read),
    feature(Mtl, "Pr map_Pr Pm map_Pm", "roughness and metalness", Read),
    feature(Mtl, "Pc map_Pc Pcr map_Pcr", "coats and their roughness", Read),
    feature(Mtl, "Ps map_Ps", "sheen", Read),
    feature(Mtl, "Ke map_Ke", "emission", Read),
    feature(Mtl, "d map_d", "opacity, and maps of it in their alpha or red", Read),
    feature(Mtl, "Tr", "transparency", Approximated("opacity in files of MeshLab")),
    feature(Mtl, "illum", "models of illumination", Approximated("they only tell what `Tr` means")),
    feature(Mtl, "aniso anisor", "anisotropy", Approximated("a rotation snaps to the tangent or across it")),
    feature(
        Mtl,
        "map_aniso map_anisor",
        "maps of anisotropy",
        LeftOut("the highlight is stretched the same everywhere"),
    ),
    feature(Mtl, "norm map_Kn", "normal maps", Read),
    feature(
        Mtl,
        "bump map_bump",
        "bump maps",
        Approximated("a white texel is 1 cm high; blue pictures are normal maps"),
    ),
    feature(Mtl, "disp map_disp", "displacement", LeftOut("use it as a bump map, or bake it into the mesh")),
    feature(Mtl, "Tf", "colors of transmitted light", LeftOut("light passes straight through, by opacity (d)")),
    feature(Mtl, "refl map_refl", "pictures of reflections", LeftOut("reflections are traced")),
    feature(Mtl, "decal", "pictures over the others", LeftOut("paint them into map_Kd")),
    feature(
        Mtl,
        "Ka map_Ka sharpness map_aat",
        "ambient light, and settings of other renderers",
        Unneeded("light is traced"),
    ),
    feature(Mtl, "-s -o", "placement of maps", Read),
    feature(Mtl, "-bm -imfchan", "strength of bump and normal maps, and channels", Read),
    feature(Mtl, "-clamp", "maps that do not repeat", Read),
    feature(
        Mtl,
        "-mm -t -cc -boost -blendu -blendv -texres -type",
        "other options of maps",
        LeftOut("change the picture instead"),
    ),
];

/// Elements and properties of PLY that have no row of their own.
pub(crate) const PLY_OTHERS: Feature = feature(Ply, "", "other contents", LeftOut("export the scene as glTF or OBJ"));

const PLY: [Feature; 11] = [
    feature(Ply, "", "ASCII and binary files of either byte order", Read),
    feature(Ply, "x y z nx ny nz", "positions and normals", Read),
    feature(Ply, "u v s t texture_u texture_v texture_s texture_t", "texture coordinates of vertices", Read),
    feature(Ply, "vertex_indices vertex_index", "polygons with any number of corners, also concave", Read),
    feature(
        Ply,
        "red green blue diffuse_red diffuse_green diffuse_blue",
        "colors of vertices, or else of faces, in sRGB",
        Read,
    ),
    feature(Ply, "alpha diffuse_alpha", "opacities of vertices and faces", LeftOut("use a texture of opacity in glTF")),
    feature(Ply, "texcoord texnumber TextureFile", "texture coordinates of corners, and pictures", Read),
    feature(Ply, "tristrips", "strips of triangles", LeftOut("export it with faces")),
    feature(Ply, "edge", "edges", LeftOut("give them a thickness in the modelling program")),
    feature(
        Ply,
        "flags quality confidence intensity",
        "marks and measures of points",
        Unneeded("they are no part of a look"),
    ),
    PLY_OTHERS,
];

const MATERIALX: [Feature; 15] = [
    feature(MaterialX, "open_pbr_surface", "OpenPBR surfaces: all inputs but those below", Read),
    feature(
        MaterialX,
        "standard_surface gltf_pbr",
        "surfaces of other models",
        Approximated("as OpenPBR, by the published translation"),
    ),
    feature(MaterialX, "", "other surfaces", LeftOut("such a material is refused; convert it to one of the above")),
    feature(MaterialX, "image tiledimage gltf_image gltf_colorimage", "pictures", Read),
    feature(
        MaterialX,
        "place2d rotate2d multiply divide add subtract texcoord",
        "placement; one that is skewed leaves its map out",
        Read,
    ),
    feature(MaterialX, "multiply add constant", "factors and offsets of pictures", Read),
    feature(MaterialX, "extract swizzle separate2 separate3 separate4 dot convert", "components", Read),
    feature(MaterialX, "normalmap gltf_normalmap bump", "normal and bump maps", Read),
    feature(
        MaterialX,
        "",
        "other nodes, such as noise and mixes",
        LeftOut("the input has its default; bake the node to a picture"),
    ),
    feature(
        MaterialX,
        "colorspace",
        "color spaces besides sRGB, linear Rec. 709, Rec. 2020 and P3, ACEScg and ACES2065-1",
        Approximated("taken for one of these"),
    ),
    feature(MaterialX, "include", "other documents in the folder that are included", Read),
    feature(MaterialX, "fileprefix unit", "prefixes of file names, and units", Read),
    feature(MaterialX, "uaddressmode vaddressmode", "pictures that repeat, are clamped or mirrored", Read),
    feature(MaterialX, "", "pictures in tiles (UDIM)", LeftOut("join them to one picture")),
    feature(MaterialX, "displacementshader", "displacement", LeftOut("bake it into the mesh")),
];

const MATERIAL: [Feature; 4] = [
    feature(Material, "name model parameters double_sided vertex_colors", "models and their parameters", Read),
    feature(Material, "file", "measured tables and BRDFs of your own", Read),
    feature(
        Material,
        "maps",
        "pictures and patterns for every parameter, with placement, wrap and set of coordinates",
        Read,
    ),
    feature(Material, "", "other fields", LeftOut("such a file is refused with their names")),
];

const CONVERT: Support = LeftOut("convert them to PNG, or to EXR if they hold light");

const PICTURES: [Feature; 16] = [
    feature(Picture, "EXR", "RGB, gray, luminance and chroma, of 16 and 32 bits, with alpha", Read),
    feature(Picture, "", "EXR: display window; outside the data window they are black", Read),
    feature(
        Picture,
        "",
        "EXR: parts and layers, the whole picture (`RGBA`, `ViewLayer.Combined`) or one by name (`FILE.exr#LAYER`)",
        Read,
    ),
    feature(Picture, "", "EXR: chromaticities, converted to Rec. 709; a slot or an environment may give others", Read),
    feature(
        Picture,
        "",
        "EXR: deep pixels, and channels of different resolution, as of luminance and chroma",
        LeftOut("such a file is refused; flatten it, or save it as RGB"),
    ),
    feature(Picture, "HDR", "RGBE and XYZE, exposure, color correction, primaries, all orientations", Read),
    feature(Picture, "PNG", "8 and 16 bits, with alpha", Read),
    feature(Picture, "JPEG", "gray and RGB of 8 bits", Read),
    feature(Picture, "TGA", "8 bits, with alpha", Read),
    feature(
        Picture,
        "",
        "profiles of color, gamma and orientation in PNG, JPEG, TIFF and WebP",
        LeftOut("the slot tells whether a picture is sRGB or linear"),
    ),
    feature(
        Picture,
        "",
        "texels that are not finite or beyond 65,504",
        Approximated("replaced by finite ones, with a warning"),
    ),
    feature(Picture, "WebP", "8 bits, with alpha", Read),
    feature(Picture, "TIFF", "8 and 16 bits and floats, gray, RGB and RGBA", Read),
    feature(Picture, "KTX2", "Basis Universal (ETC1S, UASTC)", Read),
    feature(Picture, "BMP AVIF", "pictures of other programs", CONVERT),
    feature(Picture, "DDS", "pictures for graphics cards, also in KTX2", CONVERT),
];
