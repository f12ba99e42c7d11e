"""What is compared: scenes, materials, lights, and what must not pass."""

import math
from dataclasses import dataclass, field
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "data"


@dataclass
class Case:
    name: str
    scene: str
    # Options that `lapidary export` and `lapidary reference` share.
    options: list
    material: dict | None = None
    lights: list | None = None
    bounces: int = 0
    # Which BSDFs Mitsuba has: its nearest, or the formula of Lapidary in a plugin.
    materials: str = "materials-exact.xml"
    integrator: str = "direct"
    # How many times the samples of other cases tell as much of this one.
    samples: int = 1
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
            BALL_VIEW + ["--env", "none", "--background", "black"],
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


def scene_file(name, folder):
    """Path of a scene, generated if it is not bundled."""
    bundled = {"box": "color-box/color-box", "still-life": "still-life/still-life", "interior": "interior/interior"}
    if name in bundled:
        return DATA / f"{bundled[name]}.gltf"
    path = folder / f"{name}.obj"
    write_ball(path)
    return path
