"""What is compared: scenes, materials, lights, and what must not pass."""

import math
from dataclasses import dataclass, field
from pathlib import Path

# Relative RMSE that is allowed.
BOUND = 0.02
# Width of the plastics that are compared, and their index of refraction.
PLASTIC_ALPHA = 0.3
IOR = 1.5
DATA = Path(__file__).resolve().parents[2] / "data"


@dataclass
class Case:
    name: str
    scene: str
    # Options that `lapidary export` and `lapidary reference` share.
    options: list
    material: dict | None = None
    # The scene's material that it stands for, all if empty, and what stands for others by their names.
    part: str = ""
    rest: dict = field(default_factory=dict)
    lights: list | None = None
    bounces: int = 0
    # Which BSDFs Mitsuba has: its nearest, or the formula of Lapidary in a plugin.
    materials: str = "materials-exact.xml"
    # A BSDF of Mitsuba in place of the exported ones: type and properties.
    bsdf: tuple | None = None
    # Files that the material or this BSDF names, and the function of `files.py` that writes each.
    files: dict = field(default_factory=dict)
    # What the models differ by, where they do by definition, is within this.
    bound: float = BOUND
    integrator: str = "direct"
    # How many times the samples of other cases tell as much of this one.
    samples: float = 1.0
    # Share of these that Lapidary takes, whose functions in WGSL are slow.
    share: float = 1.0
    # Pictures of Lapidary that must differ: options added, and changes of the material.
    controls: dict = field(default_factory=dict)


@dataclass
class Control:
    options: list = field(default_factory=list)
    parameters: dict = field(default_factory=dict)
    bounces: int | None = None


DIFFUSE = {"model": "lambert", "parameters": {"base_color": [0.7, 0.5, 0.3]}}
CONDUCTOR = {
    "model": "ggx",
    "parameters": {"base_color": [1.0, 0.78, 0.34], "metalness": 1.0, "roughness": 0.5},
}
COATED = {
    "model": "ggx",
    "parameters": {"base_color": [0.5, 0.2, 0.1], "metalness": 0.0, "roughness": 0.35, "ior": 1.5},
}
STRETCHED = {
    "model": "ggx",
    "parameters": {"base_color": [0.9, 0.9, 0.95], "metalness": 1.0, "roughness": 0.5, "anisotropy": 0.7},
}
BECKMANN = {"model": "beckmann", "parameters": {**CONDUCTOR["parameters"], "edge_color": [0.9, 0.6, 0.3]}}
BRUSHED = {"model": "beckmann", "parameters": {**BECKMANN["parameters"], "anisotropy": 0.7}}
SURFACES = {"diffuse": DIFFUSE, "conductor": CONDUCTOR, "coated": COATED}
ENVIRONMENTS = {"sun": DATA / "environments/sun-and-sky.hdr", "studio": DATA / "environments/studio.hdr"}

# A closer look at the ball than at the floor.
BALL_VIEW = ["--eye", "0.9,1.3,2.2", "--target", "0,0.45,0", "--fov", "32"]
DARK = ["--env", "none", "--background", "black"]
TURNED = Control(options=["--rotate", "55"])
ROUGHER = Control(parameters={"roughness": 0.6})


def _light(environment, turn=45):
    return ["--env", str(ENVIRONMENTS[environment]), "--rotate", str(turn), "--background", "black"]


def _under_environments(surface, material):
    turned = {"turned by 10 degrees": TURNED}
    rougher = {"roughness off": ROUGHER} if material["model"] == "ggx" else {}
    for environment in ENVIRONMENTS:
        yield Case(
            f"{surface} ball, {environment}",
            "ball",
            BALL_VIEW + _light(environment),
            material=material,
            controls=turned | rougher,
        )


POINT_LIGHT = [{"kind": "point", "position": [0.2, 1.5, 0.1], "intensity": [3.0, 2.8, 2.4]}]
LAMPS = [
    {"kind": "spot", "position": [1.5, 2.5, 1.0], "target": [0, 0.4, 0], "intensity": [9, 9, 9], "cone_degrees": 14},
    {"kind": "directional", "position": [2, 2, -1], "target": [0, 0, 0], "intensity": [0.8, 0.9, 1.0]},
    {
        "kind": "rectangle",
        # Where it is in the way of neither the others nor the eye, for in Mitsuba it would be.
        "position": [0, 2.8, 0.6],
        "target": [0, 0.4, 0],
        "intensity": [3, 2, 1],
        "width": 0.8,
        "height": 0.4,
    },
]


# Lights without extent, from sides where the ball shows a highlight, its edge and the floor.
SMALL_LAMPS = [
    *LAMPS[:2],
    {"kind": "point", "position": [-1.2, 1.0, 1.6], "intensity": [2.0, 2.0, 2.0]},
    {"kind": "point", "position": [0.2, 0.6, -1.6], "intensity": [6.0, 6.0, 6.0]},
]
WHITE = {"model": "lambert", "parameters": {"base_color": [0.7, 0.7, 0.7]}}
LAMP = {
    "model": "lambert",
    "parameters": {"base_color": [0.2, 0.2, 0.2], "emission_luminance": 4.0, "emission_color": [1.0, 0.8, 0.5]},
}
SCREEN = LAMP | {
    "maps": {
        "emission_color": {
            "procedural": {"pattern": "checker", "low": [0.1, 0.2, 1.0], "high": [1.0, 0.5, 0.1]},
            "scale": [12, 3],
        }
    }
}


def _shining():
    brighter = {"brighter by 5 %": Control(parameters={"emission_luminance": 1.05 * LAMP["parameters"]["emission_luminance"]})}
    common = {"scene": "lamp", "integrator": "path"}
    yield Case(
        "a lamp of two sides lights a floor and a box, two bounces",
        # Where the lamp is not in the picture, which it would outshine.
        options=["--eye", "0.3,1.8,2.6", "--target", "0.2,0,0.35", "--fov", "24"] + DARK,
        material=LAMP,
        part="lamp",
        rest={"white": WHITE, "box": WHITE},
        bounces=2,
        samples=2,
        controls=brighter | {"one bounce": Control(bounces=1), "no bounce": Control(bounces=0)},
        **common,
    )
    yield Case(
        "a box shines by a map and lights a floor",
        options=["--eye", "1.2,1.4,2.2", "--target", "-0.2,0.2,0", "--fov", "40"] + DARK,
        material=SCREEN,
        part="box",
        rest={"white": WHITE, "lamp": WHITE},
        bounces=1,
        controls=brighter | {"no bounce": Control(bounces=0)},
        **common,
    )


BLACK = {"model": "lambert", "parameters": {"base_color": [0, 0, 0]}}
PANE = {
    "model": "lambert",
    "parameters": {"base_color": [0, 0, 0], "geometry_opacity": 0.8},
    "maps": {
        "geometry_opacity": {
            "procedural": {"pattern": "gradient", "low": [0.1, 0, 0], "high": [0.9, 0, 0]},
            "scale": [1, 1],
        }
    },
}


def _thin():
    """Nothing but the floor reflects, for Mitsuba counts a pane that light passes as a bounce."""
    yield Case(
        "a pane whose opacity rises from one edge to the other",
        scene="lamp",
        integrator="path",
        # Light without lamps: what lies behind a pane Mitsuba's paths find by chance alone.
        options=["--eye", "1.5,2.6,1.3", "--target", "0.1,0.4,-0.1", "--fov", "36", "--background", "black"]
        + ["--env", "FOLDER/even.hdr", "--rotate", "45"],
        files={"even.hdr": "write_even"},
        material=PANE,
        part="lamp",
        rest={"white": WHITE, "box": BLACK},
        bounces=0,
        samples=2,
        controls={"opacity 0.6 in place of 0.8": Control(parameters={"geometry_opacity": 0.6})},
    )


PRINCIPLED = {"base_color": [0.4, 0.15, 0.1], "roughness": 0.5, "clearcoat": 1.0, "clearcoat_gloss": 0.1, "sheen": 1.0}
PLASTIC = {"diffuse_reflectance": [0.5, 0.2, 0.1], "alpha": PLASTIC_ALPHA, "distribution": "ggx"}
ROUGH_PLASTIC = ("roughplastic", PLASTIC | {"int_ior": IOR, "ext_ior": 1.0})
# Mitsuba's base is darker below its dielectric, where light is lost between facets.
DARKER = [0.655 * x for x in PLASTIC["diffuse_reflectance"]]
NEAR_PLASTIC = {"base_color": DARKER, "roughness": PLASTIC_ALPHA**0.5, "ior": IOR}
LAYERED = {
    "base_color": PRINCIPLED["base_color"],
    "specular_roughness": PRINCIPLED["roughness"],
    "coat_weight": 0.5,
    "coat_roughness": 0.3,
    "coat_ior": 1.5,
    "coat_darkening": 0.0,
    "fuzz_weight": 0.1,
}


def _functions():
    """Models of Mitsuba as functions in WGSL, which are interpreted: under a few lights, where few samples tell much."""
    common = {"scene": "ball", "options": BALL_VIEW + DARK, "lights": SMALL_LAMPS, "samples": 2, "share": 1 / 64}
    yield Case(
        "principled with clearcoat and sheen, as a function",
        material={"model": "wgsl", "file": "principled.wgsl", "parameters": PRINCIPLED},
        bsdf=("principled", PRINCIPLED | {"eta": IOR}),
        files={"principled.wgsl": "copy_principled"},
        controls={
            "no clearcoat": Control(parameters={"clearcoat": 0.0}),
            "no sheen": Control(parameters={"sheen": 0.0}),
        },
        **common,
    )
    base = PLASTIC["diffuse_reflectance"]
    yield Case(
        "roughplastic, as a function",
        material={"model": "wgsl", "file": "plastic.wgsl", "parameters": {"base_color": base}},
        bsdf=ROUGH_PLASTIC,
        files={"plastic.wgsl": "write_rough_plastic"},
        controls={"base brighter by 5 %": Control(parameters={"base_color": [1.05 * x for x in base]})},
        **common,
    )


def _models():
    """A measured model, and models that are near to those of Mitsuba."""
    common = {"scene": "ball", "options": BALL_VIEW + _light("studio")}
    yield Case(
        "MERL table",
        material={"model": "merl", "file": "plastic.binary", "parameters": {"tint": [1.0, 1.0, 1.0]}},
        bsdf=("lapidary_merl", {"filename": "plastic.binary", "alpha": PLASTIC_ALPHA}),
        files={"plastic.binary": "write_merl"},
        samples=0.5,
        controls={"red off by 10 %": Control(parameters={"tint": [0.9, 1.0, 1.0]})},
        **common,
    )
    yield Case(
        "openpbr with coat and fuzz, near principled",
        material={"model": "openpbr", "parameters": LAYERED},
        materials="materials.xml",
        bound=0.1,
        controls={"fuzz 0.3": Control(parameters={"fuzz_weight": 0.3})},
        **common,
    )
    yield Case(
        "ggx, near roughplastic",
        material={"model": "ggx", "parameters": NEAR_PLASTIC},
        bsdf=ROUGH_PLASTIC,
        bound=0.05,
        controls={"base brighter by 15 %": Control(parameters={"base_color": [1.15 * x for x in DARKER]})},
        **common,
    )


def small():
    """What runs wherever the tests run."""
    cases = [
        Case(
            "environment behind the scene",
            "ball",
            ["--eye", "0,1,6", "--target", "1.5,4,0", "--fov", "60", "--env", str(DATA / "environments/window-room.hdr")]
            + ["--rotate", "-60", "--intensity", "1.5"],
            controls={"turned by 10 degrees": Control(options=["--rotate", "-50"])},
        )
    ]
    for surface, material in SURFACES.items():
        cases.extend(_under_environments(surface, material))
    for name, material in {"beckmann": BECKMANN, "brushed beckmann": BRUSHED}.items():
        cases.append(
            Case(
                f"{name} ball, studio, Mitsuba's roughconductor",
                "ball",
                BALL_VIEW + _light("studio"),
                material=material,
                materials="materials.xml",
                controls={"roughness off": ROUGHER},
            )
        )
    cases.append(
        Case(
            "spot, sun and rectangle",
            "ball",
            BALL_VIEW + DARK,
            material=COATED,
            lights=LAMPS,
            controls={"roughness off": ROUGHER},
        )
    )
    cases.append(
        Case(
            "point light in a box, one bounce",
            "box",
            ["--env", "none"],
            material=DIFFUSE,
            lights=POINT_LIGHT,
            bounces=1,
            integrator="path",
            controls={"no bounce": Control(bounces=0), "two bounces": Control(bounces=2)},
        )
    )
    cases.extend(_shining())
    cases.extend(_thin())
    cases.extend(_functions())
    cases.extend(_models())
    return cases


def large():
    """All of that, and the bundled scenes."""
    cases = small()
    for surface, material in SURFACES.items():
        for environment in ENVIRONMENTS:
            cases.append(
                Case(
                    f"{surface} still life, {environment}",
                    "still-life",
                    _light(environment),
                    material=material,
                    controls={"turned by 10 degrees": TURNED},
                )
            )
    cases.append(
        Case(
            "stretched highlights on a ball, studio",
            "ball",
            BALL_VIEW + _light("studio"),
            material=STRETCHED,
            controls={"not stretched": Control(parameters={"anisotropy": 0.0})},
        )
    )
    cases.append(
        Case(
            "diffuse interior, sun, one bounce",
            "interior",
            _light("sun") + ["--lights", "none"],
            material=DIFFUSE,
            bounces=1,
            integrator="path",
            samples=4,
            controls={"no bounce": Control(bounces=0)},
        )
    )
    cases.append(
        Case(
            "still life in its own materials, studio",
            "still-life",
            _light("studio"),
            samples=4,
            controls={"turned by 10 degrees": TURNED},
        )
    )
    return cases


def write_ball(path, rings=64, segments=128):
    """A ball of half a metre on a floor, with smooth normals and texture coordinates, as OBJ."""
    lines = []
    for ring in range(rings + 1):
        for segment in range(segments + 1):
            theta, phi = math.pi * ring / rings, 2.0 * math.pi * segment / segments
            n = (math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi))
            lines.append(f"v {0.5 * n[0]:.7f} {0.5 * n[1] + 0.5:.7f} {0.5 * n[2]:.7f}")
            lines.append(f"vn {n[0]:.7f} {n[1]:.7f} {n[2]:.7f}")
            lines.append(f"vt {segment / segments:.7f} {1.0 - ring / rings:.7f}")
    lines.append("o ball")
    for ring in range(rings):
        for segment in range(segments):
            a = ring * (segments + 1) + segment + 1
            b, c, d = a + segments + 1, a + segments + 2, a + 1
            corners = [[a, b, c], [a, c, d]]
            for face in corners[: 1 if ring == rings - 1 else 2][1 if ring == 0 else 0 :]:
                lines.append("f " + " ".join(f"{v}/{v}/{v}" for v in face))
    base = (rings + 1) * (segments + 1)
    for x, z in [(-2, -2), (-2, 2), (2, 2), (2, -2)]:
        lines += [f"v {x} 0 {z}", "vn 0 1 0", f"vt {(x + 2) / 4} {(z + 2) / 4}"]
    lines.append("o floor")
    for face in [(1, 2, 3), (1, 3, 4)]:
        lines.append("f " + " ".join(f"{base + v}/{base + v}/{base + v}" for v in face))
    path.write_text("\n".join(lines) + "\n")


def _quad(number, material, corners, u=(0, 1)):
    """Lines of the quad of a number, whose normal is that of its corners; `u` is its part of the texture."""
    (ax, ay, az), b, _, d = corners
    (ex, ey, ez), (fx, fy, fz) = ((x - ax, y - ay, z - az) for x, y, z in (b, d))
    normal = (ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx)
    length = math.hypot(*normal)
    yield f"usemtl {material}"
    yield "vn {} {} {}".format(*(x / length for x in normal))
    for corner, uv in zip(corners, [(u[0], 0), (u[1], 0), (u[1], 1), (u[0], 1)]):
        yield "v {} {} {}".format(*corner)
        yield "vt {} {}".format(*uv)
    yield "f " + " ".join(f"{4 * number + i}/{4 * number + i}/{number + 1}" for i in (1, 2, 3, 4))


def _sides(low, high):
    """Corners of the six sides of a box, seen from outside."""
    for axis in range(3):
        for end, turn in ((low, [(0, 0), (0, 1), (1, 1), (1, 0)]), (high, [(0, 0), (1, 0), (1, 1), (0, 1)])):
            corners = []
            for s, t in turn:
                along = [end[axis], (low, high)[s][(axis + 1) % 3], (low, high)[t][(axis + 2) % 3]]
                corners.append(tuple(along[(i - axis) % 3] for i in range(3)))
            yield corners


def write_lamp(path):
    """A floor, a box whose sides have texture coordinates of their own, and a slanting lamp of one quad, as OBJ."""
    floor = [(-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)]
    lamp = [(0.2, 1.2, -0.5), (0.45, 0.7, -0.5), (0.45, 0.7, 0.4), (0.2, 1.2, 0.4)]
    lines = [f"mtllib {path.stem}.mtl", "o floor", *_quad(0, "white", floor), "o box"]
    for i, side in enumerate(_sides((-0.7, 0.1, -0.3), (-0.2, 0.6, 0.2))):
        lines += _quad(i + 1, "box", side, (i / 6, (i + 1) / 6))
    lines += ["o lamp", *_quad(7, "lamp", lamp)]
    path.write_text("\n".join(lines) + "\n")
    path.with_suffix(".mtl").write_text("".join(f"newmtl {name}\nKd 0.7 0.7 0.7\n" for name in ("white", "box", "lamp")))


def scene_file(name, folder):
    """Path of a scene, generated if it is not bundled."""
    bundled = {"box": "color-box/color-box", "still-life": "still-life/still-life", "interior": "interior/interior"}
    if name in bundled:
        return DATA / f"{bundled[name]}.gltf"
    path = folder / f"{name}.obj"
    {"ball": write_ball, "lamp": write_lamp}[name](path)
    return path
