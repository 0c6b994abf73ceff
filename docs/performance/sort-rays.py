"""Sorts the rays of a file by octant and by the Morton order of their origins, as a pass between two bounces could.

    python3 sort-rays.py RAYS.npy SORTED.npy WIDTH

RAYS.npy is float32, N x 6: origin, direction. WIDTH is the width of the streams' textures, which `raystep plan` prints;
it must divide N, and both sides be multiples of 8: 64 consecutive rays then belong to one workgroup of the fused kernel.
"""
import sys

import numpy as np

rays = np.load(sys.argv[1])
width = int(sys.argv[3])
height = len(rays) // width
assert width * height == len(rays) and width % 8 == 0 and height % 8 == 0, "no whole tiles of 8 x 8 texels"
origin, direction = rays[:, :3], rays[:, 3:6]
low, high = origin.min(0), origin.max(0)
cell = np.clip((origin - low) / (high - low).max() * 1024, 0, 1023).astype(np.uint64)


def spread(bits):
    """Bit i of ten to bit 3i."""
    bits = (bits | bits << 16) & 0x030000FF
    bits = (bits | bits << 8) & 0x0300F00F
    bits = (bits | bits << 4) & 0x030C30C3
    return (bits | bits << 2) & 0x09249249


morton = spread(cell[:, 0]) | spread(cell[:, 1]) << 1 | spread(cell[:, 2]) << 2
octant = sum((direction[:, axis] < 0).astype(np.uint64) << axis for axis in range(3))
order = np.argsort(octant << 30 | morton, kind="stable")
y, x = np.mgrid[0:height, 0:width]
tiled = ((y // 8 * (width // 8) + x // 8) * 64 + y % 8 * 8 + x % 8).ravel()
np.save(sys.argv[2], np.ascontiguousarray(rays[order][tiled]))
