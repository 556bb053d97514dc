"""A scene file of Rondure as a dictionary for Mitsuba: as much of the format as the scenes beside this file use.

What turns becomes a fine mesh. Both follow the same light: the same lamps, materials and number of scatterings."""

import math
import subprocess
import tomllib
from pathlib import Path

# Complex indices of refraction, as crates/rondure-scene/src/scene/material.rs has them.
METALS = {
    "gold": ([0.143119, 0.374957, 1.442479], [3.983160, 2.385721, 1.603215]),
    "copper": ([0.200438, 0.924033, 1.102212], [3.912949, 2.452848, 2.142188]),
}


def rgb(value, kind="rgb"):
    return {"type": kind, "value": [float(x) for x in value]}


def light(table, default=(1, 1, 1)):
    factor = table.get("intensity", 1)
    return [factor * c for c in table.get("color", default)]


def material(table):
    kind = table.get("type", "matte")
    if kind == "matte":
        bsdf = {"type": "diffuse", "reflectance": rgb(table["color"])}
    elif kind == "glass":
        return {"type": "dielectric", "int_ior": table["ior"], "ext_ior": 1.0}
    elif kind == "metal":
        eta, k = METALS[table["metal"]]
        bsdf = {
            "type": "roughconductor",
            "distribution": "ggx",
            "alpha": table["roughness"] ** 2,
            "eta": rgb(eta),
            "k": rgb(k),
        }
    else:
        raise ValueError(f"no counterpart of {kind}")
    return {"type": "twosided", "bsdf": bsdf}


def mesh(profile, folder, binaries, along, around):
    out = folder / f"{profile.stem}.ply"
    command = [binaries / "examples" / "mesh", profile, out, "--along", along, "--around", around]
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL)
    return str(out)


def load(mi, path, work, binaries, along=64, around=720):
    """The dictionary, and the film's settings."""
    text = tomllib.loads(Path(path).read_text())
    film, camera = text["film"], text["camera"]
    transform = mi.ScalarTransform4f
    to = lambda at, normal: transform().look_at(
        origin=at,
        target=[a + n for a, n in zip(at, normal)],
        up=[0, 0, 1] if abs(normal[2]) < 0.9 * math.hypot(*normal) else [0, 1, 0],
    )
    scene = {
        "type": "scene",
        # A path of n scatterings has n + 1 edges; a depth of d allows d + 1 scatterings. Light is ended at random from
        # the fourth surface on.
        "integrator": {"type": "path", "max_depth": film["depth"] + 2, "rr_depth": 4},
        "camera": {
            "type": "perspective",
            "fov": camera["fov"],
            "fov_axis": "y",
            "near_clip": 0.01,
            "to_world": transform().look_at(origin=camera["eye"], target=camera["look_at"], up=[0, 0, 1]),
            "film": {
                "type": "hdrfilm",
                "width": film["size"][0],
                "height": film["size"][1],
                "rfilter": {"type": "box"},
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        },
    }
    if "sky" in text:
        scene["sky"] = {"type": "constant", "radiance": rgb(light(text["sky"]))}
    for i, lamp in enumerate(text.get("light", [])):
        at = lamp["position"]
        way = lamp.get("direction") or [b - a for a, b in zip(at, lamp["look_at"])]
        scene[f"lamp{i}"] = {
            "type": "disk",
            "to_world": to(at, way) @ transform().scale(lamp["radius"]),
            "bsdf": {"type": "diffuse", "reflectance": rgb([0, 0, 0])},
            "emitter": {"type": "area", "radiance": rgb(light(lamp))},
        }
    for i, thing in enumerate(text["object"]):
        at = thing.get("position", [0, 0, 0])
        bsdf = material(text["materials"][thing["material"]])
        if thing.get("type") == "rectangle":
            normal, half = thing.get("normal", [0, 0, 1]), [0.5 * x for x in thing["size"]]
            # Rondure turns z to the normal the shortest way; for normals along x that puts the first edge upright.
            if abs(normal[0]) > 0.5:
                turn = transform().rotate([0, 1, 0], 90 * normal[0])
            elif abs(normal[1]) > 0.5:
                turn = transform().rotate([1, 0, 0], -90 * normal[1])
            else:
                turn = transform().rotate([1, 0, 0], 0 if normal[2] > 0 else 180)
            shape = {
                "type": "rectangle",
                "to_world": transform().translate(at) @ turn @ transform().scale([*half, 1]),
            }
        else:
            profile = (Path(path).parent / thing["profile"]["file"]).resolve()
            shape = {
                "type": "ply",
                "filename": mesh(profile, work, binaries, along, around),
                "to_world": transform().translate(at),
            }
        scene[f"object{i}"] = {**shape, "bsdf": bsdf}
    return scene, film
