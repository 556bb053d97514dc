"""The same three scenes by Rondure and by Mitsuba 3: how far the pictures differ, and how many samples a second each takes.

Rondure races twice: as it makes pictures, with photons and branches (`path`), and by the estimator of Mitsuba's integrator `path`, a
single path for each sample (`reference`).

Pictures are compared by blocks of 8 x 8 pixels, without those that a silhouette passes. Two pictures of each, with other random
numbers, tell the difference without the noise: the mean of d1 d2, with d of one pair and of the other, has none."""

import argparse
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
from PIL import Image

from scene import load

HERE = Path(__file__).parent
BLOCK = 8
WAYS = ["path", "reference"]


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--binaries", type=Path, required=True)
    options.add_argument("--work", type=Path, required=True)
    options.add_argument("--scenes", nargs="+", default=["glass", "metal", "interior"])
    options.add_argument("--spp", type=int, default=256, help="samples of each of the pictures that are compared")
    options.add_argument("--variants", nargs="+", default=["llvm_ad_rgb", "scalar_rgb"])
    options.add_argument("--rounds", type=int, default=5, help="rounds of the race; 0: no race")
    options.add_argument("--race-spp", type=int, default=64, help="samples in the race: enough that starting counts for little")
    options.add_argument("--pictures", type=Path, help="a folder for the pictures side by side")
    args = options.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    if len(args.scenes) > 1:
        # Each in a process of its own: Dr.Jit does not come back from a change of its number of threads.
        for name in args.scenes:
            rest = [a for a in sys.argv if a not in args.scenes and a != "--scenes"]
            subprocess.run([sys.executable, *rest, "--scenes", name], check=True)
        return
    for name in args.scenes:
        noise = oracle(name, args)
        if args.rounds:
            race(name, args, noise)


def rondure(name, args, way, spp, seed, out):
    """Renders and returns the processor time of it all, in seconds."""
    command = [args.binaries / "rondure", "render", HERE / f"{name}.toml", "-o", out, "--spp", spp]
    command += ["--integrator", way, "--seed", seed, "--threads", 1, "--quiet"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(c) for c in command], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime


def layers(path):
    """The light, and the number of the object that each pixel shows."""
    bitmap = mi.Bitmap(str(path))
    names, all_layers = [field.name for field in bitmap.struct_()], np.array(bitmap)
    layer = lambda name: all_layers[..., names.index(name)]
    return np.stack([layer(c) for c in "RGB"], axis=-1), layer("objectId")


def blocks(picture):
    h, w = (n // BLOCK * BLOCK for n in picture.shape[:2])
    return picture[:h, :w].reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK, -1)


def prepare(name, args, variant):
    mi.set_variant(variant)
    description, film = load(mi, HERE / f"{name}.toml", args.work, args.binaries)
    return mi.load_dict(description), film


def pick(args):
    """The first variant that runs here."""
    for variant in args.variants:
        try:
            mi.set_variant(variant)
            mi.Float(1) + 1
            return variant
        except Exception as error:
            print(f"{variant} does not run: {error}")
    raise SystemExit("no variant of Mitsuba runs here")


def oracle(name, args):
    files = {(way, seed): args.work / f"{name}-{way}-{seed}.exr" for way in WAYS for seed in (0, 1)}
    for (way, seed), out in files.items():
        rondure(name, args, way, args.spp, seed, out)
    scene, _ = prepare(name, args, pick(args))
    theirs = [np.array(mi.render(scene, spp=args.spp, seed=seed)) for seed in (0, 1)]
    # Not before Mitsuba has a variant.
    pictures = {key: layers(path) for key, path in files.items()}
    objects = pictures["path", 0][1]
    by_way = {way: [pictures[way, seed][0] for seed in (0, 1)] for way in WAYS}
    ours = by_way["path"]
    same = blocks(objects)
    inner = same.min(axis=(1, 3, 4)) == same.max(axis=(1, 3, 4))
    for way, pair in by_way.items():
        means = [blocks(p).mean(axis=(1, 3))[inner] for p in pair + theirs]
        d = [means[i] - means[i + 2] for i in (0, 1)]
        level = 0.5 * (means[2] + means[3])
        # Relative to each block, but no smaller a light than a hundredth of the picture's counts as one.
        scale = np.maximum(level, 0.01 * level.mean())
        difference = np.sqrt(max(0.0, float(np.mean(d[0] * d[1] / scale**2))))
        mean = float(sum(pair).mean() / sum(theirs).mean() - 1)
        inside = float((d[0] + d[1]).mean() / (2 * level.mean()))
        print(
            f"{name}: {way}: {int(inner.sum())} blocks of {inner.size}; mean light {inside:+.3%} there, {mean:+.3%} in the whole"
            f" picture; difference of a block {difference:.3%} (root mean square, noise taken out)"
        )
    noise = {who: relative_noise(*pair) for who, pair in {**by_way, "mitsuba": theirs}.items()}
    print(f"{name}: noise (relative variance) of one sample: " + ", ".join(f"{who} {n * args.spp:.4f}" for who, n in noise.items()))
    if args.pictures:
        both = np.concatenate([0.5 * sum(ours), 0.5 * sum(theirs)], axis=1)
        srgb = np.where(both <= 0.0031308, 12.92 * both, 1.055 * np.maximum(both, 1e-9) ** (1 / 2.4) - 0.055)
        Image.fromarray((255 * srgb.clip(0, 1) + 0.5).astype(np.uint8)).save(args.pictures / f"mitsuba-{name}.png")
    return noise


def relative_noise(a, b):
    """Half the mean square of the difference of two pictures, relative to their light as in `rondure compare`."""
    level = 0.5 * (a + b)
    return float(np.mean((a - b) ** 2 / (level**2 + 0.01))) / 2


def race(name, args, noise):
    import drjit as dr

    dr.set_thread_count(1)
    out = args.work / "race.png"
    scenes = {}
    for variant in args.variants:
        try:
            scenes[variant], film = prepare(name, args, variant)
            np.array(mi.render(scenes[variant], spp=args.race_spp))
        except Exception as error:
            print(f"{variant} does not run: {error}")
            scenes.pop(variant, None)
    samples = film["size"][0] * film["size"][1] * args.race_spp
    times = {who: [] for who in [*WAYS, *scenes]}
    for i in range(args.rounds):
        for way in WAYS:
            times[way].append(rondure(name, args, way, args.race_spp, i, out))
        for variant, scene in scenes.items():
            mi.set_variant(variant)
            start = time.process_time()
            np.array(mi.render(scene, spp=args.race_spp, seed=i))
            times[variant].append(time.process_time() - start)
    rates = {who: samples / statistics.median(t) for who, t in times.items() if t}
    for who, rate in rates.items():
        spread = f"{samples / max(times[who]) / 1e6:.3f} to {samples / min(times[who]) / 1e6:.3f}"
        print(f"{name}: {who} {rate / 1e6:.3f} million samples a second ({spread})")
    for variant in scenes:
        for way in WAYS:
            fast = rates[way] / rates[variant]
            quiet = fast * noise["mitsuba"] / noise[way]
            print(f"{name}: {way} is {fast:.2f} times as fast as {variant}, and {quiet:.2f} times to the same noise")


if __name__ == "__main__":
    main()
