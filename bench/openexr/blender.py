"""Opens a picture in Blender's compositor and checks names and values of its layers against what the scene must show."""

import os
import sys
import tempfile

import bpy
import numpy as np

picture = bpy.data.images.load(os.path.abspath(sys.argv[1]))
scene = bpy.context.scene
scene.use_nodes = True
tree = scene.node_tree
tree.nodes.clear()
source = tree.nodes.new("CompositorNodeImage")
source.image = picture
target = tree.nodes.new("CompositorNodeComposite")
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"

assert picture.type == "MULTILAYER", picture.type
outputs = {output.name: output for output in source.outputs}
expected = "Alpha Combined Depth albedo materialId normal objectId position sampleCount variance"
assert sorted(outputs) == expected.split(), sorted(outputs)
for name in ["Combined", "albedo", "variance"]:
    assert outputs[name].type == "RGBA", (name, outputs[name].type)
for name in ["normal", "position"]:
    assert outputs[name].type == "VECTOR", (name, outputs[name].type)


def layer(name):
    """What the compositor makes of a layer, rows from the top."""
    tree.links.new(outputs[name], target.inputs[0])
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "layer.exr")
        bpy.ops.render.render(write_still=True)
        written = bpy.data.images.load(scene.render.filepath)
        written.colorspace_settings.name = "Non-Color"
        values = np.array(written.pixels[:]).reshape(48, 64, -1)[::-1]
        bpy.data.images.remove(written)
    return values


layers = {name: layer(name) for name in outputs}
# A pixel is a tenth of a unit; the middle of column 32 lies at x = 0.05, that of row 24 at z = -0.05.
for row, column in [(24, 32), (20, 30), (28, 35), (23, 26)]:
    x, z = (column + 0.5 - 32) / 10, (24 - row - 0.5) / 10
    y = -np.sqrt(1 - x * x - z * z)
    for name, value, error in [
        ("position", [x, y, z], 1e-5),
        ("normal", [x, y, z], 0.05),
        ("albedo", [0.8, 0.1, 0.3], 1e-5),
        ("Depth", [10 + y], 1e-5),
        ("objectId", [2], 0),
        ("materialId", [2], 0),
        ("sampleCount", [8], 0),
    ]:
        found = layers[name][row, column, : len(value)]
        assert np.abs(found - value).max() <= error, (name, row, column, found, value)
assert np.allclose(layers["Combined"][2, 2, :3], [0.5, 0.25, 2])
assert (layers["variance"][..., :3] >= 0).all() and layers["variance"][..., :3].max() > 0
assert np.isinf(layers["Depth"][2, 2, 0])
print(f"{sys.argv[1]}: all {len(layers)} layers in Blender {bpy.app.version_string} as they must be")
