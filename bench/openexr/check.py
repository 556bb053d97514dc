"""Reads a picture with OpenEXR's Python module and checks names and values of its layers against what the scene must show."""

import sys

import numpy as np
import OpenEXR

with OpenEXR.File(sys.argv[1], separate_channels=True) as file:
    header, channels = dict(file.header()), {name: c.pixels.copy() for name, c in file.channels().items()}

expected = "B G R Z albedo.B albedo.G albedo.R materialId normal.X normal.Y normal.Z objectId "
expected += "position.X position.Y position.Z sampleCount variance.B variance.G variance.R"
assert sorted(channels) == expected.split(), sorted(channels)
for name, values in channels.items():
    assert values.dtype == np.float32 and values.shape == (48, 64), (name, values.dtype, values.shape)

comments = header["comments"]
for line in ["scene = scene.toml", "spp = 8", "seed = 0", "filter = blackman-harris 1.5"]:
    assert line in comments.splitlines(), comments
assert header["software"].startswith("Rondure "), header["software"]


def near(name, row, column, value, error=1e-5):
    found = channels[name][row, column]
    assert abs(found - value) <= error, f"{name} at {row}, {column}: {found}, not {value}"


# A pixel is a tenth of a unit; the middle of column 32 lies at x = 0.05, that of row 24 at z = -0.05.
def place(row, column):
    return (column + 0.5 - 32) / 10, (24 - row - 0.5) / 10


for row, column in [(24, 32), (20, 30), (28, 35), (23, 26)]:
    x, z = place(row, column)
    y = -np.sqrt(1 - x * x - z * z)
    for name, value in [("position.X", x), ("position.Y", y), ("position.Z", z), ("Z", 10 + y)]:
        near(name, row, column, value)
    # The mean over the pixel's filter is near the normal in its middle.
    for name, value in [("normal.X", x), ("normal.Y", y), ("normal.Z", z)]:
        near(name, row, column, value, 0.05)
    for name, value in [("objectId", 2), ("materialId", 2), ("albedo.R", 0.8), ("albedo.G", 0.1), ("albedo.B", 0.3)]:
        near(name, row, column, value)
for name, value in [("objectId", 0), ("materialId", 0), ("albedo.R", 0), ("R", 0.5), ("G", 0.25), ("B", 2), ("variance.R", 0)]:
    near(name, 2, 2, value)
assert np.isinf(channels["Z"][2, 2])
assert (channels["sampleCount"] == 8).all()
assert (channels["variance.R"] >= 0).all() and channels["variance.R"].max() > 0
assert set(np.unique(channels["objectId"])) == {0, 2}
print(f"{sys.argv[1]}: all {len(channels)} channels as they must be")
