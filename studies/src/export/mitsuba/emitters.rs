//! Environment, local lights, and emissive surfaces.
//!
//! Latitude-longitude maps have the same axes in both programs. Point and directional lights, spots without penumbra and flat
//! emissive surfaces are the same by definition. The others differ:
//!
//! * A spot's penumbra: Mitsuba falls off linearly in the angle, this program smoothly in its cosine.
//! * A rectangle is geometry in Mitsuba: it is seen, unless emitters are hidden, and stands in the way of other light. So is
//!   the disc of a directional light with an extent, a thousand kilometers away.
//! * A surface with smooth normals shines on the side of these in Mitsuba, and on that of its triangles here.
//! * A map of radiance is sampled by texture coordinates in Mitsuba, which finds one surface at each point from 0 to 1.

use super::{textures::TextureFolder, xml};
use anyhow::Result;
use glam::{Mat4, Vec3};
use lapidary_core::{
    brdf::SurfaceParameters,
    image::Image,
    lights::{Disc, Emission, Light, RectangleShape},
    material::Material,
};
use lapidary_render::Illumination;

/// Distance in meters of infinitely far lights: rays from there are practically parallel across any scene.
const FAR: f32 = 1e6;

/// Path of the map in the exported folder.
pub const ENVIRONMENT_FILE: &str = "environment.exr";

/// The map with twice as many rows plus one. Mitsuba interpolates between rows from pole to pole, with the first and last on the
/// poles; this program interpolates between texel centers and extends the outermost values. With rows at all texel centers and
/// edges, both give the same function. Columns need no such care, but there must be two.
pub fn environment_map(map: &Image) -> Image {
    let height = map.height();
    let between = |x: usize, edge: usize| 0.5 * (map.at(x, edge.saturating_sub(1)) + map.at(x, edge.min(height - 1)));
    Image::from_fn([map.size[0].max(2), 2 * map.size[1] + 1], |x, row| {
        let (x, row) = (x as usize % map.width(), row as usize);
        if row % 2 == 1 { map.at(x, row / 2) } else { between(x, row / 2) }
    })
}

/// The rotated and scaled environment.
pub fn environment(light: &Illumination) -> String {
    let properties = [
        xml::value("string", "filename", ENVIRONMENT_FILE),
        xml::value("float", "scale", light.intensity),
        xml::to_world(Mat4::from_rotation_y(light.rotation)),
    ];
    xml::plugin("emitter", "envmap", "", &properties.concat())
}

/// A local light; `None` for one without a direction.
pub fn local(light: &Light) -> Option<String> {
    let intensity = |name| xml::triple("rgb", name, light.intensity);
    Some(match light.emission {
        Emission::Point => {
            let properties = xml::triple("point", "position", light.position) + &intensity("intensity");
            xml::plugin("emitter", "point", "", &properties)
        }
        Emission::Spot { cone_degrees, penumbra_degrees } => {
            let up = light.forward()?.any_orthonormal_vector();
            let properties = [
                xml::look_at(light.position, light.target, up),
                intensity("intensity"),
                xml::value("float", "cutoff_angle", cone_degrees),
                xml::value("float", "beam_width", (cone_degrees - penumbra_degrees).max(0.0)),
            ];
            xml::plugin("emitter", "spot", "", &properties.concat())
        }
        Emission::Directional { .. } => match Disc::of(light) {
            Some(disc) => distant(&disc, light.intensity),
            None => {
                let properties = xml::triple("vector", "direction", light.forward()?) + &intensity("irradiance");
                xml::plugin("emitter", "directional", "", &properties)
            }
        },
        Emission::Rectangle { .. } => shape("rectangle", placed(&RectangleShape::of(light)?), light.intensity),
    })
}

/// An emissive shape that reflects nothing, as lights do.
fn shape(kind: &str, world_from_shape: Mat4, radiance: Vec3) -> String {
    let emitter = xml::plugin("emitter", "area", "", &xml::triple("rgb", "radiance", radiance));
    let black = xml::plugin("bsdf", "diffuse", "", &xml::triple("rgb", "reflectance", Vec3::ZERO));
    xml::plugin("shape", kind, "", &(xml::to_world(world_from_shape) + &emitter + &black))
}

/// The emission of a material, by its color map or else its luminance map.
///
/// # Errors
/// An unwritable map.
pub fn surface(material: &Material, index: u32, textures: &mut TextureFolder) -> Result<String> {
    let maps = &material.maps;
    let p = SurfaceParameters::from(&material.parameters.clone().sanitized());
    let file = format!("material-{index}-emission");
    let radiance = if let Some(slot) = maps.get("emission_color") {
        textures.property(Some("radiance"), &file, slot, |texel| {
            p.emission_luminance * (p.emission_color * texel.truncate()).clamp(Vec3::ZERO, Vec3::ONE)
        })?
    } else if let Some(slot) = maps.get("emission_luminance") {
        let scale = |factor: f32| factor.max(0.0) * p.emission();
        textures.property(Some("radiance"), &file, slot, |texel| scale(texel[slot.channel as usize]))?
    } else {
        xml::triple("rgb", "radiance", p.emission())
    };
    Ok(xml::plugin("emitter", "area", "", &radiance))
}

/// A far disc with the same angular diameter.
fn distant(disc: &Disc, irradiance: Vec3) -> String {
    let cos = 1.0 - disc.height;
    let radius = FAR * (1.0 - cos * cos).sqrt() / cos;
    // Mitsuba's disc has a radius of 1 and faces +Z.
    let columns = [disc.right * radius, disc.axis.cross(disc.right) * -radius, -disc.axis];
    let [x, y, z] = columns.map(|axis| axis.extend(0.0));
    let world_from_disc = Mat4::from_cols(x, y, z, (FAR * disc.axis).extend(1.0));
    shape("disk", world_from_disc, irradiance * disc.radiance_of_irradiance())
}

/// Transforms Mitsuba's rectangle, from -1 to 1 in x and y and facing +Z, to its place.
fn placed(shape: &RectangleShape) -> Mat4 {
    // A light's width, height and normal are left-handed; the rectangle is its own mirror image.
    let columns = [-shape.half_width, shape.half_height, shape.normal].map(|axis| axis.extend(0.0));
    Mat4::from_cols(columns[0], columns[1], columns[2], shape.center.extend(1.0))
}

/// Differences of emissive surfaces.
pub fn remarks_of_surface(material: &Material, two_sided: bool) -> Vec<String> {
    let Material { name, maps, .. } = material;
    let [color, luminance] = ["emission_color", "emission_luminance"].map(|map| maps.get(map).is_some());
    [
        (two_sided, "it shines on both sides, for which Mitsuba has two meshes"),
        (color && luminance, "the map of its emission luminance is left out"),
        (
            color || luminance,
            "Mitsuba loses light of its map of emission where texture coordinates lie outside 0 to 1 or upon each other",
        ),
    ]
    .into_iter()
    .filter(|(differs, _)| *differs)
    .map(|(_, remark)| format!("material \"{name}\": {remark}"))
    .collect()
}

/// Differences of these lights.
pub fn remarks(lights: &[&Light]) -> Vec<String> {
    let any = |is: fn(&Emission) -> bool| lights.iter().any(|light| is(&light.emission));
    let penumbra = any(|e| matches!(e, Emission::Spot { penumbra_degrees, .. } if *penumbra_degrees > 0.0));
    let rectangle = any(|e| matches!(e, Emission::Rectangle { .. }));
    let disc = any(|e| matches!(e, Emission::Directional { angle_degrees } if *angle_degrees > 0.0));
    [
        (penumbra, "the penumbra of spots falls off linearly in the angle in Mitsuba, not smoothly"),
        (rectangle, "rectangular lights are geometry in Mitsuba: they are visible and cast shadows"),
        (disc, "directional lights with an angle are visible in Mitsuba"),
    ]
    .into_iter()
    .filter(|(differs, _)| *differs)
    .map(|(_, remark)| remark.to_owned())
    .collect()
}
