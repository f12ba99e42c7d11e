#!/usr/bin/env python3
"""Compares the path reference of Lapidary with Mitsuba 3, case by case.

    pip install -r tests/crosscheck/requirements.txt
    python tests/crosscheck/crosscheck.py --lapidary target/release/lapidary --small

Exit code 0 if every case is within the bound and every negative control outside of it, 1 if not, 2 if Mitsuba is not there.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cases
from cases import BOUND, Case, Control

# Samples a pixel of Lapidary for a negative control, each at another place in it; comparisons take several times as many.
SAMPLES = 256
# An estimate whose spread reaches beyond this many times its bound is too noisy to tell.
SHARP = 1.25


def options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lapidary", type=Path, default=Path("target/release/lapidary"), help="the program")
    parser.add_argument("--small", action="store_true", help="few cases and small pictures: three minutes")
    parser.add_argument("--only", metavar="TEXT", default="", help="cases whose name holds TEXT")
    parser.add_argument("--size", metavar="WxH", help="pixels of a picture")
    parser.add_argument("--spp", type=int, help="samples per pixel of each of two pictures by Mitsuba")
    parser.add_argument("--out", type=Path, help="folder that keeps pictures and crosscheck.json")
    return parser.parse_args()


class Bench:
    """Runs both renderers in a folder."""

    def __init__(self, args, folder, mi):
        self.lapidary = args.lapidary.resolve()
        self.folder = folder
        self.mi = mi
        self.size = args.size or ("40x30" if args.small else "64x48")
        self.spp = args.spp or (196 if args.small else 400)
        self.our_spp = (4 if args.small else 8) * SAMPLES
        self.baked = {}

    def run(self, command, *arguments):
        arguments = [str(a) for a in arguments]
        done = subprocess.run([self.lapidary, "--quiet", command, *arguments], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"lapidary {command} {' '.join(arguments)}: exit code {done.returncode}, {done.stderr}")

    def dataset(self, scene):
        """Baked with few lights: paths need the mesh only."""
        if scene not in self.baked:
            path = self.folder / f"{scene}.cuts"
            few = ["--lights", 256, "--pilot-clusters", 16, "--no-tessellate", "--progress", "none"]
            self.run("bake", cases.scene_file(scene, self.folder), "-o", path, "--mode", "environment", *few)
            self.baked[scene] = path
        return self.baked[scene]

    def common(self, case, parameters=None):
        """Dataset, view, light and material as options."""
        options = [str(option).replace("FOLDER", str(self.folder)) for option in case.options]
        arguments = [self.dataset(case.scene), *options, "--size", self.size]
        if case.lights is not None:
            path = self.folder / "lights.json"
            path.write_text(json.dumps({"lights": case.lights}))
            arguments += ["--lights", path]
        self.write_files(case)
        if case.material is not None:
            path = self.folder / "material.json"
            path.write_text(json.dumps(case.material | {"parameters": case.material["parameters"] | (parameters or {})}))
            for name, material in case.rest.items():
                other = self.folder / f"{name}.json"
                other.write_text(json.dumps(material))
                arguments += ["--material", f"{name}={other}"]
            arguments += ["--material", f"{case.part}={path}" if case.part else path]
        return arguments

    def write_files(self, case):
        import files

        for name, write in case.files.items():
            if not (self.folder / name).exists():
                getattr(files, write)(self.folder / name)

    def by_lapidary(self, case, spp, control=Control()):
        """Two pictures of independent noise, without rays of mirrors, which go further than the bounces that are counted."""
        bounces = case.bounces if control.bounces is None else control.bounces
        pictures = []
        for seed in (0, 1):
            path = self.folder / f"lapidary-{seed}.exr"
            arguments = self.common(case, control.parameters)
            # The last of two equal options would be an error: a control replaces what the case has.
            for name, value in zip(control.options[::2], control.options[1::2]):
                at = arguments.index(name)
                arguments[at + 1] = value
            self.run(
                "reference", *arguments, "--aa", "1", "--kind", "path", "--bounces", bounces, "--places", "shifted",
                "--spp", spp, "--seed", seed, "--no-mirrors", "--out", path,
            )
            pictures.append(self.picture(path))
        return pictures

    def picture(self, path):
        import numpy as np

        return np.array(self.mi.Bitmap(str(path)).convert(self.mi.Bitmap.PixelFormat.RGB, self.mi.Struct.Type.Float32))

    def by_mitsuba(self, case):
        import numpy as np

        folder = self.folder / "mitsuba"
        self.run("export", *self.common(case), "--bounces", case.bounces, "--mitsuba", folder)
        if case.bsdf is not None:
            self.write_bsdf(*case.bsdf, folder / case.materials)
        scene = self.mi.load_file(str(folder / "scene.xml"), materials=case.materials)
        integrator = scene.integrator()
        if case.integrator == "direct":
            integrator = self.mi.load_dict({"type": "direct", "hide_emitters": "black" in case.options})
        spp = round(self.spp * case.samples)
        return [np.array(self.mi.render(scene, integrator=integrator, spp=spp, seed=seed)) for seed in (0, 1)]

    def write_bsdf(self, kind, properties, path):
        """Replaces the exported materials by one of Mitsuba."""
        lines = []
        for name, value in properties.items():
            if isinstance(value, str):
                value = self.folder / value if (self.folder / value).exists() else value
                lines.append(f'<string name="{name}" value="{value}"/>')
            elif isinstance(value, list):
                lines.append(f'<rgb name="{name}" value="{", ".join(map(str, value))}"/>')
            else:
                lines.append(f'<float name="{name}" value="{value}"/>')
        front = f'<bsdf type="{kind}" id="material-0">{"".join(lines)}</bsdf>'
        both = '<bsdf type="twosided" id="material-0-both-sides"><ref id="material-0"/></bsdf>'
        path.write_text(f'<scene version="3.0.0">{front}{both}</scene>')

    def compare(self, case, keep):
        """The estimate for the case and for each of its controls."""
        from estimate import relative_error

        start = time.monotonic()
        theirs = self.by_mitsuba(case)
        ours = self.by_lapidary(case, round(self.our_spp * case.samples * case.share))
        if keep:
            self.keep(case, ours, theirs, keep)
        row = {"case": case.name, "bound": case.bound, **relative_error(ours, theirs).as_dict()}
        row["controls"] = {
            name: relative_error(self.by_lapidary(case, round(SAMPLES * case.share), control), theirs).error
            for name, control in case.controls.items()
        }
        row["seconds"] = time.monotonic() - start
        return row

    def keep(self, case: Case, ours, theirs, folder):
        import numpy as np

        name = "".join(c if c.isalnum() else "-" for c in case.name)
        for who, pictures in (("lapidary", ours), ("mitsuba", theirs)):
            picture = np.mean(pictures, axis=0).astype(np.float32)
            self.mi.Bitmap(picture).write(str(folder / f"{name}-{who}.exr"))
            self.mi.util.write_bitmap(str(folder / f"{name}-{who}.png"), self.mi.Bitmap(picture), write_async=False)


def verdicts(row):
    """What is wrong with a case, in sentences."""
    bound = row["bound"]
    if not row["error"] <= bound:
        yield f"an error of {row['error']:.4f} is not within {bound}"
    if not row["at_most"] <= SHARP * bound:
        yield f"noise hides errors up to {row['at_most']:.4f}, more than {SHARP * bound}: take more samples"
    for name, error in row["controls"].items():
        if not error > bound:
            yield f"the negative control \"{name}\" differs by {error:.4f} only"


def main():
    args = options()
    try:
        import mitsuba as mi
    except ImportError as error:
        print(f"Mitsuba is not there: pip install -r {Path(__file__).parent / 'requirements.txt'} ({error})", file=sys.stderr)
        return 2
    mi.set_variant("scalar_rgb")
    import lapidary_ggx
    import lapidary_merl

    lapidary_ggx.register()
    lapidary_merl.register()
    if args.out:
        args.out.mkdir(parents=True, exist_ok=True)
    chosen = [case for case in (cases.small() if args.small else cases.large()) if args.only in case.name]
    if not chosen:
        sys.exit(f"no case has \"{args.only}\" in its name")
    rows, wrong = [], 0
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(args, Path(folder), mi)
        for case in chosen:
            row = bench.compare(case, args.out)
            rows.append(row)
            controls = ", ".join(f"{name} {error:.3f}" for name, error in row["controls"].items())
            print(
                f"{row['case']}: error {row['error']:.4f} (at most {row['at_most']:.4f}), energy {row['energy']:.4f}, "
                f"noise {row['noise']:.4f} against {row['noise_of_reference']:.4f}; {controls}; {row['seconds']:.1f} s",
                flush=True,
            )
            for sentence in verdicts(row):
                wrong += 1
                print(f"  FAILED: {sentence}", flush=True)
    if args.out:
        report = {"size": bench.size, "spp": bench.spp, "mitsuba": mi.__version__, "cases": rows}
        (args.out / "crosscheck.json").write_text(json.dumps(report, indent=2) + "\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
