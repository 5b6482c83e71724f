# SPDX-License-Identifier: MIT
"""Correct a folder of frames with one shared adaptation, on a dask cluster.

usage: frames.py FRAMES ILLUMINANCE.npy OUT [CONTRAST]
FRAMES holds pictures of one size; ILLUMINANCE.npy one map (H, W) for all, or (N, H, W). Workers
read their own frames, so the film need not fit in memory. To use machines of your own, give
distributed.Client the address of their scheduler.
"""

import sys
from pathlib import Path

import dask
import dask.array as da
import distributed
import lcor
import lcor.dask
import numpy as np
from PIL import Image


def read(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB"))[None]


def write(frames: np.ndarray, path: Path) -> str:
    Image.fromarray(frames[0]).save(path)
    return str(path)


def main(folder: Path, light: np.ndarray, out: Path, contrast: float) -> None:
    paths = sorted(p for p in folder.iterdir() if p.suffix in (".png", ".jpg", ".tif"))
    shape = read(paths[0]).shape
    out.mkdir(parents=True, exist_ok=True)
    frames = da.concatenate(
        [da.from_delayed(dask.delayed(read)(p), shape, np.uint8) for p in paths]
    )
    corrected = lcor.dask.correct(
        frames, light, contrast, reading="texel", space="srgb", transfer="srgb"
    )
    written = [
        dask.delayed(write)(block, out / path.name)
        for block, path in zip(corrected.to_delayed().ravel(), paths)
    ]
    for name in dask.compute(*written):
        print(name)


if __name__ == "__main__":
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster),
    ):
        main(
            Path(sys.argv[1]),
            np.load(sys.argv[2]),
            Path(sys.argv[3]),
            float(sys.argv[4]) if len(sys.argv) > 4 else 23.4,
        )
