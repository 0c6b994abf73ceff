"""Pictures of scenes.json by Mitsuba 3 (Jakob et al. 2022): writes references.csv, with which tests/tests/mitsuba.rs compares
pictures by --integrator path.

    python3 -m venv mi && mi/bin/pip install mitsuba==3.9.1 numpy
    DRJIT_LIBLLVM_PATH=.../libLLVM.so.19.1 mi/bin/python tests/data/mitsuba/make.py     # on 2 cores 4 min

The variant is llvm_ad_rgb, which needs LLVM's library: 19 works, 15 is too old for Mitsuba 3.9.1. Geometry, materials and their
factors are read from scenes/*.gltf and *.glb by the reader below, not by raystep's.

A reference is the mean of 4x4 pixels of 64x64, box filter, and its standard error by 64 renderings with other seeds. Units are
those of the light: radiance. The two programs agree on the following, or are made to:

* Lights. raystep's point light has the intensity colour x intensity (W/sr), its directional light that illuminance, and emissive
  surfaces that radiance: Mitsuba's point, directional and area emitters have the same units, and RGB variants convert no colours.
  A spot's falloff differs (KHR_lights_punctual: squared, by the cosine of the angle; Mitsuba: linear, by the angle), so no
  scene has one.
* The sky of a scene that has lights is constant in raystep: SKY. Both programs see it at any distance.
* Depth. Mitsuba's max_depth counts segments of a path; raystep's counts bounces: one fewer.
* Roulette. Mitsuba's is left out (rr_depth). Neither changes the mean.
* Field of view. fov_axis is y: raystep's angle is vertical, as glTF's.
* Sides. Lambertian surfaces and mirrors reflect on both sides in raystep: twosided. Surfaces emit on their front.
* Glass. The outside has an index of 1, not of air (Mitsuba's default, 1.000277). Refracted light is multiplied by the base
  colour, reflected light is not. Mitsuba also scales radiance by the squared ratio of indices, which cancels where a path
  leaves the glass again: no scene has light or other surfaces within glass.
* Normals. Both shade by the plane of the triangle: with interpolated normals, raystep mends or ends paths that would lead to the
  wrong side of a triangle (Mitsuba lets them through), so pictures differ a little at silhouettes.
"""

import base64
import json
import os
import struct
import sys
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

HERE = os.path.dirname(os.path.abspath(__file__))
SCENES = os.path.join(HERE, "..", "..", "..", "scenes")
SKY = [0.015, 0.018, 0.024]
SIDE, BLOCK = 64, 4
RENDERINGS, SAMPLES = 64, 256


def transform_of(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]), float)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def read(file):
    """Triangles (n, 3, 3) with their material, for each primitive of a file."""
    data = open(os.path.join(SCENES, file), "rb").read()
    if data[:4] == b"glTF":
        length = struct.unpack("<I", data[12:16])[0]
        gltf, buffers = json.loads(data[20:20 + length]), [data[28 + length:]]
    else:
        gltf = json.loads(data)
        buffers = [base64.b64decode(buffer["uri"].split(",")[1]) for buffer in gltf["buffers"]]

    def values(index):
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        dtype = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        assert "byteStride" not in view and "sparse" not in accessor
        at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(buffers[view["buffer"]], dtype, accessor["count"] * width, at).reshape(-1, width)

    parts = []

    def visit(index, above):
        node = gltf["nodes"][index]
        to_world = above @ transform_of(node)
        for primitive in gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            points = values(primitive["attributes"]["POSITION"]).astype(float) @ to_world[:3, :3].T + to_world[:3, 3]
            if "indices" in primitive:
                points = points[values(primitive["indices"])[:, 0]]
            parts.append((points.reshape(-1, 3, 3), gltf["materials"][primitive["material"]]))
        for child in node.get("children", []):
            visit(child, to_world)

    for root in gltf["scenes"][gltf.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    return parts


def rgb(value):
    return {"type": "rgb", "value": [float(v) for v in value]}


def bsdf_of(material):
    pbr, extensions = material["pbrMetallicRoughness"], material.get("extensions", {})
    color = pbr["baseColorFactor"][:3]
    if "KHR_materials_transmission" in extensions:
        assert "KHR_materials_volume" in extensions, "a thin sheet"
        ior = extensions["KHR_materials_ior"]["ior"]
        return {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0, "specular_transmittance": rgb(color)}
    if pbr["metallicFactor"] == 1:
        return {"type": "twosided", "of": {"type": "conductor", "material": "none", "specular_reflectance": rgb(color)}}
    return {"type": "twosided", "of": {"type": "diffuse", "reflectance": rgb(color)}}


def shape_of(triangles, bsdf, radiance, folder, name):
    mesh = mi.Mesh(name, vertex_count=3 * len(triangles), face_count=len(triangles))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = triangles.astype(np.float32).ravel()
    parameters["faces"] = np.arange(3 * len(triangles), dtype=np.uint32)
    parameters.update()
    path = os.path.join(folder, name + ".ply")
    mesh.write_ply(path)
    shape = {"type": "ply", "filename": path, "face_normals": True, "bsdf": bsdf}
    if any(radiance):
        shape["emitter"] = {"type": "area", "radiance": rgb(radiance)}
    return shape


def scene_of(row, folder):
    camera = row["camera"]
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": row["max_depth"] + 1, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov_axis": "y",
            "fov": camera["fov_degrees"],
            "to_world": mi.ScalarTransform4f().look_at(camera["eye"], camera["look_at"], [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
            "sampler": {"type": "independent"},
        },
        "sky": {"type": "constant", "radiance": rgb(SKY)},
    }
    for i, (triangles, material) in enumerate(read(row["file"])):
        glow = material.get("emissiveFactor", [0, 0, 0])
        assert not (any(glow) and material.get("doubleSided")), "an emitter on both sides"
        scene[f"part{i}"] = shape_of(triangles, bsdf_of(material), glow, folder, f"part{i}")
    if row["lamp"]:
        a, b, c, d = row["lamp"]["corners"]
        black = {"type": "twosided", "of": {"type": "diffuse", "reflectance": rgb([0, 0, 0])}}
        scene["lamp"] = shape_of(np.array([[a, b, c], [a, c, d]], float), black, row["lamp"]["radiance"], folder, "lamp")
    for i, light in enumerate(row["lights"]):
        power = rgb(np.array(light["color"]) * light["intensity"])
        if "position" in light:
            scene[f"light{i}"] = {"type": "point", "position": light["position"], "intensity": power}
        else:
            scene[f"light{i}"] = {"type": "directional", "direction": light["direction"], "irradiance": power}
    return mi.load_dict(scene)


def blocks_of(image):
    n = SIDE // BLOCK
    return np.array(image, np.float64).reshape(n, BLOCK, n, BLOCK, 3).mean(axis=(1, 3))


def main():
    lines = ["scene,x,y,r,g,b,r_error,g_error,b_error"]
    for number, row in enumerate(json.load(open(os.path.join(HERE, "scenes.json")))):
        with tempfile.TemporaryDirectory() as folder:
            scene = scene_of(row, folder)
        found = []
        for seed in range(RENDERINGS):
            found.append(blocks_of(mi.render(scene, spp=SAMPLES, seed=seed)))
            print(f"\r{row['name']}: {seed + 1} of {RENDERINGS}", end="", file=sys.stderr)
        found = np.array(found)
        mean, error = found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(RENDERINGS)
        print(f", mean {mean.mean():.6f}, largest error {(error / mean).max():.2%}", file=sys.stderr)
        for y in range(mean.shape[0]):
            for x in range(mean.shape[1]):
                numbers = [f"{v:.6g}" for v in mean[y, x]] + [f"{v:.2g}" for v in error[y, x]]
                lines.append(",".join([str(number), str(x), str(y), *numbers]))
    with open(os.path.join(HERE, "references.csv"), "w", newline="\n") as out:
        out.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
