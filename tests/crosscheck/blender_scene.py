"""A folder of `lapidary export --mitsuba` as a scene of Blender, for Cycles.

Blender's up is +Z: (x, y, z) becomes (x, -z, y). Its latitude-longitude maps have +X in their centre and +Y in their left quarter; ours
have what becomes -Y and +X there, a quarter of a turn away.
"""

import math
import xml.etree.ElementTree as ET

import bpy
import mathutils
import numpy as np

BLENDER_FROM_OURS = mathutils.Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def read_ply(path):
    """Positions, normals and triangles of a mesh as `lapidary export` writes it."""
    data = path.read_bytes()
    header, body = data.split(b"end_header\n", 1)
    counts = [int(line.split()[-1]) for line in header.decode().splitlines() if line.startswith("element")]
    vertices = np.frombuffer(body, "<f4", 8 * counts[0]).reshape(-1, 8)
    face = np.dtype([("corners", "u1"), ("vertices", "<u4", 3)])
    faces = np.frombuffer(body, face, counts[1], offset=vertices.nbytes)["vertices"]
    return vertices[:, :3], vertices[:, 3:6], faces


def turned(vectors):
    x, y, z = vectors.T
    return np.stack([x, -z, y], axis=1)


def add_mesh(path, material):
    positions, normals, faces = read_ply(path)
    mesh = bpy.data.meshes.new(path.stem)
    mesh.from_pydata(turned(positions).tolist(), [], faces.tolist())
    mesh.shade_smooth()
    mesh.normals_split_custom_set_from_vertices(turned(normals).tolist())
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(path.stem, mesh))


def add_camera(sensor, scene):
    look = sensor.find("transform/lookat")
    eye, target, up = (
        BLENDER_FROM_OURS @ mathutils.Vector([float(x) for x in look.get(name).split(",")])
        for name in ("origin", "target", "up")
    )
    backward = (eye - target).normalized()
    right = up.cross(backward).normalized()
    columns = [right, backward.cross(right), backward, eye]
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(float(sensor.find("float[@name='fov']").get("value")))
    data.clip_start, data.clip_end = 1e-3, 1e3
    camera = bpy.data.objects.new("camera", data)
    camera.matrix_world = mathutils.Matrix(
        [[column[row] for column in columns] for row in range(3)] + [[0, 0, 0, 1]]
    )
    scene.collection.objects.link(camera)
    scene.camera = camera


def add_environment(path, turn_degrees, scene, seen):
    world = scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(str(path))
    texture.image.colorspace_settings.name = "Linear Rec.709"
    mapping = nodes.new("ShaderNodeMapping")
    # The map turns the other way than the directions that look it up, and its centre is +X here and not our +Z, which is -Y.
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(90.0 - turn_degrees))
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = 1024
    world.cycles_visibility.camera = seen


def build(folder, environment, turn_degrees, seen=False):
    """The scene with one principled material, which is returned; `seen` shows the environment behind it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    material = bpy.data.materials.new("surface")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    # One scattering at the microfacets, as in Lapidary.
    shader.distribution = "GGX"
    xml = ET.parse(folder / "scene.xml").getroot()
    for shape in xml.findall("shape[@type='ply']"):
        add_mesh(folder / shape.find("string").get("value"), material)
    sensor = xml.find("sensor")
    add_camera(sensor, scene)
    add_environment(environment, turn_degrees, scene, seen)
    film = {i.get("name"): int(i.get("value")) for i in sensor.findall("film/integer")}
    settings(scene, film["width"], film["height"])
    return scene, shader


def settings(scene, width, height):
    """Direct light alone, unclamped, one place in a pixel as `lapidary render --aa 1` has it, on the CPU."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.render.use_persistent_data = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.color_depth = "32"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.max_bounces = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    cycles.filter_width = 0.01
    cycles.auto_scrambling_distance = False


def set_metal(shader, base_color, roughness):
    """A conductor of Schlick's Fresnel factor: the model of `lapidary` with metalness 1, by definition."""
    shader.inputs["Base Color"].default_value = (*base_color, 1.0)
    shader.inputs["Metallic"].default_value = 1.0
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Specular Tint"].default_value = (1.0, 1.0, 1.0, 1.0)
