//! What passes read: bind groups, each declared once for its layout and for what is bound. The names are those of the shaders.

use crate::device::bind_groups;

bind_groups! {
    /// Camera, picture and switches.
    Frame { frame: Uniform }

    /// The mesh, its materials, and what posed objects change of its light.
    Scene {
        vertices: Storage,
        triangles: Storage,
        materials: Storage,
        pool: Uint,
        tables: Uniform,
        measured: Storage,
        posed: Float,
    }

    /// What the visibility pass wrote.
    Seen { triangle_ids: Uint }

    /// What the surface pass wrote, the map that a ground catches shadows of, and the rays of mirrors.
    Surfaces { geometry: Uint, environment_map: Float, mirror_rays: Float }

    /// What the rays of mirrors meet.
    MirroredScene {
        mirrored: Uniform,
        nodes: Storage,
        corners: Storage,
        leaf_triangles: Storage,
        geometry: Uint,
        mirror_rays: Float,
        mirror_weights: Float,
    }

    /// Light of what the rays of mirrors meet, and the first part of that of the mirrors.
    MirroredLight {
        mirror_weights: Float,
        mirrored_value: Float,
        mirrored_geometry: Uint,
        environment_value: Float,
        environment_work: Uint,
        second_value: Float,
    }

    /// Light of what the rays of wider lobes meet.
    SecondLight { mirror_weights: Float, mirrored_value: Float, mirrored_geometry: Uint }

    /// A surface point to shade, the sums of the part of the light that is rendered, the maps that passes may read, and the rays
    /// of mirrors that see the point.
    Shading {
        geometry: Uint,
        rotation: Float,
        color_roughness: Float,
        previous_value: Float,
        previous_work: Uint,
        environment_map: Float,
        mirrored_map: Float,
        mirror_rays: Float,
    }

    /// A tree of lights, the cuts over it, and what its nodes send by direction.
    Light {
        nodes: Storage,
        brightness: Storage,
        visibility_cuts: Uint,
        illumination_cut: Uint,
        lit_nodes: Storage,
        lit_offsets: Storage,
        sent: Float,
    }

    /// Views of shadow maps that are rendered.
    ShadowViews { shadow_views: Storage }

    /// Local lights, their shadow maps, and the rays to suns that meet nothing.
    LocalLights { shadow_views: Storage, local_lights: Storage, shadow_maps: DepthLayers, suns_seen: Uint }

    /// Suns, and what rays to them meet.
    SunRays { suns: Uniform, nodes: Storage, corners: Storage, leaf_triangles: Storage }

    /// Meshless functions, with the grid that finds them, the coefficients of a solution, where vertices were as baked, and
    /// coefficients by direction.
    Basis {
        basis: Uniform,
        slots: Storage,
        entries: Storage,
        functions: Storage,
        coefficients: Storage,
        places: Float,
        harmonics: Float,
    }

    /// Quads, the quad of each triangle, and the radiance that arrives at them.
    QuadLight { quads: Storage, quad_of_triangles: Storage, radiance: Storage }

    /// The patch of each vertex.
    Patches { patches: Storage }

    /// What the pixels show, and what they showed so far.
    Marks { triangle_ids: Uint, previous_marks: Uint }

    /// Sums of a part of the light, and what is stale of them.
    Kept { stale: Uniform, marks: Uint, value: Float, work: Uint, added: Float }

    /// The sums of a lattice, and what the last picture tells.
    Lattice { lattice_value: Float, lattice_work: Uint, predicted: Float }

    /// The sums of another part of the light, and what the pixels show.
    Added { added_value: Float, added_work: Uint, marks: Uint }

    /// A part of the light in the last picture.
    Past { past: Storage, past_value: Float, past_place: Uint }

    /// The sums of all parts of the light.
    Display {
        display: Uniform,
        magma_stops: Uniform,
        environment_value: Float,
        environment_work: Uint,
        bounce_value: Float,
        bounce_work: Uint,
        mirrors_value: Float,
        mirrors_work: Uint,
        direct_value: Float,
        direct_work: Uint,
        added_value: Float,
        added_work: Uint,
    }
}
