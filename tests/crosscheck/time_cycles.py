#!/usr/bin/env python3
"""How long Blender's Cycles takes to the error of a frame of Lapidary, after an edit of a material.

    pip install -r tests/crosscheck/requirements-cycles.txt
    python tests/crosscheck/time_cycles.py --lapidary target/release/lapidary --cuts still-life.cuts --out out/cycles

Both show the direct light of one environment on one conductor, a model that is the same in both by definition, on the CPU, with one
place in a pixel. Each picture is compared with the converged picture of its own renderer; how far these are apart is told, too.
Lapidary's time is that of a frame with the light unchanged (`lapidary bench --backend cpu`). Cycles' time is that of a render with
persistent data after its material was edited: geometry and ray hierarchy are kept, as in its viewport. Beside seconds of the clock stand
seconds of the processor, of all threads, which other work on the machine changes little.
"""

import argparse
import json
import math
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "data"
BASE_COLOR = (1.0, 0.78, 0.34)
# Roughness before and after the edit.
BEFORE, AFTER = 0.5, 0.4
# The second converged picture has this share of the samples of the first, and tells the noise of it.
CONTROL = 1 / 8
# Frames over which the processor's seconds are averaged.
MORE_FRAMES = 10


def children_cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lapidary", type=Path, default=Path("target/release/lapidary"), help="the program")
    parser.add_argument("--cuts", type=Path, required=True, help="a baked scene with a camera")
    parser.add_argument("--env", type=Path, default=DATA / "environments/studio.hdr", help="environment")
    parser.add_argument("--rotate", type=float, default=30.0, help="its turn in degrees")
    parser.add_argument("--size", default="320x240", help="pixels")
    parser.add_argument("--spp", type=int, nargs="+", default=[1, 2, 4, 8, 16, 32, 64], help="samples tried of Cycles")
    parser.add_argument("--reference-spp", type=int, default=4096, help="samples of Lapidary's converged pictures")
    parser.add_argument("--cycles-reference-spp", type=int, default=1024, help="samples of those of Cycles")
    parser.add_argument("--repeats", type=int, default=3, help="of which the median is told")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--references-only", action="store_true", help="make the converged pictures and stop")
    parser.add_argument("--out", type=Path, required=True, help="folder for pictures and cycles.json; converged ones are kept")
    return parser.parse_args()


def samples(spp, seed):
    return spp if seed == 0 else max(1, round(spp * CONTROL))


class Lapidary:
    def __init__(self, args):
        self.args = args
        color = ",".join(map(str, BASE_COLOR))
        self.view = [args.cuts, "--env", args.env, "--rotate", args.rotate, "--size", args.size, "--background", "black"]
        # Direct light alone, as Cycles renders it here.
        self.view += ["--no-mirrors"]
        self.view += ["--lights", "none", "--base-color", color, "--metalness", 1, "--roughness", AFTER]

    def run(self, command, *arguments):
        arguments = [str(a) for a in arguments]
        done = subprocess.run([self.args.lapidary, command, *arguments], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"lapidary {command} {' '.join(arguments)}: {done.stderr}")
        return done.stdout

    def error(self, picture, reference):
        """Relative RMSE, FLIP."""
        path = self.args.out / "compare.json"
        self.run("compare", picture, reference, "--json", path)
        metrics = json.loads(path.read_text())
        return metrics["rel_rmse"], metrics["flip"]

    def reference(self, seed):
        path = self.args.out / f"lapidary-reference-{seed}.exr"
        if not path.exists():
            spp = samples(self.args.reference_spp, seed)
            self.run("reference", *self.view, "--aa", "1", "--kind", "path", "--spp", spp, "--seed", seed, "--out", path)
        return path

    def frame(self):
        """Picture, median of its seconds, and seconds of the processor: what more frames take more."""
        path = self.args.out / "lapidary.exr"
        self.run("render", *self.view, "--aa", "1", "--backend", "cpu", "--components", "environment", "--out", path)
        few, many = self.bench(1), self.bench(1 + MORE_FRAMES)
        return path, many[0], (many[1] - few[1]) / MORE_FRAMES

    def bench(self, frames):
        """Median seconds of a frame, and seconds of the processor of all of it."""
        before = children_cpu_seconds()
        options = ["--backend", "cpu", "--frames", frames, "--json"]
        report = json.loads(self.run("bench", *self.view, *options, "--components", "environment"))
        return report["runs"][0]["milliseconds"]["total"] / 1e3, children_cpu_seconds() - before


class Cycles:
    def __init__(self, args, folder):
        import blender_scene
        import bpy

        self.args, self.bpy, self.parts = args, bpy, blender_scene
        self.scene, self.shader = blender_scene.build(folder, args.env, args.rotate)
        self.scene.render.threads_mode = "FIXED"
        self.scene.render.threads = args.threads

    def render(self, name, spp, roughness, seed=0, denoise=False):
        """Path, seconds and seconds of the processor of one render; the file is written after them."""
        path = self.args.out / f"{name}.exr"
        cycles = self.scene.cycles
        cycles.samples, cycles.seed, cycles.use_denoising = spp, seed, denoise
        self.scene.render.filepath = str(path)
        self.parts.set_metal(self.shader, BASE_COLOR, roughness)
        start, cpu_start = time.monotonic(), time.process_time()
        self.bpy.ops.render.render()
        seconds, cpu_seconds = time.monotonic() - start, time.process_time() - cpu_start
        self.bpy.data.images["Render Result"].save_render(str(path))
        return path, seconds, cpu_seconds

    def reference(self, seed):
        path = self.args.out / f"cycles-reference-{seed}.exr"
        if not path.exists():
            self.render(path.stem, samples(self.args.cycles_reference_spp, seed), AFTER, seed=1000 + seed)
        return path

    def after_edit(self, spp, denoise):
        """Picture, and median seconds of both kinds, of renders that each follow an edit."""
        times = []
        for _ in range(self.args.repeats):
            self.render("before", 1, BEFORE)
            path, *elapsed = self.render("after", spp, AFTER, denoise=denoise)
            times.append(elapsed)
        return path, *(statistics.median(column) for column in zip(*times))


def time_to_reach(rows, error, seconds):
    """`seconds`, a column, at which the error is reached, by straight lines between the logarithms; None if it never is."""
    for before, after in zip([None, *rows], rows):
        if after["rel_rmse"] <= error:
            if before is None:
                return after[seconds]
            share = math.log(before["rel_rmse"] / error) / math.log(before["rel_rmse"] / after["rel_rmse"])
            return before[seconds] * (after[seconds] / before[seconds]) ** share
    return None


def main():
    args = options()
    try:
        import bpy  # noqa: F401
    except ImportError as error:
        print(f"Blender is not there: pip install bpy==4.5.15 ({error})", file=sys.stderr)
        return 2
    args.out.mkdir(parents=True, exist_ok=True)
    ours = Lapidary(args)
    ours.run("export", *ours.view, "--mitsuba", args.out / "scene")
    theirs = Cycles(args, args.out / "scene")
    our_truths, their_truths = ([renderer.reference(seed) for seed in (0, 1)] for renderer in (ours, theirs))
    if args.references_only:
        return 0
    frame, seconds, cpu_seconds = ours.frame()
    our_error, our_flip = ours.error(frame, our_truths[0])
    report = {
        "size": args.size,
        "roughness": AFTER,
        "references": {
            "lapidary_spp": args.reference_spp,
            "cycles_spp": args.cycles_reference_spp,
            # Variances add up: that of the second is larger by the share.
            "lapidary_noise": ours.error(our_truths[1], our_truths[0])[0] / math.sqrt(1.0 + 1.0 / CONTROL),
            "cycles_noise": ours.error(their_truths[1], their_truths[0])[0] / math.sqrt(1.0 + 1.0 / CONTROL),
            "cycles_against_lapidary": ours.error(their_truths[0], our_truths[0])[0],
        },
        "lapidary": {
            "seconds": seconds,
            "cpu_seconds": cpu_seconds,
            "rel_rmse": our_error,
            "flip": our_flip,
        },
        "cycles": {},
    }
    for name, denoise in (("plain", False), ("denoised", True)):
        rows = []
        for spp in args.spp:
            picture, seconds, cpu_seconds = theirs.after_edit(spp, denoise)
            rel_rmse, flip = ours.error(picture, their_truths[0])
            rows.append(
                {"spp": spp, "seconds": seconds, "cpu_seconds": cpu_seconds, "rel_rmse": rel_rmse, "flip": flip}
            )
        reached = {f"{kind}_to_our_error": time_to_reach(rows, our_error, kind) for kind in ("seconds", "cpu_seconds")}
        report["cycles"][name] = {"steps": rows, **reached}
    text = json.dumps(report, indent=2)
    (args.out / "cycles.json").write_text(text + "\n")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
